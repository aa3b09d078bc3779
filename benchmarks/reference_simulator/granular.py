"""One jump on granular ground (thesis 3.1.2, 3.1.3, 5.1.1): intruding, jammed and flight under a sampled controller.

At time 0 the foot touches the undisturbed surface, the leg at rest length, both masses at one velocity.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TypeVar

import mpmath

from benchmarks.reference_simulator.leg import GRAVITY, Gains, Guards, LegSeries, Walk
from benchmarks.reference_simulator.power_series import Series, Tape, advance, bits_for, evaluate
from benchmarks.reference_simulator.result import ReferenceResult

LONGEST_STANCE_S = Fraction(2)
LONGEST_FLIGHT_STEP_S = Fraction("0.004")
# The kinematics are singular at 0.1 and 0.3 m: a stance ends, and a flight is no longer charged for, just before.
FOLDED_LEG_M = Fraction("0.1001")
STRAIGHT_LEG_M = Fraction("0.2999")

V = TypeVar("V", Series, Fraction)


def reference_jump(
    effects: frozenset[str], parameters: Mapping[str, Fraction], digits: int = 30, order: int = 30
) -> ReferenceResult:
    """One jump on granular ground to `digits` digits, by Taylor series of `order`, which does not change the digits.

    Without `contact_once_risen` soft gains that press the foot down again at the instant of lift-off let the stance go
    on. Raises ArithmeticError where the outcome hangs on a tangency.
    """
    return _GranularJump(effects, parameters, bits_for(digits), order).run(digits)


class _GranularJump(Walk):
    integrals = ("ground_work", "recruited_weight_work", "recruited_kinetic_energy")

    def __init__(self, effects: frozenset[str], parameters: Mapping[str, Fraction], bits: int, order: int) -> None:
        super().__init__(effects, parameters, bits, order)
        p, radius = parameters, parameters["foot_radius"]
        squared = p["initial_velocity"] ** 2 + 2 * GRAVITY * p["initial_height"]
        start = -evaluate(bits, mpmath.sqrt, squared)
        self.state |= {"v_b": start, "v_f": start}
        # K = penetration V + stress z (disk + V);  D = drag (grains A + shed);  m_a = grains V + shed z
        self.pi = evaluate(bits, lambda: +mpmath.pi)
        self.slope = p["mu"] / evaluate(bits, mpmath.tan, p["cone_angle"])
        self.disk = self.pi * radius**2
        self.cone_depth, self.cone_volume = radius / self.slope, self.disk * radius / (3 * self.slope)
        self.penetration = p["kg_scale"] * p["k_sh"] / self.disk
        self.stress = p["kg_scale"] * p["sigma"] / evaluate(bits, mpmath.cos, p["cone_angle"])
        self.drag = p["bg_scale"] * p["b_g"] * p["c_g"]
        self.grains, self.shed = p["phi"] * p["rho"] * p["mu"], p["added_mass_constant"]
        self.soft = self.gains = Gains(p["k_compression"], p["b_compression"])
        self.tick = 0
        self.extending = self.cone_complete = self.risen = self.cleared = self.beyond_straight = False
        self.begin()
        self.enter("intruding")

    def run(self, digits: int) -> ReferenceResult:
        """The jump from touchdown to apex."""
        self._sample()
        record, state = self.record, self.state
        while record.outcome is None:
            self._step()
            if self.mode != "flight" and record.time >= LONGEST_STANCE_S:
                record.outcome = "no_liftoff"
        work = state["leg_work"] - state["ground_work"]
        work += state["recruited_weight_work"] + state["recruited_kinetic_energy"]
        return record.result(record.liftoff or state, self.energy() - record.energy - work, digits)

    def _step(self) -> None:
        record, tape = self.record, Tape(self.bits, self.order)
        leg = self.leg(tape, self.gains, fixed_foot=self.mode == "jammed", motors=not self.beyond_straight)
        guards = self.saturation_guards(leg)
        modes = {"intruding": self._intruding, "jammed": self._jammed, "flight": self._flight}
        guards |= modes[self.mode](tape, leg)
        if not self.beyond_straight:
            guards |= {"straight": leg.length - STRAIGHT_LEG_M, "folded": FOLDED_LEG_M - leg.length}
        tick_time = None if self.mode == "flight" else self._next_tick_time
        step = LONGEST_FLIGHT_STEP_S if tick_time is None else tick_time - record.time
        result = advance(tape, self.state, leg.states, guards, step)
        record.time += result.elapsed
        if self.mode == "intruding":
            record.deepest = max(record.deepest, -self.state["x_f"])
        if result.fired is not None:
            self.events()[result.fired]()
        elif result.complete and tick_time is not None:
            record.time = tick_time
            self.tick += 1
            self._sample()

    @property
    def _next_tick_time(self) -> Fraction:
        return (self.tick + 1) / self.p["control_rate"]

    def _sample(self) -> None:
        """Set the gains by the state as it is now."""
        p, state = self.p, self.state
        length, rate = state["x_b"] - state["x_f"], state["v_b"] - state["v_f"]
        if "latched_switching" not in self.effects:
            pushing_off = rate > 0 and state["x_f"] < 0 and state["v_b"] > 0
            self.extending = pushing_off or length < p["guard_length"]
        elif self.extending:
            self.extending = length < p["rest_length"]
        else:
            self.extending = p["rest_length"] - length > p["switch_compression"] and rate >= 0
        sampled = p["b_extension"] + p["b_ad"] * max(-state["v_f"], Fraction(0))
        self.gains = Gains(p["k_extension"], sampled) if self.extending else self.soft

    def _area_and_volume(self, depth: V) -> tuple[V, V]:
        """Flat area left under the foot and its integral over depth; constant once the cone is complete."""
        if self.cone_complete:
            return 0 * depth, 0 * depth + self.cone_volume
        radius, slope = self.p["foot_radius"], self.slope
        left = radius - slope * depth
        # V = pi z (R^2 - q R z + q^2 z^2 / 3)
        bracket = radius**2 - slope * radius * depth + slope**2 / 3 * (depth * depth)
        return self.pi * (left * left), self.pi * (depth * bracket)

    def _stiffness_force(self, depth: V, volume: V) -> V:
        return self.penetration * volume + self.stress * (depth * (volume + self.disk))

    def _added_mass(self, depth: V, volume: V) -> V:
        return self.grains * volume + self.shed * depth

    def _intruding(self, tape: Tape, leg: LegSeries) -> Guards:
        """Foot and recruited grains move down together."""
        depth, speed = -leg.foot_position, -leg.foot_velocity
        area, volume = self._area_and_volume(depth)
        added, slope = self._added_mass(depth, volume), self.grains * area + self.shed
        squared = speed * speed
        reaction = self._stiffness_force(depth, volume) + self.drag * slope * squared
        mass = added + self.p["foot_mass"]
        tape.follow(leg.foot_velocity, (leg.applied + reaction) / mass - GRAVITY)
        rates = (reaction * speed, GRAVITY * (added * speed), Fraction(1, 2) * (slope * (squared * speed)))
        for name, rate in zip(self.integrals, rates, strict=True):
            leg.states[name] = tape.integral(self.state[name], rate)
        guards = {"stopped": leg.foot_velocity}
        if not self.cone_complete:
            guards["cone"] = depth - self.cone_depth
        return guards

    def _jammed(self, _tape: Tape, leg: LegSeries) -> Guards:
        """The foot rests in the pit that it has made."""
        stiffness_n, added_kg = self._at_rest()
        weight_n = self.p["foot_mass"] * GRAVITY
        return {"lift-off": leg.applied - weight_n, "yield": weight_n + added_kg * GRAVITY - stiffness_n - leg.applied}

    def _flight(self, tape: Tape, leg: LegSeries) -> Guards:
        """No ground: body and foot fall, tied by the leg."""
        self.free_foot(tape, leg)
        guards = {"apex": -leg.body_velocity}
        if not self.risen:
            guards["risen"] = leg.foot_position + self.record.deepest
        elif not self.cleared:
            guards["contact"] = -leg.foot_position - self.record.deepest
            guards["cleared"] = leg.foot_position
        return guards

    def events(self) -> dict[str, Callable[[], None]]:
        """What each guard does."""
        found = {
            **super().events(),
            "cone": self.sets(cone_complete=True),
            "risen": self.sets(risen=True),
            "cleared": self.sets(cleared=True),
            "stopped": self._stop,
            "yield": lambda: self.enter("intruding"),
            "lift-off": self._lift_off,
            "contact": self._touch,
            "apex": self._reach_apex,
        }
        return found | {"straight": self.sets(beyond_straight=True, saturation=0)} if self.mode == "flight" else found

    def _stop(self) -> None:
        self.state["v_f"] = Fraction(0)
        self.enter("jammed")

    def _lift_off(self) -> None:
        self.record.lift_off(self.state)
        if "held_gains_in_flight" not in self.effects:
            self.extending, self.gains = False, self.soft
        self.risen = "contact_once_risen" not in self.effects
        self.enter("flight")

    def _touch(self) -> None:
        """The foot is back in its pit while the body still rises: the stance goes on.

        The grains join at the foot's velocity: the energy they bring is booked as that of recruited grains. The ticks
        that passed while the foot was in the air had no effect.
        """
        if self.beyond_straight:
            self.record.outcome = "leg_straight"
        _, added_kg = self._at_rest()
        self.state["recruited_kinetic_energy"] += added_kg * self.state["v_f"] ** 2 / 2
        while self._next_tick_time <= self.record.time:
            self.tick += 1
        self.enter("intruding")

    def _reach_apex(self) -> None:
        self.record.apex = self.state["x_b"]
        self.record.outcome = "apex"

    def _at_rest(self) -> tuple[Fraction, Fraction]:
        """Stiffness force and added mass at the deepest point."""
        deepest = self.record.deepest
        _, volume = self._area_and_volume(deepest)
        return self._stiffness_force(deepest, volume), self._added_mass(deepest, volume)
