"""Repeated jumps on rigid and on emulated ground (thesis 3.2.2, 4.2) under continuous control."""

from collections.abc import Callable
from fractions import Fraction

from benchmarks.reference_simulator.leg import (
    LEG_INTEGRALS,
    Gains,
    HoppingParameters,
    Leg,
    LegSeries,
    Phase,
    Platform,
    saturation_guards,
)
from benchmarks.reference_simulator.power_series import FixedPoint, Series, SeriesTape, State, advance, setting
from benchmarks.reference_simulator.result import JumpRecord, ReferenceResult

GROUND_INTEGRALS = ("ground_work", "reset_work", "impact_loss")
LONGEST_STEP_S = Fraction("0.008")


def reference_jumps(
    parameters: HoppingParameters, jumps: int, digits: int = 30, order: int = 30
) -> tuple[ReferenceResult, ...]:
    """The first `jumps` jumps from rest to `digits` digits, by Taylor series of `order`.

    They are fewer where one does not end in a touchdown; the last one's outcome then says why.
    """
    return _Hopping(parameters, FixedPoint.for_digits(digits), order).run(jumps, digits)


class _Hopping:
    """The walk through the modes, jump after jump."""

    def __init__(self, parameters: HoppingParameters, number: FixedPoint, order: int) -> None:
        self.parameters, self.number, self.order = parameters, number, order
        p, of = parameters, number.of
        self.leg, self.platform = Leg(p, number), Platform(p.platform, number)
        self.foot_mass = of(p.foot_mass_kg)
        self.state: State = {"x_b": of(p.rest_length_m), "v_b": 0, "x_f": 0, "v_f": 0}
        self.contact = "held"
        self.stiff = self.compressed = self.rising = self.foot_falling = False
        self.saturation = 0
        self.jump = self._new_jump()

    def run(self, jumps: int, digits: int) -> tuple[ReferenceResult, ...]:
        """The jumps one after the other."""
        results: list[ReferenceResult] = []
        limit, state = self.number.of(self.parameters.longest_jump_s), self.state
        while len(results) < jumps:
            self._step()
            if self.jump.time > limit:
                self.jump.outcome = "carried" if self.jump.liftoff else "no_liftoff" if self.stiff else "no_trigger"
            if self.jump.outcome is not None:
                work = state["leg_work"] - state["ground_work"] + state["reset_work"] - state["impact_loss"]
                residual = self.leg.energy(state) - self.jump.energy - work
                results.append(self.jump.result(state, residual, self.number, digits))
                if self.jump.outcome != "touchdown":
                    break
                self.jump = self._new_jump()
                self._touch_down()
        return tuple(results)

    def _new_jump(self) -> JumpRecord:
        self.state |= dict.fromkeys((*LEG_INTEGRALS, *GROUND_INTEGRALS), 0)
        return JumpRecord(self.leg.energy(self.state))

    def _step(self) -> None:
        number, jump, platform = self.number, self.jump, self.platform
        p, of, one = self.parameters, number.of, number.one
        tape = SeriesTape(number.bits, self.order)
        path = platform.path(tape)
        carried = self.contact == "held" and platform.phase is Phase.RESET
        leg = self.leg.write(
            tape,
            self.state,
            self._gains(),
            self.saturation,
            fixed_foot=self.contact == "held",
            foot=path[:2] if carried else None,
        )
        guards = saturation_guards(tape, leg, self.saturation)
        guards |= {"free": self._free, "moving": self._moving, "held": self._held}[self.contact](tape, leg, path)
        guards |= self._controller(tape, leg)
        guards["straight"] = tape.combine([(one, leg.length)], -of(p.straight_leg_m))
        guards["folded"] = tape.combine([(-one, leg.length)], of(p.folded_leg_m))
        left = platform.time_left
        longest = of(LONGEST_STEP_S)
        timed = left is not None and left <= longest
        result = advance(tape, self.state, leg.states, guards, left if left is not None and timed else longest)
        jump.time += result.elapsed
        platform.elapsed += result.elapsed
        if self.contact == "moving" or carried:
            platform.position = self.state["x_f"]
            jump.deepest = max(jump.deepest, -platform.position)
        if result.fired is not None:
            self._events()[result.fired]()
        elif result.complete and timed:
            platform.end_phase()
            if carried:
                self.state["x_f"] = self.state["v_f"] = 0

    def _gains(self) -> Gains:
        """The gains of the leg's state; active damping acts while the foot falls."""
        p, of = self.parameters, self.number.of
        if not self.stiff:
            return Gains(of(p.compression_stiffness_n_m), of(p.compression_damping_kg_s))
        falling = self.contact == "moving" or (self.contact == "free" and self.foot_falling)
        active = of(p.active_damping_kg_m) if falling else 0
        return Gains(of(p.extension_stiffness_n_m), of(p.extension_damping_kg_s), active)

    def _free(self, tape: SeriesTape, leg: LegSeries, path: tuple[Series, Series, Series]) -> dict[str, Series]:
        """The foot in the air."""
        one = self.number.one
        tape.follow(leg.foot_velocity, tape.combine([(self.leg.inverse_foot_mass, leg.applied)], -self.leg.gravity))
        turning = -one if not self.foot_falling else one
        guards = {
            "touchdown": tape.subtract(path[0], leg.foot_position),
            "foot turns": tape.combine([(turning, leg.foot_velocity)]),
        }
        if self.jump.apex is None:
            guards["apex"] = tape.combine([(-one, leg.body_velocity)])
        return guards

    def _moving(self, tape: SeriesTape, leg: LegSeries, _path: object) -> dict[str, Series]:
        """The platform yields downward under the foot."""
        one, platform = self.number.one, self.platform
        reaction = platform.reaction(tape, leg.foot_position, leg.foot_velocity)
        push = tape.combine([(one, leg.applied), (one, reaction)])
        tape.follow(leg.foot_velocity, tape.combine([(self.leg.inverse_foot_mass, push)], -self.leg.gravity))
        speed = tape.combine([(-one, leg.foot_velocity)])
        leg.states["ground_work"] = tape.integral(self.state["ground_work"], tape.multiply(reaction, speed))
        return {
            "bottom": tape.combine([(-one, leg.foot_position)], -platform.travel),
            "stopped": tape.combine([(one, leg.foot_velocity)]),
        }

    def _held(self, tape: SeriesTape, leg: LegSeries, path: tuple[Series, Series, Series]) -> dict[str, Series]:
        """The foot stands on a platform that is locked, or is carried by one that is reset."""
        one, platform = self.number.one, self.platform
        _, velocity, acceleration = path
        # What the platform must bring up to keep the foot on its path.
        reaction = tape.combine([(self.foot_mass, acceleration), (-one, leg.applied)], self.leg.foot_weight)
        leg.states["reset_work"] = tape.integral(self.state["reset_work"], tape.multiply(reaction, velocity))
        guards = {"lift-off": tape.combine([(-one, reaction)])}
        if platform.phase is Phase.HOLD and platform.position > -platform.travel:
            lacking = self.number.multiply(platform.stiffness, platform.position) - platform.yield_margin
            guards["yield"] = tape.combine([(one, reaction)], lacking)
        return guards

    def _controller(self, tape: SeriesTape, leg: LegSeries) -> dict[str, Series]:
        """The leg's latched switching, and the release of the ratchet."""
        p, of, one = self.parameters, self.number.of, self.number.one
        if self.stiff:
            guards = {}
            if self.platform.may_release:
                released = of(p.rest_length_m) - self.platform.release_length
                guards["release"] = tape.combine([(one, leg.length)], -released)
            guards["soften"] = tape.combine([(one, leg.length)], of(p.length_tolerance_m - p.rest_length_m))
            if self.contact != "free":
                sign = -one if self.rising else one
                guards["body turns"] = tape.combine([(sign, leg.body_velocity)])
            return guards
        threshold = of(p.rest_length_m - p.switch_compression_m)
        guards = {"shortest": tape.combine([(-one, leg.length)], of(p.shortest_leg_m))}
        if self.compressed:
            guards["stiffen"] = tape.combine([(one, leg.rate)], of(p.velocity_tolerance_m_s))
            guards["longer"] = tape.combine([(one, leg.length)], -threshold)
        else:
            guards["compressed"] = tape.combine([(-one, leg.length)], threshold)
        return guards

    def _events(self) -> dict[str, Callable[[], None]]:
        jump = self.jump
        stiffen = setting(self, stiff=True, compressed=False, rising=False)
        return {
            "over": setting(self, saturation=1),
            "under": setting(self, saturation=-1),
            "within": setting(self, saturation=0),
            "bottom": self._stop,
            "stopped": self._stop,
            "yield": lambda: self._enter("moving"),
            "lift-off": self._lift_off,
            "touchdown": self._meet,
            "foot turns": setting(self, foot_falling=not self.foot_falling),
            "release": self._release,
            "compressed": setting(self, compressed=True),
            "longer": setting(self, compressed=False),
            "stiffen": stiffen,
            "shortest": stiffen,
            "body turns": setting(jump, outcome="no_liftoff") if self.rising else setting(self, rising=True),
            "soften": setting(self, stiff=False),
            "apex": lambda: setattr(jump, "apex", self.state["x_b"]),
            "straight": setting(jump, outcome="leg_straight"),
            "folded": setting(jump, outcome="leg_folded"),
        }

    def _enter(self, contact: str) -> None:
        self.contact = contact
        self.jump.enter(contact)

    def _stop(self) -> None:
        self._lose_speed(0)
        self._enter("held")

    def _lift_off(self) -> None:
        self.jump.lift_off(self.state)
        self.foot_falling = False
        self._enter("free")

    def _meet(self) -> None:
        """A jump ends where the foot meets the ground with the body falling."""
        if self.state["v_b"] < 0 and self.jump.liftoff is not None:
            self.jump.outcome = "touchdown"
        else:
            self._touch_down()

    def _release(self) -> None:
        self.platform.enter(Phase.RELEASE)
        if self.contact == "moving":
            self._stop()

    def _touch_down(self) -> None:
        """The foot meets the platform: one that yields costs nothing, any other gives the foot its own velocity."""
        if self.platform.phase is Phase.HOLD and self.state["v_f"] < 0:
            self._enter("moving")
            return
        tape = SeriesTape(self.number.bits, 0)
        _, velocity, _ = self.platform.path(tape)
        tape.run(0)
        self._lose_speed(velocity[0])
        self._enter("held")

    def _lose_speed(self, velocity: int) -> None:
        """Set the foot's velocity at once, with the loss and the platform's work in the book."""
        multiply, state = self.number.multiply, self.state
        change = state["v_f"] - velocity
        state["impact_loss"] += multiply(self.foot_mass, multiply(change, change)) // 2
        state["reset_work"] -= multiply(self.foot_mass, multiply(change, velocity))
        state["v_f"] = velocity
