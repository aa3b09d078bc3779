"""What surrounds a step: the decisions that are due before it, and after it the record, the event and the new mode."""

from __future__ import annotations

import numpy as np

from simulator.compiled import Function, Row, inner
from simulator.kernel.combined import nothing
from simulator.kernel.composition import Composition
from simulator.kernel.control.controller import make_advance
from simulator.kernel.events.contact import GOES_ON, make_creep_on, make_note_saturation
from simulator.kernel.events.guards import make_effects_happen
from simulator.kernel.layout import (
    ABOVE_PRINT,
    AIRBORNE,
    ASLEEP,
    CAPPED,
    CLEARED,
    CREEPING,
    DEEPEST,
    DEPTH,
    EVENTS,
    FLIGHT,
    FRESH,
    INTRUDING,
    JAMMED,
    K1,
    K7,
    MODE,
    NOW,
    OFFSET,
    SATURATED,
    STALE,
    STRIDE,
    TICK,
    TIME,
    TOUCHDOWN,
    TRACED,
    TRIAL,
    UNRESISTED,
    V_BODY,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.motion import make_try_to_follow
from simulator.kernel.report import make_note_liftoff
from simulator.kernel.rows import COLUMN
from simulator.kernel.steps.stride import TIMED, UNEVENTFUL


def make_note_mode(composition: Composition) -> Function:
    """Compose `(before, jump, work, row, changes)`: note that the contact mode is no longer `before`; at lift-off also
    the state.
    """
    note_liftoff = make_note_liftoff(composition)

    @inner
    def note_mode(before: float, jump: int, work: Row, row: Row, changes: Row) -> None:
        mode = work[MODE]
        if mode == FLIGHT:
            note_liftoff(work, row)
        place = int(work[TRACED])
        if place < changes.shape[0]:
            changes[place, 0], changes[place, 1], changes[place, 2], changes[place, 3] = jump, work[TIME], before, mode
            work[TRACED] += 1
        work[EVENTS] += 1
        work[FRESH] = 1 if mode in (INTRUDING, FLIGHT) else 0

    return note_mode


def make_control(composition: Composition, tick: Function, settle: Function) -> Function:
    """Compose `(work, flip_tick)`: the decisions of the ticks that are due, and what they do to a resting foot."""
    if not composition.on("sampled_control"):
        return nothing
    rate = composition.position["control_rate"]
    note, sleeps = make_note_saturation(composition), composition.sleeps_in_flight

    @inner
    def control(work: Row, flip_tick: float) -> None:
        if sleeps and (work[MODE] == FLIGHT or work[ASLEEP] == 1):
            return
        altered = False
        while work[TICK] / work[rate] <= work[TIME]:
            if tick(work, work[TICK] == flip_tick):
                altered = True
        if altered:
            work[STALE] = 1
            note(work)
            if work[MODE] == JAMMED or work[MODE] == CREEPING:
                settle(work)

    return control


def make_record(composition: Composition) -> Function:
    """Compose `(before, jump, recorded, work, trace)`: keep an accepted step."""
    size = composition.state_size

    @inner
    def record(mode: float, jump: int, recorded: int, work: Row, trace: Row) -> int:
        if work[STRIDE] == 0.0:
            return recorded
        start_s = work[OFFSET] + work[TIME] - work[STRIDE]
        trace[recorded, 0], trace[recorded, 1], trace[recorded, 2], trace[recorded, 3] = (
            start_s,
            work[STRIDE],
            mode,
            jump,
        )
        for i in range(size):
            trace[recorded, 4 + i] = work[NOW + i]
            trace[recorded, 4 + size + i] = work[K1 + i]
            trace[recorded, 4 + 2 * size + i] = work[TRIAL + i]
            trace[recorded, 4 + 3 * size + i] = work[K7 + i]
        return recorded + 1

    return record


def make_finish_step(composition: Composition, transition: Function, settle: Function) -> Function:
    """Compose `(event, work, row, stop_after)`: go to the end of the step, and do what happens there."""
    size, advance = composition.state_size, make_advance(composition)
    granular = composition.on("hydrostatic_stiffness")
    effects_happen = make_effects_happen(composition)
    try_to_follow, creep_on = make_try_to_follow(composition), make_creep_on(composition)

    @inner
    def finish_step(event: int, work: Row, row: Row, stop_after: float) -> int:
        for i in range(size):
            work[NOW + i] = work[TRIAL + i]
            work[K1 + i] = work[K7 + i]
        if work[SATURATED] != 0.0:
            work[CAPPED] += work[STRIDE]
        if work[MODE] != FLIGHT:
            work[DEPTH] = max(work[DEPTH], -work[NOW + X_FOOT])
        elif granular and work[CLEARED] < ABOVE_PRINT:
            work[UNRESISTED] = max(work[UNRESISTED], work[DEEPEST] - work[NOW + X_FOOT])
        if event != UNEVENTFUL:
            effects_happen(event, work)
        if event >= 0:
            return transition(event, work, row, stop_after)
        if event == TIMED:
            advance(work)
            if work[MODE] == JAMMED:
                settle(work)
        else:
            try_to_follow(work)
            creep_on(work)
        return GOES_ON

    return finish_step


def make_touch_down(meet_ground: Function, settle: Function) -> Function:
    """Compose `(work, row)`: a foot on the ground ends the jump only if it was in the air and the body falls."""
    time, speed = COLUMN["next_touchdown_time_s"], COLUMN["next_touchdown_body_velocity_m_s"]
    apex_height, apex_time, rising = COLUMN["apex_height_m"], COLUMN["apex_time_s"], COLUMN["liftoff_body_velocity_m_s"]
    apex_foot = COLUMN["apex_foot_height_m"]

    @inner
    def touch_down(work: Row, row: Row) -> int:
        if work[AIRBORNE] == 0 or work[NOW + V_BODY] >= 0.0:
            meet_ground(work)
            if work[MODE] == JAMMED:
                settle(work)
            return GOES_ON
        row[time], row[speed] = work[TIME], work[NOW + V_BODY]
        if np.isnan(row[apex_height]) and row[rising] > 0.0:  # it turned within what the landing is allowed
            row[apex_height], row[apex_time] = work[NOW + X_BODY], work[TIME]
            row[apex_foot] = work[NOW + X_FOOT]
        return TOUCHDOWN

    return touch_down
