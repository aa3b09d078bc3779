"""One jump on granular ground (thesis 3.1.2, 3.1.3): intruding, jammed and flight under a 1 kHz clock."""

from collections.abc import Callable
from fractions import Fraction

import mpmath

from benchmarks.reference_simulator.leg import (
    GRAVITY,
    LEG_INTEGRALS,
    GranularParameters,
    Ground,
    Leg,
    LegSeries,
    SampledController,
    saturation_guards,
)
from benchmarks.reference_simulator.power_series import FixedPoint, Series, SeriesTape, State, advance, setting
from benchmarks.reference_simulator.result import JumpRecord, ReferenceResult

GROUND_INTEGRALS = ("ground_work", "recruited_weight_work", "recruited_kinetic_energy")
LONGEST_STANCE_S = Fraction(2)
LONGEST_FLIGHT_STEP_S = Fraction("0.004")
# The kinematics are singular at 0.1 and 0.3 m: a stance ends, and a flight is no longer charged for, just before.
FOLDED_LEG_M = Fraction("0.1001")
STRAIGHT_LEG_M = Fraction("0.2999")


def reference_jump(parameters: GranularParameters, digits: int = 30, order: int = 30) -> ReferenceResult:
    """One jump on granular ground to `digits` digits, by Taylor series of `order`, which does not change the digits.

    Raises ArithmeticError where the outcome hangs on a tangency.
    """
    return _GranularJump(parameters, FixedPoint.for_digits(digits), order).run(digits)


class _GranularJump:
    """The walk through the modes."""

    def __init__(self, parameters: GranularParameters, number: FixedPoint, order: int) -> None:
        self.parameters, self.number, self.order = parameters, number, order
        p, of = parameters, number.of
        self.leg, self.ground = Leg(p, number), Ground(p, number)
        start = of(p.initial_velocity_m_s)
        if p.drop_height_m is not None:
            start = -number.evaluate(mpmath.sqrt, 2 * GRAVITY * (p.drop_height_m - p.rest_length_m))
        self.state: State = dict.fromkeys((*LEG_INTEGRALS, *GROUND_INTEGRALS), 0)
        self.state |= {"x_b": of(p.rest_length_m), "v_b": start, "x_f": 0, "v_f": start}
        self.controller = SampledController(p, number)
        self.record = JumpRecord(self.leg.energy(self.state))
        self.saturation = 0
        self.cone_complete = self.risen = self.cleared = self.beyond_straight = False
        self._enter("intruding")

    def run(self, digits: int) -> ReferenceResult:
        """The jump from touchdown to apex."""
        self.controller.sample(self.state)
        limit = self.number.of(LONGEST_STANCE_S)
        record, state = self.record, self.state
        while record.outcome is None:
            self._step()
            if self.mode != "flight" and record.time >= limit:
                record.outcome = "no_liftoff"
        work = state["leg_work"] - state["ground_work"]
        work += state["recruited_weight_work"] + state["recruited_kinetic_energy"]
        residual = self.leg.energy(state) - record.energy - work
        return record.result(record.liftoff or state, residual, self.number, digits)

    def _step(self) -> None:
        number, record = self.number, self.record
        tape = SeriesTape(number.bits, self.order)
        leg = self.leg.write(
            tape,
            self.state,
            self.controller.gains,
            self.saturation,
            fixed_foot=self.mode == "jammed",
            motors=not self.beyond_straight,
        )
        guards = saturation_guards(tape, leg, self.saturation)
        modes = {"intruding": self._intruding, "jammed": self._jammed, "flight": self._flight}
        guards |= modes[self.mode](tape, leg)
        if not self.beyond_straight:
            guards["straight"] = tape.combine([(number.one, leg.length)], -number.of(STRAIGHT_LEG_M))
            guards["folded"] = tape.combine([(-number.one, leg.length)], number.of(FOLDED_LEG_M))
        tick_time = None if self.mode == "flight" else self.controller.next_tick_time
        step = number.of(LONGEST_FLIGHT_STEP_S) if tick_time is None else tick_time - record.time
        result = advance(tape, self.state, leg.states, guards, step)
        record.time += result.elapsed
        if self.mode == "intruding":
            record.deepest = max(record.deepest, -self.state["x_f"])
        if result.fired is not None:
            self._events()[result.fired]()
        elif result.complete and tick_time is not None:
            record.time = tick_time
            self.controller.tick(self.state)

    def _intruding(self, tape: SeriesTape, leg: LegSeries) -> dict[str, Series]:
        """Foot and recruited grains move down together."""
        ground, one = self.ground, self.number.one
        depth = tape.combine([(-one, leg.foot_position)])
        speed = tape.combine([(-one, leg.foot_velocity)])
        area, volume = ground.area_and_volume(tape, depth, cone_complete=self.cone_complete)
        added, slope = ground.added_mass(tape, depth, volume), ground.added_mass_slope(tape, area)
        squared = tape.multiply(speed, speed)
        drag = tape.multiply(ground.drag_coefficient(tape, slope), squared)
        reaction = tape.combine([(one, ground.stiffness_force(tape, depth, volume)), (one, drag)])
        mass = tape.combine([(one, added)], ground.foot_mass)
        push = tape.combine([(one, leg.applied), (one, reaction)])
        tape.follow(leg.foot_velocity, tape.combine([(one, tape.divide(push, mass))], -ground.gravity))
        rates = (
            tape.multiply(reaction, speed),
            tape.combine([(ground.gravity, tape.multiply(added, speed))]),
            tape.combine([(one // 2, tape.multiply(slope, tape.multiply(squared, speed)))]),
        )
        for name, rate in zip(GROUND_INTEGRALS, rates, strict=True):
            leg.states[name] = tape.integral(self.state[name], rate)
        guards = {"stopped": tape.combine([(one, leg.foot_velocity)])}
        if not self.cone_complete:
            guards["cone"] = tape.combine([(one, depth)], -ground.cone_depth)
        return guards

    def _jammed(self, tape: SeriesTape, leg: LegSeries) -> dict[str, Series]:
        """The foot rests in the pit that it has made."""
        stiffness, added_mass = self._at_rest()
        weight = self.number.multiply(self.ground.foot_mass + added_mass, self.ground.gravity)
        one = self.number.one
        return {
            "lift-off": tape.combine([(one, leg.applied)], -self.leg.foot_weight),
            "yield": tape.combine([(-one, leg.applied)], weight - stiffness),
        }

    def _flight(self, tape: SeriesTape, leg: LegSeries) -> dict[str, Series]:
        """No ground: body and foot fall, tied by the leg."""
        one, deepest = self.number.one, self.record.deepest
        tape.follow(leg.foot_velocity, tape.combine([(self.leg.inverse_foot_mass, leg.applied)], -self.leg.gravity))
        guards = {"apex": tape.combine([(-one, leg.body_velocity)])}
        if not self.risen:
            guards["risen"] = tape.combine([(one, leg.foot_position)], deepest)
        elif not self.cleared:
            guards["contact"] = tape.combine([(-one, leg.foot_position)], -deepest)
            guards["cleared"] = tape.combine([(one, leg.foot_position)])
        return guards

    def _events(self) -> dict[str, Callable[[], None]]:
        straight = setting(self.record, outcome="leg_straight")
        if self.mode == "flight":
            straight = setting(self, beyond_straight=True, saturation=0)
        return {
            "over": setting(self, saturation=1),
            "under": setting(self, saturation=-1),
            "within": setting(self, saturation=0),
            "cone": setting(self, cone_complete=True),
            "risen": setting(self, risen=True),
            "cleared": setting(self, cleared=True),
            "stopped": self._stop,
            "yield": lambda: self._enter("intruding"),
            "lift-off": self._lift_off,
            "contact": self._touch,
            "apex": self._reach_apex,
            "straight": straight,
            "folded": setting(self.record, outcome="leg_folded"),
        }

    def _enter(self, mode: str) -> None:
        self.mode = mode
        self.record.enter(mode)

    def _stop(self) -> None:
        self.state["v_f"] = 0
        self._enter("jammed")

    def _lift_off(self) -> None:
        self.record.lift_off(self.state)
        self.controller.lift_off()
        self.risen = self.parameters.immediate_contact
        self._enter("flight")

    def _touch(self) -> None:
        """The foot is back in its pit while the body still rises: the stance goes on.

        The grains join at the foot's velocity: the energy they bring is booked as that of recruited grains.
        """
        if self.beyond_straight:
            self.record.outcome = "leg_straight"
        _, added_mass = self._at_rest()
        squared = self.number.multiply(self.state["v_f"], self.state["v_f"])
        self.state["recruited_kinetic_energy"] += self.number.multiply(added_mass, squared) // 2
        self.controller.pass_until(self.record.time)
        self._enter("intruding")

    def _reach_apex(self) -> None:
        self.record.apex = self.state["x_b"]
        self.record.outcome = "apex"

    def _at_rest(self) -> tuple[int, int]:
        """Stiffness force and added mass at the deepest point."""
        tape = SeriesTape(self.number.bits, 0)
        depth = tape.constant(self.record.deepest)
        _, volume = self.ground.area_and_volume(tape, depth, cone_complete=self.cone_complete)
        stiffness = self.ground.stiffness_force(tape, depth, volume)
        added_mass = self.ground.added_mass(tape, depth, volume)
        tape.run(0)
        return stiffness[0], added_mass[0]
