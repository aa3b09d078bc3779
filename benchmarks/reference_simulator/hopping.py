"""Repeated jumps on rigid and on emulated ground (thesis 3.2.2, 4.2) under continuous control.

The start is at rest with the toe at 0 and the leg at rest length. The emulated ground is a massless platform that a
ratchet lets sink, and a clock that lifts it again; its hold phase begins at the start.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TypeVar

from benchmarks.reference_simulator.leg import GRAVITY, Gains, Guards, LegSeries, Walk
from benchmarks.reference_simulator.power_series import Series, Tape, advance, bits_for
from benchmarks.reference_simulator.result import ReferenceResult

LONGEST_STEP_S = Fraction("0.008")
LONGEST_JUMP_S = 2
FOLDED_LEG_M = Fraction("0.101")
STRAIGHT_LEG_M = Fraction("0.2999")

V = TypeVar("V", Series, Fraction)
Path = tuple[V, V, V]
"""Position, velocity and acceleration."""


def reference_jumps(
    effects: frozenset[str], parameters: Mapping[str, Fraction], jumps: int, digits: int = 30, order: int = 30
) -> tuple[ReferenceResult, ...]:
    """The first `jumps` jumps from rest to `digits` digits, by Taylor series of `order`.

    They are fewer where one does not end in a touchdown; the last one's outcome then says why.
    """
    return _Hopping(effects, parameters, bits_for(digits), order).run(jumps, digits)


class _Platform:
    """The platform at `position` (metres below 0 are negative) with the clock of its state machine.

    Phases are hold, release, reset and engage; rigid ground is in `rigid` for ever.
    """

    def __init__(self, parameters: Mapping[str, Fraction], phase: str) -> None:
        self.p, self.phase = parameters, phase
        self.position = self.elapsed = self.reset_from = Fraction(0)

    @property
    def time_left(self) -> Fraction | None:
        """Time to the end of the phase, or to the end of the shortest hold; None where no clock runs."""
        if self.phase == "rigid" or self.may_release:
            return None
        name = "shortest_hold" if self.phase == "hold" else f"{self.phase}_time"
        return self.p[name] - self.elapsed

    @property
    def may_release(self) -> bool:
        """Whether the ratchet has held for as long as it must before a release."""
        return self.phase == "hold" and self.elapsed >= self.p["shortest_hold"]

    def enter(self, phase: str) -> None:
        """Begin a phase; the reset starts from where the platform is."""
        self.phase, self.elapsed = phase, Fraction(0)
        if phase == "reset":
            self.reset_from = self.position

    def end_phase(self) -> None:
        """What happens when the clock of the phase runs out."""
        if self.phase == "hold":
            self.elapsed = self.p["shortest_hold"]
            return
        if self.phase == "reset":
            self.position = Fraction(0)
        self.enter({"release": "reset", "reset": "engage", "engage": "hold"}[self.phase])

    def path(self, share: V) -> Path[V]:
        """The path of a platform that does not yield: it is reset, of which a share is over, or it rests."""
        if self.phase != "reset":
            return 0 * share + self.position, 0 * share, 0 * share
        square, rest, start, rate = share * share, 1 - share, self.reset_from, 1 / self.p["reset_time"]
        # 1 - 10 s^3 + 15 s^4 - 6 s^5 and its derivatives
        position = start - start * (square * share * (10 - 15 * share + 6 * square))
        velocity = -30 * start * rate * (square * (rest * rest))
        return position, velocity, -60 * start * rate**2 * (share * rest * (1 - 2 * share))

    def share(self) -> Fraction:
        """The share of a reset that is over; 0 in other phases."""
        return self.elapsed / self.p["reset_time"] if self.phase == "reset" else Fraction(0)


class _Hopping(Walk):
    """The walk through the modes, jump after jump."""

    integrals = ("ground_work", "reset_work", "impact_loss")

    def __init__(self, effects: frozenset[str], parameters: Mapping[str, Fraction], bits: int, order: int) -> None:
        super().__init__(effects, parameters, bits, order)
        self.platform = _Platform(parameters, "hold" if "emulated_ground" in effects else "rigid")
        self.mode = "held"
        self.stiff = self.compressed = self.rising = self.foot_falling = False
        self.begin()

    def run(self, jumps: int, digits: int) -> tuple[ReferenceResult, ...]:
        """The jumps one after the other."""
        results: list[ReferenceResult] = []
        state = self.state
        while len(results) < jumps:
            self._step()
            jump = self.record
            if jump.time > LONGEST_JUMP_S:
                jump.outcome = "carried" if jump.liftoff else "no_liftoff" if self.stiff else "no_trigger"
            if jump.outcome is not None:
                work = state["leg_work"] - state["ground_work"] + state["reset_work"] - state["impact_loss"]
                results.append(jump.result(state, self.energy() - jump.energy - work, digits))
                if jump.outcome != "touchdown":
                    break
                self.begin()
                self._touch_down()
        return tuple(results)

    def _step(self) -> None:
        jump, platform, tape = self.record, self.platform, Tape(self.bits, self.order)
        share = tape.series(platform.share())
        if platform.phase == "reset":
            tape.follow(share, tape.series(1 / self.p["reset_time"]))
        path = platform.path(share)
        carried = self.mode == "held" and platform.phase == "reset"
        leg = self.leg(tape, self._gains(), fixed_foot=self.mode == "held", foot=path[:2] if carried else None)
        guards = self.saturation_guards(leg)
        guards |= {"free": self._free, "moving": self._moving, "held": self._held}[self.mode](tape, leg, path)
        guards |= self._controller(leg)
        guards |= {"straight": leg.length - STRAIGHT_LEG_M, "folded": FOLDED_LEG_M - leg.length}
        left = platform.time_left
        timed = left is not None and left <= LONGEST_STEP_S
        step = left if left is not None and timed else LONGEST_STEP_S
        result = advance(tape, self.state, leg.states, guards, step)
        jump.time += result.elapsed
        platform.elapsed += result.elapsed
        if self.mode == "moving" or carried:
            platform.position = self.state["x_f"]
            jump.deepest = max(jump.deepest, -platform.position)
        if result.fired is not None:
            self.events()[result.fired]()
        elif result.complete and timed:
            platform.end_phase()
            if carried:
                self.state["x_f"] = self.state["v_f"] = Fraction(0)

    def _gains(self) -> Gains:
        """The gains of the leg's state; active damping acts while the foot falls."""
        p = self.p
        if not self.stiff:
            return Gains(p["k_compression"], p["b_compression"])
        falling = self.mode == "moving" or (self.mode == "free" and self.foot_falling)
        return Gains(p["k_extension"], p["b_extension"], p["b_ad"] if falling else Fraction(0))

    def _free(self, tape: Tape, leg: LegSeries, path: Path[Series]) -> Guards:
        """The foot in the air."""
        self.free_foot(tape, leg)
        turning = leg.foot_velocity if self.foot_falling else -leg.foot_velocity
        guards = {"touchdown": path[0] - leg.foot_position, "foot turns": turning}
        if self.record.apex is None:
            guards["apex"] = -leg.body_velocity
        return guards

    def _moving(self, tape: Tape, leg: LegSeries, _path: object) -> Guards:
        """The platform yields downward under the foot."""
        p, position, velocity = self.p, leg.foot_position, leg.foot_velocity
        reaction = p["platform_drag"] * (velocity * velocity) - p["platform_damping"] * velocity
        reaction = reaction - p["platform_stiffness"] * position
        tape.follow(velocity, 1 / p["foot_mass"] * (leg.applied + reaction) - GRAVITY)
        leg.states["ground_work"] = tape.integral(self.state["ground_work"], -(reaction * velocity))
        return {"bottom": -position - p["platform_travel"], "stopped": velocity}

    def _held(self, tape: Tape, leg: LegSeries, path: Path[Series]) -> Guards:
        """The foot stands on a platform that is locked, or is carried by one that is reset."""
        p, platform = self.p, self.platform
        _, velocity, acceleration = path
        # What the platform must bring up to keep the foot on its path.
        reaction = p["foot_mass"] * (acceleration + GRAVITY) - leg.applied
        leg.states["reset_work"] = tape.integral(self.state["reset_work"], reaction * velocity)
        guards = {"lift-off": -reaction}
        if platform.phase == "hold" and platform.position > -p["platform_travel"]:
            guards["yield"] = reaction + p["platform_stiffness"] * platform.position
        return guards

    def _controller(self, leg: LegSeries) -> Guards:
        """The leg's latched switching, and the release of the ratchet."""
        p, length = self.p, leg.length
        if self.stiff:
            guards = {}
            if self.platform.may_release:
                guards["release"] = length - (p["rest_length"] - p["release_tolerance"])
            guards["soften"] = length - (p["rest_length"] - p["rest_tolerance"])
            if self.mode != "free":
                guards["body turns"] = -leg.body_velocity if self.rising else leg.body_velocity
            return guards
        threshold = p["rest_length"] - p["switch_compression"]
        guards = {"shortest": p["guard_length"] - length}
        if self.compressed:
            return guards | {"stiffen": leg.rate + p["switch_speed_tolerance"], "longer": length - threshold}
        return guards | {"compressed": threshold - length}

    def events(self) -> dict[str, Callable[[], None]]:
        """What each guard does."""
        stiffen = self.sets(stiff=True, compressed=False, rising=False)
        return {
            **super().events(),
            "bottom": self._stop,
            "stopped": self._stop,
            "yield": lambda: self.enter("moving"),
            "lift-off": self._lift_off,
            "touchdown": self._meet,
            "foot turns": self.sets(foot_falling=not self.foot_falling),
            "release": self._release,
            "compressed": self.sets(compressed=True),
            "longer": self.sets(compressed=False),
            "stiffen": stiffen,
            "shortest": stiffen,
            "body turns": self.ends("no_liftoff") if self.rising else self.sets(rising=True),
            "soften": self.sets(stiff=False),
            "apex": lambda: setattr(self.record, "apex", self.state["x_b"]),
        }

    def _stop(self) -> None:
        self._lose_speed(Fraction(0))
        self.enter("held")

    def _lift_off(self) -> None:
        self.record.lift_off(self.state)
        self.foot_falling = False
        self.enter("free")

    def _meet(self) -> None:
        """A jump ends where the foot meets the ground with the body falling."""
        if self.state["v_b"] < 0 and self.record.liftoff is not None:
            self.record.outcome = "touchdown"
        else:
            self._touch_down()

    def _release(self) -> None:
        self.platform.enter("release")
        if self.mode == "moving":
            self._stop()

    def _touch_down(self) -> None:
        """The foot meets the platform: one that yields costs nothing, any other gives the foot its own velocity."""
        if self.platform.phase == "hold" and self.state["v_f"] < 0:
            self.enter("moving")
            return
        _, velocity, _ = self.platform.path(self.platform.share())
        self._lose_speed(velocity)
        self.enter("held")

    def _lose_speed(self, velocity: Fraction) -> None:
        """Set the foot's velocity at once, with the loss and the platform's work in the book."""
        state, foot_kg = self.state, self.p["foot_mass"]
        change = state["v_f"] - velocity
        state["impact_loss"] += foot_kg * change**2 / 2
        state["reset_work"] -= foot_kg * change * velocity
        state["v_f"] = velocity
