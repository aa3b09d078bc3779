"""The leg on a tape: commanded and applied force, and what the motors pay (thesis Eq. 3.1, 3.2, 3.5)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction

import mpmath

from benchmarks.reference_simulator.power_series import FixedPoint, Series, SeriesTape, State

GRAVITY = Fraction("9.81")


class ForceCap(StrEnum):
    """What clips the leg force in the equations of motion."""

    NONE = "none"
    CONSTANT = "constant"
    TORQUE = "torque"


class CostForce(StrEnum):
    """Which force the motors pay for."""

    COMMANDED = "commanded"
    APPLIED = "applied"
    TORQUE_LIMITED = "torque_limited"  # the commanded force, cut to the stall torque: first set of simulations


class SwitchingRule(StrEnum):
    """When a sampled leg passes from compression to extension and back."""

    UNLATCHED = "unlatched"
    LATCHED = "latched"


class FlightGains(StrEnum):
    """The gains from lift-off on: those of compression, or the last ones of stance."""

    SOFT = "soft"
    HELD = "held"


@dataclass(frozen=True, slots=True, kw_only=True)
class LegParameters:
    """Robot, leg, controller and motors (thesis Eq. 3.1, 3.2, 3.5; 3.2.1)."""

    body_mass_kg: Fraction
    foot_mass_kg: Fraction
    rest_length_m: Fraction = Fraction("0.27")
    compression_stiffness_n_m: Fraction = Fraction(250)
    extension_stiffness_n_m: Fraction = Fraction(650)
    compression_damping_kg_s: Fraction = Fraction("0.5")
    extension_damping_kg_s: Fraction = Fraction(5)
    active_damping_kg_m: Fraction = Fraction(0)
    force_cap: ForceCap = ForceCap.TORQUE
    constant_cap_n: Fraction = Fraction(70)
    stall_torque_n_m: Fraction = Fraction(7)  # both motors
    cost_force: CostForce = CostForce.APPLIED
    upper_link_m: Fraction = Fraction("0.1")
    lower_link_m: Fraction = Fraction("0.2")
    torque_constant_n_m_a: Fraction = Fraction("0.09549296586")
    motor_resistance_ohm: Fraction = Fraction("0.186")


@dataclass(frozen=True, slots=True, kw_only=True)
class GranularParameters(LegParameters):
    """One jump on granular ground under 1 kHz sampled control (thesis 3.1.2, 3.1.3, 5.1.1).

    At time 0 the foot touches the undisturbed surface, the leg at rest length, both masses at `initial_velocity_m_s`.
    """

    body_mass_kg: Fraction = Fraction("1.75")
    foot_mass_kg: Fraction = Fraction("0.175")
    initial_velocity_m_s: Fraction = Fraction(-1)
    drop_height_m: Fraction | None = None  # body height of a drop from rest; stands in place of the initial velocity
    switching_rule: SwitchingRule = SwitchingRule.UNLATCHED
    flight_gains: FlightGains = FlightGains.SOFT
    # Soft gains can press the foot down again at the instant of lift-off. With immediate contact the stance goes on
    # then; without, contact is looked for only once the foot has risen, as in every published number.
    immediate_contact: bool = False
    tick_s: Fraction = Fraction("0.001")
    switch_compression_m: Fraction = Fraction("0.05")
    shortest_leg_m: Fraction = Fraction("0.105")
    foot_radius_m: Fraction = Fraction("0.03")
    stiffness_scale: Fraction = Fraction(1)  # kg_scale
    drag_scale: Fraction = Fraction(1)  # bg_scale
    cone_angle_rad: Fraction = Fraction("1.0472")
    recruitment_rate: Fraction = Fraction(2)  # mu
    penetration_stiffness_n_m: Fraction = Fraction(1600)  # k_sh
    depth_stress_n_m3: Fraction = Fraction(120000)  # sigma
    surrounding_mass_factor: Fraction = Fraction("2.7")  # c_g
    inertial_drag_factor: Fraction = Fraction("17.2")  # b_g
    shed_mass_kg_m: Fraction = Fraction(1)  # C
    grain_density_kg_m3: Fraction = Fraction(1000)  # rho
    packing_fraction: Fraction = Fraction("0.57")  # phi


@dataclass(frozen=True, slots=True, kw_only=True)
class HoppingParameters(LegParameters):
    """Repeated jumps under continuous control on rigid ground, or on the emulated ground of thesis 4.2.

    The start is at rest with the toe at 0 and the leg at rest length; on emulated ground the hold phase begins then.
    """

    platform: PlatformParameters | None = None  # None is rigid ground
    switch_compression_m: Fraction = Fraction("0.05")
    shortest_leg_m: Fraction = Fraction("0.105")
    velocity_tolerance_m_s: Fraction = Fraction("0.02")
    length_tolerance_m: Fraction = Fraction("0.005")
    folded_leg_m: Fraction = Fraction("0.101")
    straight_leg_m: Fraction = Fraction("0.2999")
    longest_jump_s: Fraction = Fraction(2)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformParameters:
    """The emulated ground (thesis 4.2): a massless platform that a ratchet lets sink, and the clock that lifts it."""

    stiffness_n_m: Fraction = Fraction(1603)
    damping_kg_s: Fraction = Fraction(30)
    lift_kg_m: Fraction = Fraction("46.4")
    travel_m: Fraction = Fraction("0.07")
    yield_margin_n: Fraction = Fraction(0)
    release_length_m: Fraction = Fraction("0.01")
    shortest_hold_s: Fraction = Fraction("0.05")
    release_s: Fraction = Fraction("0.01")
    reset_s: Fraction = Fraction("0.06")
    engage_s: Fraction = Fraction("0.01")


# Quantities integrated along a jump for every ground: the motors' three terms and the work of the leg on the masses.
LEG_INTEGRALS = ("heat", "mechanical", "drag", "leg_work")


@dataclass(frozen=True, slots=True)
class Gains:
    """Stiffness and damping in force; `active` is the coefficient of |v_f| for a damping that follows the foot."""

    stiffness: int
    damping: int
    active: int = 0


@dataclass(frozen=True, slots=True)
class LegSeries:
    """The leg's quantities on a tape; `cap` is None where nothing limits the force."""

    body_velocity: Series
    foot_velocity: Series
    foot_position: Series
    length: Series
    rate: Series
    commanded: Series
    applied: Series
    cap: Series | None
    states: dict[str, Series]


class Leg:
    """Writes the equations of one leg, its body and its motors on a tape."""

    def __init__(self, parameters: LegParameters, number: FixedPoint) -> None:
        self.parameters = parameters
        self.number = number
        p, of = parameters, number.of
        self.gravity = of(GRAVITY)
        self.inverse_body_mass = of(1 / p.body_mass_kg)
        self.inverse_foot_mass = of(1 / p.foot_mass_kg)
        self.foot_weight = of(p.foot_mass_kg * GRAVITY)
        self.rest_length = of(p.rest_length_m)
        self._link_difference = of(p.lower_link_m**2 - p.upper_link_m**2)
        self._four_upper_squared = of(4 * p.upper_link_m**2)
        self._heat_factor = of(p.motor_resistance_ohm / (2 * p.torque_constant_n_m_a**2))
        self._drag_factor = of(p.torque_constant_n_m_a**2 / p.motor_resistance_ohm)

    def write(
        self,
        tape: SeriesTape,
        state: State,
        gains: Gains,
        saturation: int,
        *,
        fixed_foot: bool = False,
        foot: tuple[Series, Series] | None = None,
        motors: bool = True,
    ) -> LegSeries:
        """Body, leg and motors from `state` on; the caller writes the foot's acceleration.

        `saturation` is the sign of the force where it exceeds the cap, else 0. A `fixed_foot` stands still; `foot`
        gives position and velocity of one whose motion is prescribed. Without `motors` no cost is integrated and no
        cap applied: beyond the straight leg there is none.
        """
        one, p = self.number.one, self.parameters
        x_b, v_b = tape.state(state["x_b"]), tape.state(state["v_b"])
        x_f, v_f = foot or (tape.state(state["x_f"]), tape.state(state["v_f"]))
        length, rate = tape.subtract(x_b, x_f), tape.subtract(v_b, v_f)
        damper = tape.multiply(rate, v_f) if gains.active else rate
        commanded = tape.combine(
            [(gains.stiffness, length), (gains.damping, rate), (-gains.active, damper)],
            -self.number.multiply(gains.stiffness, self.rest_length),
        )
        states = {"x_b": x_b, "v_b": v_b, "x_f": x_f, "v_f": v_f}
        applied, cap = commanded, None
        if motors:
            squared = tape.multiply(length, length)
            numerator = tape.combine([(one, squared)], self._link_difference)
            difference = tape.combine([(one, squared)], -self._link_difference)
            # (2 l1 r^2)^2 (1 - u^2) without its square root: J^2 = numerator^2 / span.
            span = tape.multiply(
                squared,
                tape.subtract(
                    tape.combine([(self._four_upper_squared, squared)]), tape.multiply(difference, difference)
                ),
            )
            jacobian_squared = tape.divide(tape.multiply(numerator, numerator), span)
            cap = self._cap(tape, numerator, span)
            held = commanded
            if saturation and cap is not None:
                held = tape.combine([(saturation * one, cap)])
            applied = commanded if p.cost_force is CostForce.TORQUE_LIMITED else held
            paid = commanded if p.cost_force is CostForce.COMMANDED else held
            heat = tape.divide(tape.multiply(paid, paid), jacobian_squared)
            drag = tape.multiply(jacobian_squared, tape.multiply(rate, rate))
            rates = {
                "heat": tape.combine([(self._heat_factor, heat)]),
                "mechanical": tape.combine([(-one, tape.multiply(paid, rate))]),
                "drag": tape.combine([(self._drag_factor, drag)]),
            }
            for name, power in rates.items():
                states[name] = tape.integral(state[name], power)
        states["leg_work"] = tape.integral(state["leg_work"], tape.combine([(-one, tape.multiply(applied, rate))]))
        tape.follow(x_b, v_b)
        tape.follow(v_b, tape.combine([(-self.inverse_body_mass, applied)], -self.gravity))
        if foot is None and not fixed_foot:
            tape.follow(x_f, v_f)
        return LegSeries(v_b, v_f, x_f, length, rate, commanded, applied, cap, states)

    def energy(self, state: State) -> int:
        """Kinetic and potential energy of body and foot; the leg's spring is virtual and holds none."""
        total = 0
        for mass, x, v in ((self.parameters.body_mass_kg, "x_b", "v_b"), (self.parameters.foot_mass_kg, "x_f", "v_f")):
            specific = self.number.multiply(state[v], state[v]) // 2 + self.number.multiply(self.gravity, state[x])
            total += self.number.multiply(self.number.of(mass), specific)
        return total

    def _cap(self, tape: SeriesTape, numerator: Series, span: Series) -> Series | None:
        """The largest force, or None: constant, or stall torque times |J(r)| (also where only the cost is limited)."""
        p, of = self.parameters, self.number.of
        if p.force_cap is ForceCap.TORQUE or p.cost_force is CostForce.TORQUE_LIMITED:
            jacobian = tape.divide(numerator, tape.square_root(span))
            return tape.combine([(of(p.stall_torque_n_m), jacobian)])
        if p.force_cap is ForceCap.CONSTANT:
            return tape.constant(of(p.constant_cap_n))
        return None


def saturation_guards(tape: SeriesTape, leg: LegSeries, saturation: int) -> dict[str, Series]:
    """Guards on the cap: `over` and `under` where the commanded force leaves it, `within` where it comes back."""
    if leg.cap is None:
        return {}
    if saturation:
        sign = saturation << tape.bits
        return {"within": tape.subtract(leg.cap, tape.combine([(sign, leg.commanded)]))}
    one = 1 << tape.bits
    return {
        "over": tape.subtract(leg.commanded, leg.cap),
        "under": tape.combine([(-one, leg.commanded), (-one, leg.cap)]),
    }


class Ground:
    """The ground's constants, and its reaction on a foot that moves down in virgin material."""

    def __init__(self, parameters: GranularParameters, number: FixedPoint) -> None:
        p, of = parameters, number.of
        self.number = number
        self.gravity = of(GRAVITY)
        self.foot_mass = of(p.foot_mass_kg)
        multiply, divide = number.multiply, number.divide
        pi = number.evaluate(lambda: mpmath.pi)
        self._radius = of(p.foot_radius_m)
        self._slope = number.evaluate(lambda mu, theta: mu / mpmath.tan(theta), p.recruitment_rate, p.cone_angle_rad)
        self._pi = pi
        self.cone_depth = divide(self._radius, self._slope)
        self._disk = multiply(pi, of(p.foot_radius_m**2))
        self._full_volume = divide(multiply(pi, of(p.foot_radius_m**3)), 3 * self._slope)
        # K = penetration V + stress z (disk + V);  D = drag (grains A + shed);  m_a = grains V + shed z
        self._penetration = divide(of(p.stiffness_scale * p.penetration_stiffness_n_m), self._disk)
        self._stress = number.evaluate(
            lambda stress, theta: stress / mpmath.cos(theta), p.stiffness_scale * p.depth_stress_n_m3, p.cone_angle_rad
        )
        self._drag = of(p.drag_scale * p.inertial_drag_factor * p.surrounding_mass_factor)
        self._grains = of(p.packing_fraction * p.grain_density_kg_m3 * p.recruitment_rate)
        self._shed = of(p.shed_mass_kg_m)

    def area_and_volume(self, tape: SeriesTape, depth: Series, *, cone_complete: bool) -> tuple[Series, Series]:
        """Flat area left under the foot and its integral over depth, as series; constant once the cone is complete."""
        if cone_complete:
            return tape.constant(0), tape.constant(self._full_volume)
        radius, slope = self._radius, self._slope
        multiply = self.number.multiply
        left = tape.combine([(-slope, depth)], radius)
        area = tape.combine([(self._pi, tape.multiply(left, left))])
        # V = pi z (R^2 - q R z + q^2 z^2 / 3)
        squared = tape.multiply(depth, depth)
        bracket = tape.combine(
            [(-multiply(slope, radius), depth), (multiply(slope, slope) // 3, squared)], multiply(radius, radius)
        )
        return area, tape.combine([(self._pi, tape.multiply(depth, bracket))])

    def stiffness_force(self, tape: SeriesTape, depth: Series, volume: Series) -> Series:
        """The hydrostatic force K(z) in newtons."""
        loaded = tape.combine([(self.number.one, volume)], self._disk)
        return tape.combine([(self._penetration, volume), (self._stress, tape.multiply(depth, loaded))])

    def added_mass(self, tape: SeriesTape, depth: Series, volume: Series) -> Series:
        """The mass m_a(z) of the grains that move with the foot, in kilograms."""
        return tape.combine([(self._grains, volume), (self._shed, depth)])

    def added_mass_slope(self, tape: SeriesTape, area: Series) -> Series:
        """The derivative of the added mass with depth, in kg/m."""
        return tape.combine([(self._grains, area)], self._shed)

    def drag_coefficient(self, tape: SeriesTape, slope: Series) -> Series:
        """The inertial drag D(z), in N / (m/s)^2."""
        return tape.combine([(self._drag, slope)])


class Phase(StrEnum):
    """What the ratchet and the platform's motors are doing; rigid ground is in `RIGID` for ever."""

    HOLD = "hold"
    RELEASE = "release"
    RESET = "reset"
    ENGAGE = "engage"
    RIGID = "rigid"


_FOLLOWING = {Phase.RELEASE: Phase.RESET, Phase.RESET: Phase.ENGAGE, Phase.ENGAGE: Phase.HOLD}


class Platform:
    """A massless platform at `position` (metres below 0 are negative) with the clock of its state machine."""

    def __init__(self, parameters: PlatformParameters | None, number: FixedPoint) -> None:
        p = parameters or PlatformParameters()
        of = number.of
        self.number = number
        self.phase = Phase.RIGID if parameters is None else Phase.HOLD
        self.position = 0
        self.elapsed = 0
        self.stiffness, self.damping, self.lift = of(p.stiffness_n_m), of(p.damping_kg_s), of(p.lift_kg_m)
        self.travel, self.yield_margin = of(p.travel_m), of(p.yield_margin_n)
        self.release_length = of(p.release_length_m)
        self._reset_from = 0
        self._reset_rate = of(1 / p.reset_s)
        self._shortest_hold = of(p.shortest_hold_s)
        self._length: dict[Phase, Fraction] = {
            Phase.RELEASE: p.release_s,
            Phase.RESET: p.reset_s,
            Phase.ENGAGE: p.engage_s,
        }

    @property
    def time_left(self) -> int | None:
        """Time to the end of the phase, or to the end of the shortest hold; None where no clock runs."""
        if self.phase in _FOLLOWING:
            return self.number.of(self._length[self.phase]) - self.elapsed
        if self.phase is Phase.HOLD and self.elapsed < self._shortest_hold:
            return self._shortest_hold - self.elapsed
        return None

    @property
    def may_release(self) -> bool:
        """Whether the ratchet has held for as long as it must before a release."""
        return self.phase is Phase.HOLD and self.elapsed >= self._shortest_hold

    def enter(self, phase: Phase) -> None:
        """Begin a phase; the reset starts from where the platform is."""
        self.phase, self.elapsed = phase, 0
        if phase is Phase.RESET:
            self._reset_from = self.position

    def end_phase(self) -> None:
        """What happens when the clock of the phase runs out."""
        if self.phase is Phase.HOLD:
            self.elapsed = self._shortest_hold
            return
        if self.phase is Phase.RESET:
            self.position = 0
        self.enter(_FOLLOWING[self.phase])

    def path(self, tape: SeriesTape) -> tuple[Series, Series, Series]:
        """Position, velocity and acceleration of a platform that does not yield: it is reset, or it rests."""
        if self.phase is not Phase.RESET:
            return tape.constant(self.position), tape.constant(0), tape.constant(0)
        one, multiply = self.number.one, self.number.multiply
        share = tape.state(multiply(self.elapsed, self._reset_rate))
        tape.follow(share, tape.constant(self._reset_rate))
        square = tape.multiply(share, share)
        cube = tape.multiply(square, share)
        # 1 - 10 s^3 + 15 s^4 - 6 s^5 and its derivatives
        factor = tape.combine([(6 * one, square), (-15 * one, share)], 10 * one)
        start, rate = self._reset_from, self._reset_rate
        position = tape.combine([(-start, tape.multiply(cube, factor))], start)
        rest = tape.combine([(-one, share)], one)
        velocity = tape.combine([(-30 * multiply(start, rate), tape.multiply(square, tape.multiply(rest, rest)))])
        bend = tape.multiply(tape.multiply(share, rest), tape.combine([(-2 * one, share)], one))
        return position, velocity, tape.combine([(-60 * multiply(start, multiply(rate, rate)), bend)])

    def reaction(self, tape: SeriesTape, position: Series, velocity: Series) -> Series:
        """The force on the foot while the platform yields downward: -k x - alpha v + beta v^2."""
        squared = tape.multiply(velocity, velocity)
        return tape.combine([(-self.stiffness, position), (-self.damping, velocity), (self.lift, squared)])


class SampledController:
    """Gains in force and the tick they were set at; tick 0 is touchdown."""

    def __init__(self, parameters: GranularParameters, number: FixedPoint) -> None:
        p, of = parameters, number.of
        self._parameters, self._number = parameters, number
        self._soft = Gains(of(p.compression_stiffness_n_m), of(p.compression_damping_kg_s))
        self.gains = self._soft
        self._extending = False
        self._tick = 0

    @property
    def next_tick_time(self) -> int:
        """When the gains may change next."""
        return self._number.of((self._tick + 1) * self._parameters.tick_s)

    def tick(self, state: State) -> None:
        """Let the next tick pass in `state`."""
        self._tick += 1
        self.sample(state)

    def pass_until(self, time: int) -> None:
        """Let the ticks up to `time` pass without effect: the foot was in the air."""
        while self.next_tick_time <= time:
            self._tick += 1

    def lift_off(self) -> None:
        """The gains of flight, from the instant of lift-off."""
        if self._parameters.flight_gains is FlightGains.SOFT:
            self._extending, self.gains = False, self._soft

    def sample(self, state: State) -> None:
        """Set the gains by the state as it is now."""
        p, of = self._parameters, self._number.of
        length, rate = state["x_b"] - state["x_f"], state["v_b"] - state["v_f"]
        if p.switching_rule is SwitchingRule.UNLATCHED:
            pushing_off = rate > 0 and state["x_f"] < 0 and state["v_b"] > 0
            self._extending = pushing_off or length < of(p.shortest_leg_m)
        elif self._extending:
            self._extending = length < of(p.rest_length_m)
        else:
            self._extending = of(p.rest_length_m) - length > of(p.switch_compression_m) and rate >= 0
        if not self._extending:
            self.gains = self._soft
            return
        sampled = self._number.multiply(of(p.active_damping_kg_m), max(-state["v_f"], 0))
        self.gains = Gains(of(p.extension_stiffness_n_m), of(p.extension_damping_kg_s) + sampled)
