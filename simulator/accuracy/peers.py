"""A scene integrated by `scipy.integrate.solve_ivp`: one call between events, compiled rates and events.

A segment ends at an event, at the emulator's timer, or at a tick of the controller at which gains change; then the
integrator starts anew. So would anyone do who has no event-driven simulator at hand.
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numba
import numpy as np
from scipy.integrate import solve_ivp

from simulator.compiled import Function, Row
from simulator.kernel.cache import cached_entry
from simulator.kernel.composition import Composition, compose
from simulator.kernel.control.controller import make_must_land, make_switch, make_tick, make_timer, make_wants_switch
from simulator.kernel.events.contact import GOES_ON, make_lift_off, make_meet_ground, make_settle
from simulator.kernel.events.first_event import make_at_once
from simulator.kernel.events.guards import make_guards
from simulator.kernel.events.transitions import make_transition
from simulator.kernel.layout import (
    AIRBORNE,
    ASLEEP,
    BOTTOMS,
    CAP_KINK,
    CARRIED,
    CLEARS,
    CONDITIONS,
    FALLS,
    FLIGHT,
    FOLDS,
    GUARDS,
    GUARDS_AFTER,
    HOLD_TURNS,
    INTRUDING,
    JAMMED,
    K1,
    LENGTH_UNIT,
    LIFTOFF_REACHED,
    LIFTS,
    MODE,
    MODES,
    NOW,
    PARAMETERS,
    PHASE,
    RELEASES,
    SPEED_UNIT,
    STALE,
    STEPS_ALLOWED,
    STOPS,
    STRAIGHTENS,
    STRIDE,
    SWITCHES,
    TICK,
    TIME,
    TOUCHDOWN,
    TOUCHES,
    TRIAL,
    X_FOOT,
    YIELDS,
)
from simulator.kernel.limits import LONGEST_FLIGHT_S, LONGEST_STANCE_S, STOP_AFTER_LIFTOFF
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.report import make_finish
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.kernel.run import make_given_up
from simulator.kernel.start import make_begin, make_begin_jump
from simulator.kernel.steps.step_loop import make_control, make_finish_step, make_note_mode, make_touch_down
from simulator.kernel.steps.stride import TIMED, UNEVENTFUL
from simulator.parameter import GRAVITY_M_S2

WISH = GUARDS
"""Place after the guards: whether a sampled controller would change its phase, were there a tick."""
WATCHED = GUARDS + 1
_IN_STANCE = (FALLS, FOLDS, STRAIGHTENS)
_OF_MODE = {
    FLIGHT: (TOUCHES, CLEARS, FALLS, FOLDS),
    INTRUDING: (STOPS, BOTTOMS, *_IN_STANCE),
    JAMMED: (LIFTS, YIELDS, *_IN_STANCE),
    CARRIED: (LIFTS, *_IN_STANCE),
}
_OF_SLIDING = {FLIGHT: (STOPS, BOTTOMS), INTRUDING: (LIFTS,)}
"""What a platform with mass adds: it stops without the foot, or the foot leaves it."""
_NUMBER, _WHOLE, _ROW = numba.float64, numba.int64, numba.float64[::1]


@dataclass(frozen=True, slots=True)
class HybridSystem:
    """Compiled functions of a set of effects, all on the kernel's row `work` (`simulator.kernel.layout`).

    `begin(work)` puts the robot at the start, `touch_down(work, row)` begins a jump. `control(work, row)` looks at the
    ticks that are due. `due(work)` is the guard whose event is due before a step is taken, or -1.
    `rates(mode, t, work, state)` and `watch(t, work, state)` are new arrays, the latter of guards, and wish.
    `follow(event, work, row, stop_after)` takes the state at `TRIAL` over and does what happens there;
    it returns an outcome or `GOES_ON`. `timer(work)` is when the emulator's state ends, `must_land(work)` whether to
    stop at the next tick. `given_up(work)` is an outcome or `GOES_ON`, `finish(outcome, work, row)` writes the row.
    `events[mode]` are the guards that can fire in a mode.
    """

    composition: Composition
    events: dict[int, tuple[int, ...]]
    begin: Function
    touch_down: Function
    control: Function
    rates: Function
    due: Function
    watch: Function
    follow: Function
    timer: Function
    must_land: Function
    given_up: Function
    finish: Function


@functools.lru_cache(maxsize=16)
def system_for(effects: frozenset[str]) -> HybridSystem:
    """Return the system of a set of effects, composed once a process."""
    composition = compose(effects)
    functions = {**_moving(composition), **_changing(composition)}
    return HybridSystem(
        composition,
        {mode: (*guards, *_further(composition, mode)) for mode, guards in _OF_MODE.items()},
        **{
            name: cached_entry(function, types, f"hybrid {name}", composition.effects)
            for name, (function, types) in functions.items()
        },
    )


def _further(composition: Composition, mode: int) -> Iterator[int]:
    """Yield the guards of a mode that only some effects have."""
    yield from (one.place for one in composition.effect_guards if MODES[mode] in one.guard.modes)
    if composition.platform >= 0:
        yield from _OF_SLIDING.get(mode, ())
    if composition.on("sampled_control") and not (composition.sleeps_in_flight and mode == FLIGHT):
        yield WISH
    for guard, column in ((CAP_KINK, "cap_n"), (RELEASES, "travel_m"), (HOLD_TURNS, "hold_guard")):
        if composition.has(column):
            yield guard
    if not composition.on("sampled_control"):
        yield from range(SWITCHES, SWITCHES + CONDITIONS)


def _moving(composition: Composition) -> dict[str, tuple[Function, tuple[object, ...]]]:
    size, rates_of = composition.state_size, make_rates(composition)
    wants_switch, sampled = make_wants_switch(composition), composition.on("sampled_control")
    sleeps, count = composition.sleeps_in_flight, composition.guards
    fill_guards = make_guards(composition)
    at_once = make_at_once(composition, fill_guards)

    def rates(mode: int, t: float, work: Row, state: Row) -> Row:
        work[TRIAL : TRIAL + size] = state
        rates_of(mode, t, work, TRIAL, K1)
        return work[K1 : K1 + size].copy()

    def due(work: Row) -> int:
        work[STALE] = 1
        guard: int = at_once(work[TIME], work)
        return guard

    def watch(t: float, work: Row, state: Row) -> Row:
        values = np.full(WATCHED, -1.0)
        work[TRIAL : TRIAL + size] = state
        fill_guards(t, work, TRIAL, GUARDS_AFTER)
        values[:count] = work[GUARDS_AFTER : GUARDS_AFTER + count]
        if sampled and not (sleeps and (work[MODE] == FLIGHT or work[ASLEEP] == 1)):
            values[WISH] = wants_switch(work, work[PHASE], TRIAL, 1.0, 1.0)
        return values

    return {
        "rates": (rates, (_WHOLE, _NUMBER, _ROW, _ROW)),
        "due": (due, (_ROW,)),
        "watch": (watch, (_NUMBER, _ROW, _ROW)),
        "timer": (make_timer(composition), (_ROW,)),
        "must_land": (make_must_land(composition), (_ROW,)),
    }


def _changing(composition: Composition) -> dict[str, tuple[Function, tuple[object, ...]]]:
    switch, lift_off = make_switch(composition), make_lift_off(composition)
    settle = make_settle(composition, lift_off)
    tick = make_tick(composition, make_wants_switch(composition), switch)
    look, notice = make_control(composition, tick, settle), make_note_mode(composition)
    meet_ground, prepare, put = make_meet_ground(composition), composition.prepare, make_begin(composition)
    meet_again = make_touch_down(meet_ground, settle)
    begin_jump = make_begin_jump(composition, meet_ground, settle)
    act = make_finish_step(composition, make_transition(composition, switch, settle, lift_off), settle)

    def begin(work: Row) -> None:
        prepare(work)
        put(work)
        work[LENGTH_UNIT], work[SPEED_UNIT], work[STEPS_ALLOWED] = 1.0, 1.0, np.inf

    def touch_down(work: Row, row: Row) -> None:
        begin_jump(work, row, True)
        notice(FLIGHT, 0, work, row, np.zeros((0, 4)))

    def control(work: Row, row: Row) -> None:
        mode = work[MODE]
        look(work, -1.0)
        if work[MODE] != mode:
            notice(mode, 0, work, row, np.zeros((0, 4)))

    def follow(event: int, work: Row, row: Row, stop_after: float) -> int:
        mode = work[MODE]
        outcome: int = act(event, work, row, stop_after)
        if outcome == TOUCHDOWN:
            outcome = meet_again(work, row)
        if work[MODE] != mode:
            notice(mode, 0, work, row, np.zeros((0, 4)))
        return outcome

    return {
        "begin": (begin, (_ROW,)),
        "touch_down": (touch_down, (_ROW, _ROW)),
        "control": (control, (_ROW, _ROW)),
        "follow": (follow, (_WHOLE, _ROW, _ROW, _NUMBER)),
        "given_up": (make_given_up(composition), (_ROW,)),
        "finish": (make_finish(composition), (_WHOLE, _ROW, _ROW)),
    }


METHODS = ("RK45", "DOP853", "LSODA")
LONGEST_STEP_S = 0.02
MOST_EVALUATIONS = 400_000
MOST_SEGMENTS = 5_000
_JUST_BEFORE = -1e-300


class PeerGaveUp(Exception):
    """The integrator did not come to the end of the jump; the text says where."""


@dataclass(frozen=True, slots=True)
class PeerRun:
    """The rows of the jumps, shape (jumps, columns), and how often the rates were evaluated."""

    rows: Row
    evaluations: int


def peer_run(
    system: HybridSystem,
    parameters: Row,
    method: str,
    rtol: float,
    jumps: int,
    stop_after: int,
) -> PeerRun:
    """Integrate some jumps by a method of `solve_ivp`; `parameters` in the order that the kernel reads.

    The absolute tolerances are `rtol` times typical sizes of the states. Raises `PeerGaveUp` where the
    integrator fails or takes more evaluations or segments than are allowed.
    """
    work = np.zeros(system.composition.row_size)
    work[PARAMETERS : PARAMETERS + len(parameters)] = parameters
    walk = _Walk(system, work, method, rtol, stop_after)
    rows = []
    for _ in range(jumps):
        rows.append(walk.jump())
        if rows[-1][COLUMN["outcome"]] != TOUCHDOWN:
            break
    return PeerRun(np.array(rows), walk.evaluations)


@dataclass(slots=True)
class _Walk:
    """The walk through modes and jumps."""

    system: HybridSystem
    work: Row
    method: str
    rtol: float
    stop_after: int
    evaluations: int = 0
    segments: int = 0
    landed: bool = False

    def jump(self) -> Row:
        """Go from one touchdown to the end of the jump; the first is preceded by the fall to the ground."""
        row = np.full(len(COLUMNS), np.nan)
        system, work = self.system, self.work
        if not self.landed:
            self._fall(row)
        system.touch_down(work, row)
        self.landed, outcome = True, GOES_ON
        while outcome == GOES_ON:
            self._pass_ticks()
            system.control(work, row)
            outcome = int(system.given_up(work))
            if work[MODE] == FLIGHT and work[AIRBORNE] == 1 and self.stop_after == STOP_AFTER_LIFTOFF:
                outcome = LIFTOFF_REACHED
            if outcome == GOES_ON:
                outcome = self._segment(row, self.system.events[int(work[MODE])])
        system.finish(outcome, work, row)
        return row

    def _fall(self, row: Row) -> None:
        self.system.begin(self.work)
        self.work[AIRBORNE] = 1
        effects = self.system.composition.effect_guards
        guards = (TOUCHES, *(one.place for one in effects if "flight" in one.guard.modes))
        while self.work[NOW + X_FOOT] > 0.0 and self._segment(row, guards) != TOUCHDOWN:
            if self.system.given_up(self.work) != GOES_ON:
                raise PeerGaveUp("the robot never came down")

    def _segment(self, row: Row, guards: tuple[int, ...]) -> int:
        """Go on to the next event, tick or timer; returns an outcome, or `GOES_ON`."""
        system, work = self.system, self.work
        self.segments += 1
        if self.segments > MOST_SEGMENTS:
            raise PeerGaveUp(f"more than {MOST_SEGMENTS} events, the last at {work[TIME]:.6g} s of a jump")
        due = int(system.due(work))
        if due >= 0:  # two events fell together
            size = system.composition.state_size
            work[TRIAL : TRIAL + size], work[STRIDE] = work[NOW : NOW + size], 0.0
            return int(system.follow(due, work, row, float(self.stop_after)))
        timer_s, must_land = system.timer(work), system.must_land(work)
        end_s = min(LONGEST_FLIGHT_S if work[MODE] == FLIGHT else LONGEST_STANCE_S, timer_s)
        stops = must_land or (WISH in guards and self._wishes())
        if stops:
            end_s = min(end_s, float(work[TICK] / work[system.composition.position["control_rate"]]))
        found = self._integrate(end_s, tuple(guard for guard in guards if guard != WISH or not stops))
        event = TIMED if found is None and work[TIME] == timer_s else UNEVENTFUL if found is None else found
        if event >= GUARDS:
            event = UNEVENTFUL
        return int(system.follow(event, work, row, float(self.stop_after)))

    def _wishes(self) -> bool:
        """Tell whether the controller would change its phase already, and will at the next tick."""
        work, size = self.work, self.system.composition.state_size
        return bool(self.system.watch(work[TIME], work, work[NOW : NOW + size].copy())[WISH] > 0.0)

    def _pass_ticks(self) -> None:
        """Pass over the ticks that lie behind: the controller would have changed nothing there."""
        work, rate = self.work, self.system.composition.position.get("control_rate", -1)
        while rate >= 0 and work[TICK] / work[rate] < work[TIME]:
            work[TICK] += 1

    def _integrate(self, end_s: float, guards: tuple[int, ...]) -> int | None:
        """Integrate to an event, which is returned, or to the end of the segment; the state there is at `TRIAL`."""
        system, work = self.system, self.work
        mode, start_s = int(work[MODE]), float(work[TIME])
        size = system.composition.state_size
        state = work[NOW : NOW + size].copy()
        fired: list[int] = []
        if end_s > start_s:
            watched = Watched(system, work, start_s, state)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    found = solve_ivp(
                        self._rates(mode),
                        (start_s, end_s),
                        state,
                        method=self.method,
                        rtol=self.rtol,
                        atol=self.rtol * typical_sizes(work, system),
                        max_step=LONGEST_STEP_S,
                        events=[watched.event(guard) for guard in guards],
                    )
                except (UserWarning, RuntimeWarning, ValueError) as trouble:
                    raise PeerGaveUp(f"{trouble} at {start_s:.6g} s of a jump") from trouble
            if found.status < 0:
                raise PeerGaveUp(f"{found.message} at {found.t[-1]:.6g} s of a jump")
            work[TIME], state = found.t[-1], np.ascontiguousarray(found.y[:, -1])
            fired = [guard for guard, times in zip(guards, found.t_events, strict=True) if len(times)]
            if fired:
                self._go_past(mode, fired[0], state)
        work[STRIDE] = work[TIME] - start_s
        work[TRIAL : TRIAL + size] = state
        return fired[0] if fired else None

    def _rates(self, mode: int) -> Callable[[float, Row], Row]:
        rates, work = self.system.rates, self.work

        def of_state(t: float, state: Row) -> Row:
            self.evaluations += 1
            if self.evaluations > MOST_EVALUATIONS:
                raise PeerGaveUp(f"more than {MOST_EVALUATIONS} evaluations, the last at {t:.6g} s of a jump")
            found: Row = rates(mode, t, work, state)
            return found

        return of_state

    def _go_past(self, mode: int, guard: int, state: Row) -> None:
        """Step over an event by some bits: at the root the guard is 0, or rounded to less, and nothing would happen."""
        system, work, step_s = self.system, self.work, 1e-15
        for _ in range(30):
            if system.watch(work[TIME], work, state)[guard] > 0.0:
                return
            state += step_s * system.rates(mode, work[TIME], work, state)
            work[TIME] += step_s
            step_s *= 2.0


def typical_sizes(work: Row, system: HybridSystem) -> Row:
    """Sizes that absolute tolerances are shares of: m, m/s, J, and those of the states of effects."""
    at = system.composition.position
    length_m, speed_m_s = work[at["rest_length"]], math.sqrt(GRAVITY_M_S2 * work[at["rest_length"]])
    energy_j = (work[at["body_mass"]] + work[at["foot_mass"]]) * GRAVITY_M_S2 * length_m
    sizes = np.full(system.composition.state_size, energy_j)
    sizes[:4] = length_m, speed_m_s, 0.1 * length_m, speed_m_s
    for one in system.composition.effect_states:
        sizes[one.place] = one.state.typical
    return sizes


@dataclass(slots=True)
class Event:
    """One guard as `solve_ivp` wants its events; at the start of a segment a guard at 0 is below it."""

    watched: Watched
    place: int
    armed: bool
    terminal: bool = True
    direction: float = 1.0

    def __call__(self, t: float, state: Row) -> float:
        """Return the guard at one instant, as `solve_ivp` asks for it."""
        value = float(self.watched.values(t, state)[self.place])
        return min(value, _JUST_BEFORE) if self.armed and t <= self.watched.start_s else value


class Watched:
    """All guards of a segment, evaluated once for each instant that `solve_ivp` asks about."""

    def __init__(self, system: HybridSystem, work: Row, start_s: float, state: Row) -> None:
        self._system, self._work, self.start_s, self._at = system, work, start_s, start_s
        self._first: Row = system.watch(start_s, work, state)
        self._values: Row = self._first

    def event(self, place: int) -> Event:
        """Return one guard of the segment as an event."""
        return Event(self, place, bool(self._first[place] <= 0.0))

    def values(self, t: float, state: Row) -> Row:
        """Return all guards at one instant, shape (guards,)."""
        if t != self._at:
            self._values = self._system.watch(t, self._work, np.ascontiguousarray(state))
            self._at = t
        return self._values
