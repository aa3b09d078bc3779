"""How a jump starts: clocks and integrals at zero, so that no sum over many jumps costs digits."""

from __future__ import annotations

import math

import numpy as np

from simulator.compiled import Function, Row, inner
from simulator.kernel.combined import in_turn
from simulator.kernel.composition import Composition
from simulator.kernel.events.contact import make_note_saturation, make_turn_hold
from simulator.kernel.layout import (
    AIRBORNE,
    ASLEEP,
    BOTTOMED,
    CANCELLED,
    CAPPED,
    CLEAR,
    CLEARED,
    COMPRESSION,
    DECIDED,
    DEEPEST,
    DEPTH,
    EMULATOR_SINCE,
    EVALUATIONS,
    EVENTS,
    FLIGHT,
    FRESH,
    GROWTH,
    GUARD_SWITCHES,
    HOLD_SINCE,
    IMPACT,
    JAMMED,
    LEG_WORK,
    LONGEST,
    LOWEST,
    MARGIN,
    MARGIN_TICK,
    MODE,
    NOW,
    OFFSET,
    PERSISTENT,
    PHASE,
    RELEASE_MISSED,
    SHORTEST,
    STALE,
    START_ENERGY,
    STEPS,
    SWITCHED,
    TICK,
    TIME,
    TOUCHED_BEFORE_HOLD,
    TOUCHED_DURING_RESET,
    UNRESISTED,
    V_BODY,
    V_FOOT,
    WORST_GROWTH,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.limits import SLOW_M_S
from simulator.kernel.mechanics.leg import make_set_gains
from simulator.kernel.report import make_energy
from simulator.kernel.rows import COLUMN, COLUMNS


def make_start_states(composition: Composition) -> Function:
    """Compose `(work)`: the states of effects at the height and speed at which a simulation starts; 0 by default."""
    return in_turn(_start(one.start, one.place) for one in composition.effect_states if one.start is not None)


def _start(start: Function, place: int) -> Function:
    @inner
    def write_start(work: Row) -> None:
        work[NOW + place] = start(work, work[NOW + X_BODY], work[NOW + V_BODY])

    return write_start


def make_begin(composition: Composition) -> Function:
    """Put the robot where the scene starts: `(work)`."""
    at = composition.position
    rest, height, velocity = at["rest_length"], at["initial_height"], at["initial_velocity"]
    set_gains, note, size = make_set_gains(composition), make_note_saturation(composition), composition.state_size
    turn_hold, start_states = make_turn_hold(composition), make_start_states(composition)
    holds, body_moves = composition.optional("body_moves")

    @inner
    def begin(work: Row) -> None:
        for i in range(PERSISTENT):
            work[i] = 0.0
        for i in range(size):
            work[NOW + i] = 0.0
        work[NOW + X_BODY], work[NOW + V_BODY] = work[rest] + work[height], work[velocity]
        work[NOW + X_FOOT], work[NOW + V_FOOT] = work[height], work[velocity]
        work[MODE], work[CLEARED], work[PHASE] = FLIGHT, CLEAR, COMPRESSION
        work[STALE] = 1
        start_states(work)
        if holds:
            body_moves(work, work[velocity])
        set_gains(work, False, 0.0)
        note(work)
        if work[velocity] == 0.0:
            turn_hold(work)

    return begin


AT_ZERO = (
    *(CAPPED, DEPTH, IMPACT, DECIDED, GROWTH, WORST_GROWTH, TICK, AIRBORNE, STEPS, EVALUATIONS, EVENTS),
    *(BOTTOMED, TOUCHED_DURING_RESET, TOUCHED_BEFORE_HOLD, RELEASE_MISSED, GUARD_SWITCHES),
    *(ASLEEP, CANCELLED, UNRESISTED, SWITCHED),
)
"""Places of clocks and counters that start at zero with each jump."""


def make_begin_jump(composition: Composition, meet_ground: Function, settle: Function) -> Function:
    """Begin a jump with the foot's touchdown: `(work, row, lands)`. Clocks, integrals and counters start at zero.

    On grains a foot that has cleared the surface lands on fresh ground, one that has not in its print. One that does
    not land never came down, and stays where it is. The slower the foot, the more rounding of heights grows in the
    instant.
    """
    energy = make_energy(composition)
    integrals_end, granular = composition.integrals_end, composition.on("hydrostatic_stiffness")
    touchdown, per_fall = COLUMN["touchdown_time_s"], composition.position["inverse_fall_speed"]

    @inner
    def begin_jump(work: Row, row: Row, lands: bool) -> None:
        t = work[TIME]
        for i in range(LEG_WORK, integrals_end):
            work[NOW + i] = 0.0
        for i in range(len(COLUMNS)):
            row[i] = np.nan
        work[OFFSET] += t
        row[touchdown] = work[OFFSET]
        work[TIME] = 0.0
        work[EMULATOR_SINCE] -= t
        work[HOLD_SINCE] -= t
        for place in AT_ZERO:
            work[place] = 0.0
        work[MARGIN], work[MARGIN_TICK] = np.inf, -1.0
        if lands and t > 0.0 and -SLOW_M_S < work[NOW + V_FOOT] < 0.0:
            work[GROWTH] = max(0.0, -math.log(-work[NOW + V_FOOT] * work[per_fall]))
            work[WORST_GROWTH] = work[GROWTH]
        work[SHORTEST] = work[NOW + X_BODY] - work[NOW + X_FOOT]
        work[LONGEST], work[LOWEST] = work[SHORTEST], work[NOW + X_BODY]
        work[START_ENERGY] = energy(work[MODE], work)
        if granular and work[CLEARED] == CLEAR:
            work[DEEPEST] = 0.0
        if lands:
            meet_ground(work)
            work[DEPTH] = max(0.0, -work[NOW + X_FOOT])
        else:
            row[touchdown] = np.nan
        if work[MODE] == JAMMED:
            settle(work)
        work[FRESH], work[STALE] = 1, 1

    return begin_jump
