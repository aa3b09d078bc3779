"""The leg on a tape: commanded and applied force, and what the motors pay (thesis Eq. 3.1, 3.2, 3.5)."""

from dataclasses import dataclass

from benchmarks.reference_simulator.fixed_point import FixedPoint
from benchmarks.reference_simulator.parameters import GRAVITY, CostForce, ForceCap, LegParameters
from benchmarks.reference_simulator.power_series import Series, SeriesTape

State = dict[str, int]
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
