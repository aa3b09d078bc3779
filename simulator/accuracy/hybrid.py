"""A scene as a hybrid system that another integrator can drive: its rates, its guards, and what happens at events.

All of it is composed of the kernel's own functions, so that what is compared is the integrator. Creeping is left out: a
resting foot is held, yields, or lifts off.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from simulator.effects.effect import Function
from simulator.kernel.cached_entry import cached_entry
from simulator.kernel.composition import Composition, compose
from simulator.kernel.control.controller import make_wants_switch
from simulator.kernel.control.decisions import make_must_land, make_switch, make_tick
from simulator.kernel.control.emulator import make_timer
from simulator.kernel.events.contact import make_lift_off, make_settle
from simulator.kernel.events.guards import make_guards
from simulator.kernel.events.landing import make_meet_ground
from simulator.kernel.events.locate import make_at_once
from simulator.kernel.events.transitions import make_transition
from simulator.kernel.layout import (
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
    LIFTS,
    MODE,
    MODES,
    PHASE,
    RELEASES,
    SPEED_UNIT,
    STALE,
    STOPS,
    STRAIGHTENS,
    SWITCHES,
    TICK,
    TIME,
    TOUCHDOWN,
    TOUCHES,
    TRIAL,
    YIELDS,
)
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.report import make_finish
from simulator.kernel.run import make_given_up
from simulator.kernel.start import make_begin, make_begin_jump
from simulator.kernel.steps.step_loop import make_control, make_finish_step, make_note_mode, make_touch_down

Row = NDArray[np.float64]
WISH = GUARDS
"""Place after the guards: whether a sampled controller would change its phase, were there a tick."""
WATCHED = GUARDS + 1
MOST_STEPS = 1e300
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
    it returns an outcome or `GOES_ON`. `horizon(work)` is when the emulator's state ends, and whether to stop at the
    next tick. `given_up(work)` is an outcome or `GOES_ON`, `finish(outcome, work, row)` writes the row. `events[mode]`
    are the guards that can fire in a mode.
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
    horizon: Function
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
    fill_guards, timer, must_land = make_guards(composition), make_timer(composition), make_must_land(composition)
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

    def horizon(work: Row) -> tuple[float, bool]:
        return timer(work), must_land(work)

    return {
        "rates": (rates, (_WHOLE, _NUMBER, _ROW, _ROW)),
        "due": (due, (_ROW,)),
        "watch": (watch, (_NUMBER, _ROW, _ROW)),
        "horizon": (horizon, (_ROW,)),
    }


def _changing(composition: Composition) -> dict[str, tuple[Function, tuple[object, ...]]]:
    switch, lift_off = make_switch(composition), make_lift_off(composition)
    settle = make_settle(composition, lift_off)
    tick = make_tick(composition, make_wants_switch(composition), switch)
    look, notice = make_control(composition, tick, settle), make_note_mode(composition)
    meet_ground, prepare, put = make_meet_ground(composition), composition.prepare, make_begin(composition)
    meet_again = make_touch_down(meet_ground, settle)
    begin_jump, write = make_begin_jump(composition, meet_ground, settle), make_finish(composition)
    act, end = (
        make_finish_step(composition, make_transition(composition, switch, settle, lift_off), settle),
        make_given_up(composition),
    )
    sampled, rate = composition.on("sampled_control"), composition.position.get("control_rate", -1)

    def begin(work: Row) -> None:
        prepare(work)
        put(work)
        work[LENGTH_UNIT], work[SPEED_UNIT] = 1.0, 1.0

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
        if sampled and mode == FLIGHT and work[MODE] != FLIGHT:
            while work[TICK] / work[rate] < work[TIME]:
                work[TICK] += 1
        if work[MODE] != mode:
            notice(mode, 0, work, row, np.zeros((0, 4)))
        return outcome

    def given_up(work: Row) -> int:
        outcome: int = end(work, MOST_STEPS, False)
        return outcome

    def finish(outcome: int, work: Row, row: Row) -> None:
        write(outcome, work, row)

    return {
        "begin": (begin, (_ROW,)),
        "touch_down": (touch_down, (_ROW, _ROW)),
        "control": (control, (_ROW, _ROW)),
        "follow": (follow, (_WHOLE, _ROW, _ROW, _NUMBER)),
        "given_up": (given_up, (_ROW,)),
        "finish": (finish, (_WHOLE, _ROW, _ROW)),
    }
