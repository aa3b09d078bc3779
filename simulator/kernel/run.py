"""The jump loop: steps between events, events between modes, jumps between touchdowns."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.contact import make_lift_off, make_note_saturation, make_settle
from simulator.kernel.controller import make_wants_switch
from simulator.kernel.decide import make_switch, make_tick
from simulator.kernel.emulator import make_advance
from simulator.kernel.events import GOES_ON, make_happen
from simulator.kernel.landing import make_meet_ground
from simulator.kernel.layout import (
    ABOVE_PRINT,
    AIRBORNE,
    ALLOWED,
    CAPPED,
    CARRIED_ROUND,
    CLEARED,
    COMPRESSION,
    CREEPING,
    DEEPEST,
    DEPTH,
    EVENTS,
    FLIGHT,
    FRESH,
    IN_PRINT,
    INTRUDING,
    JAMMED,
    K1,
    K7,
    LENGTH_UNIT,
    LIFTOFF_REACHED,
    MODE,
    NO_LIFTOFF,
    NO_TRIGGER,
    NOW,
    OFFSET,
    PHASE,
    SATURATED,
    SPEED_UNIT,
    STALE,
    STEP,
    STEP_LIMIT,
    STEPS,
    STRIDE,
    TICK,
    TIME,
    TIMEOUT,
    TOLERANCE,
    TOUCHDOWN,
    TRACED,
    TRIAL,
    V_BODY,
    X_FOOT,
)
from simulator.kernel.limits import (
    DECISION_SHARE,
    EVENT_SHARE,
    FLIP_TICK,
    JUMPS_WANTED,
    LONGEST_FLIGHT_S,
    LONGEST_STANCE_S,
    MOST_STEPS,
    STOP_AFTER,
    STOP_AFTER_LIFTOFF,
)
from simulator.kernel.limits import TOLERANCE as TOLERANCE_WANTED
from simulator.kernel.report import make_finish, make_note_liftoff
from simulator.kernel.rows import COLUMN
from simulator.kernel.start import make_begin, make_begin_jump
from simulator.kernel.stride import REJECTED, TIMED, make_stride

Row = NDArray[np.float64]
FIRST_STEP_S = 1e-3


def make_notice(composition: Composition) -> Function:
    """Compose `(before, jump, work, row, changes)`: note a change of the contact mode, and a lift-off's state."""
    note_liftoff = make_note_liftoff(composition)

    @inner
    def notice(before: float, jump: int, work: Row, row: Row, changes: Row) -> None:
        mode = work[MODE]
        if mode == before:
            return
        if mode == FLIGHT:
            note_liftoff(work, row)
        place = int(work[TRACED])
        if place < changes.shape[0]:
            changes[place, 0], changes[place, 1], changes[place, 2], changes[place, 3] = jump, work[TIME], before, mode
            work[TRACED] += 1
        work[EVENTS] += 1
        work[FRESH] = 1 if mode in (INTRUDING, FLIGHT) else 0

    return notice


def make_control(composition: Composition, tick: Function, settle: Function) -> Function:
    """Compose `(work, flip_tick)`: the decisions of the ticks that are due, and what they do to a resting foot."""
    if not composition.on("sampled_control"):
        return inner(lambda work, flip_tick: None)
    rate = composition.position["control_rate"]
    note = make_note_saturation(composition)

    @inner
    def control(work: Row, flip_tick: float) -> None:
        if work[MODE] == FLIGHT:
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
    """Compose `(before, jump, recorded, work, trace)`: keep an accepted step; a trace without rows keeps none."""
    size = composition.state_size

    @inner
    def record(mode: float, jump: int, recorded: int, work: Row, trace: Row) -> int:
        if recorded >= trace.shape[0] or work[STRIDE] == 0.0:
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


def make_follow(composition: Composition, happen: Function, settle: Function) -> Function:
    """Compose `(event, work, row, stop_after)`: go to the end of the step, and do what happens there."""
    size, advance = composition.state_size, make_advance(composition)

    @inner
    def follow(event: int, work: Row, row: Row, stop_after: float) -> int:
        for i in range(size):
            work[NOW + i] = work[TRIAL + i]
            work[K1 + i] = work[K7 + i]
        if work[SATURATED] == 1:
            work[CAPPED] += work[STRIDE]
        if work[MODE] != FLIGHT:
            work[DEPTH] = max(work[DEPTH], -work[NOW + X_FOOT])
        elif work[CLEARED] == IN_PRINT and work[NOW + X_FOOT] > work[DEEPEST]:
            work[CLEARED] = ABOVE_PRINT
        if event >= 0:
            return happen(event, work, row, stop_after)
        if event == TIMED:
            advance(work)
            if work[MODE] == JAMMED:
                settle(work)
        return GOES_ON

    return follow


def make_given_up(composition: Composition) -> Function:
    """Compose `(work, most_steps)`: the outcome of a jump that does not end by itself, or `GOES_ON`."""
    lasting = composition.on("touchdown_impact")

    @inner
    def given_up(work: Row, most_steps: float) -> int:
        if work[STEPS] >= most_steps:
            return STEP_LIMIT
        if work[MODE] != FLIGHT and work[TIME] >= LONGEST_STANCE_S:
            if lasting and work[AIRBORNE] == 1:
                return CARRIED_ROUND
            return NO_TRIGGER if lasting and work[PHASE] == COMPRESSION else NO_LIFTOFF
        return TIMEOUT if work[TIME] >= LONGEST_FLIGHT_S else GOES_ON

    return given_up


def make_run(composition: Composition) -> Function:
    """Compose the kernel `(work, limits, rows, changes, trace)`; it returns the number of jumps written.

    `work`, shape (size of the composition,): the scene's parameters in their places. `rows`, shape (jumps, columns).
    `changes`, shape (any, 4): jump, time, mode before, mode after. `trace`, shape (any, 4 + 4 states): the accepted
    steps.
    """
    wants_switch, switch = make_wants_switch(composition), make_switch(composition)
    lift_off = make_lift_off(composition)
    settle = make_settle(composition, lift_off)
    control = make_control(composition, make_tick(composition, wants_switch, switch), settle)
    stride = make_stride(composition, wants_switch)
    happen = make_happen(composition, switch, settle, lift_off)
    follow, record, notice = (
        make_follow(composition, happen, settle),
        make_record(composition),
        make_notice(composition),
    )
    meet_ground = make_meet_ground(composition)
    begin, begin_jump = make_begin(composition), make_begin_jump(composition, meet_ground, settle)
    finish, prepare, given_up = make_finish(composition), composition.prepare, make_given_up(composition)
    rest, sampled = composition.position["rest_length"], composition.on("sampled_control")
    rate = composition.position.get("control_rate", -1)
    next_time, next_speed = COLUMN["next_touchdown_time_s"], COLUMN["next_touchdown_body_velocity_m_s"]

    @inner
    def touch_down(work: Row, row: Row, in_jump: bool) -> int:
        if in_jump and (work[AIRBORNE] == 0 or work[NOW + V_BODY] >= 0.0):
            meet_ground(work)  # the jump goes on
            if work[MODE] == JAMMED:
                settle(work)
            return GOES_ON
        if in_jump:
            row[next_time], row[next_speed] = work[TIME], work[NOW + V_BODY]
        return TOUCHDOWN

    @inner
    def run(work: Row, limits: Row, rows: Row, changes: Row, trace: Row) -> int:
        prepare(work)
        begin(work)
        work[TOLERANCE], work[ALLOWED] = limits[TOLERANCE_WANTED], EVENT_SHARE * limits[TOLERANCE_WANTED]
        work[LENGTH_UNIT] = DECISION_SHARE * work[TOLERANCE] * work[rest]
        work[SPEED_UNIT] = DECISION_SHARE * work[TOLERANCE] * math.sqrt(GRAVITY_M_S2 * work[rest])
        work[STEP] = FIRST_STEP_S
        jump, recorded, in_jump = 0, 0, False
        outcome = TOUCHDOWN if work[NOW + X_FOOT] <= 0.0 else GOES_ON
        while True:
            if outcome >= 0 and in_jump:
                finish(outcome, work, rows[jump])
                jump += 1
                if outcome != TOUCHDOWN or jump >= limits[JUMPS_WANTED]:
                    return jump
            if outcome >= 0:
                before = work[MODE]
                begin_jump(work, rows[jump])
                in_jump = True
                if outcome != TOUCHDOWN:  # it never came down
                    finish(outcome, work, rows[jump])
                    return jump + 1
                notice(before, jump, work, rows[jump], changes)
            row = rows[jump]
            mode = work[MODE]
            if in_jump:
                control(work, limits[FLIP_TICK])
                notice(mode, jump, work, row, changes)
            outcome = given_up(work, limits[MOST_STEPS])
            if work[MODE] == FLIGHT and work[AIRBORNE] == 1 and limits[STOP_AFTER] == STOP_AFTER_LIFTOFF:
                outcome = LIFTOFF_REACHED
            if outcome >= 0:
                continue
            mode = work[MODE]
            event = stride(limits, work)
            if event == REJECTED:
                outcome = GOES_ON
                continue
            recorded = record(mode, jump, recorded, work, trace)
            outcome = follow(event, work, row, limits[STOP_AFTER])
            if outcome == TOUCHDOWN:
                outcome = touch_down(work, row, in_jump)
            if sampled and in_jump and mode == FLIGHT and work[MODE] != FLIGHT:
                while work[TICK] / work[rate] < work[TIME]:
                    work[TICK] += 1
            notice(mode, jump, work, row, changes)

    return run
