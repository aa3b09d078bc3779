"""The jump loop: steps between events, events between modes, jumps between touchdowns."""

from __future__ import annotations

import math

from simulator.compiled import Function, Row, inlined, inner
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.control.controller import make_switch, make_tick, make_wants_switch
from simulator.kernel.events.contact import GOES_ON, make_lift_off, make_meet_ground, make_settle
from simulator.kernel.events.first_event import make_set_near
from simulator.kernel.events.transitions import make_transition
from simulator.kernel.layout import (
    ABOVE_PRINT,
    AIRBORNE,
    ALLOWED,
    ASLEEP,
    CARRIED_ROUND,
    CLEARED,
    COMPRESSION,
    FLIGHT,
    INTRUDING,
    LENGTH_UNIT,
    LIFTOFF_REACHED,
    MODE,
    NO_LIFTOFF,
    NO_TRIGGER,
    NOW,
    PARAMETERS,
    PHASE,
    SPEED_UNIT,
    STEP,
    STEP_LIMIT,
    STEPS,
    STEPS_ALLOWED,
    TICK,
    TIME,
    TIMEOUT,
    TOLERANCE,
    TOUCHDOWN,
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
from simulator.kernel.report import make_finish
from simulator.kernel.start import make_begin, make_begin_jump
from simulator.kernel.steps.step_loop import (
    make_control,
    make_finish_step,
    make_note_mode,
    make_record,
    make_touch_down,
)
from simulator.kernel.steps.stride import REJECTED, make_stride
from simulator.kernel.working_row import address_of
from simulator.parameter import GRAVITY_M_S2

FIRST_STEP_S = 1e-3


def make_given_up(composition: Composition) -> Function:
    """Compose `(work)`: the outcome of a jump that does not end by itself, or `GOES_ON`."""
    lasting = composition.on("touchdown_impact")

    @inner
    def given_up(work: Row) -> int:
        if work[STEPS] >= work[STEPS_ALLOWED]:
            return STEP_LIMIT
        if work[MODE] != FLIGHT and work[TIME] >= LONGEST_STANCE_S:
            if lasting and work[AIRBORNE] == 1:
                return CARRIED_ROUND
            return NO_TRIGGER if lasting and work[PHASE] == COMPRESSION else NO_LIFTOFF
        return TIMEOUT if work[TIME] >= LONGEST_FLIGHT_S else GOES_ON

    return given_up


@inlined
def steps_alone(work: Row) -> bool:
    """Whether nothing but time passes until the next event: the foot is in the ground, or free in the air."""
    if work[MODE] == FLIGHT:
        return work[CLEARED] >= ABOVE_PRINT
    return work[MODE] == INTRUDING and work[ASLEEP] == 0


@made_once
def make_begin_scene(composition: Composition) -> Function:
    """Compose `(work, limits)`: the scene before its first jump; returns the jump loop's first outcome."""
    begin, set_near = make_begin(composition), make_set_near(composition)
    prepare, rest = composition.prepare, composition.position["rest_length"]
    derived, end = PARAMETERS + len(composition.parameters), composition.row_size

    @inner
    def begin_scene(work: Row, limits: Row) -> int:
        for i in range(derived, end):  # what effects changed in the scene before
            work[i] = 0.0
        prepare(work)
        begin(work)
        work[TOLERANCE], work[ALLOWED] = limits[TOLERANCE_WANTED], EVENT_SHARE * limits[TOLERANCE_WANTED]
        work[LENGTH_UNIT] = DECISION_SHARE * work[TOLERANCE] * work[rest]
        work[SPEED_UNIT] = DECISION_SHARE * work[TOLERANCE] * math.sqrt(GRAVITY_M_S2 * work[rest])
        set_near(work)
        work[STEP], work[STEPS_ALLOWED] = FIRST_STEP_S, limits[MOST_STEPS]
        return TOUCHDOWN if work[NOW + X_FOOT] <= 0.0 else GOES_ON

    return begin_scene


@made_once
def make_jump_loop(composition: Composition) -> Function:
    """Compose `(work, limits, rows, changes, trace, jump, in_jump, outcome, pauses)`: steps from where a jump is.

    `rows`, `changes` and `trace` are those of `make_run`. Returns the number of jumps written; where it `pauses`, it
    returns -1 less the number of the jump as soon as a step has been taken and the next ones stand alone.
    """
    wants_switch, switch = make_wants_switch(composition), make_switch(composition)
    lift_off = make_lift_off(composition)
    settle = make_settle(composition, lift_off)
    control = make_control(composition, make_tick(composition, wants_switch, switch), settle)
    stride = make_stride(composition, wants_switch)
    transition = make_transition(composition, switch, settle, lift_off)
    finish_step, record, note_mode = (
        make_finish_step(composition, transition, settle),
        make_record(composition),
        make_note_mode(composition),
    )
    meet_ground = make_meet_ground(composition)
    touch_down = make_touch_down(meet_ground, settle)
    begin_jump = make_begin_jump(composition, meet_ground, settle)
    finish, given_up = make_finish(composition), make_given_up(composition)
    sampled, rate = composition.on("sampled_control"), composition.position.get("control_rate", -1)

    @inner
    def jump_loop(
        work: Row,
        limits: Row,
        rows: Row,
        changes: Row,
        trace: Row,
        jump: int,
        in_jump: bool,
        outcome: int,
        pauses: bool,
    ) -> int:
        recorded, row = 0, address_of(rows[jump])
        while True:
            if outcome >= 0 and in_jump:
                finish(outcome, work, row)
                jump += 1
                if outcome != TOUCHDOWN or jump >= limits[JUMPS_WANTED]:
                    return jump
            if outcome >= 0:
                before, row = work[MODE], address_of(rows[jump])
                begin_jump(work, row, outcome == TOUCHDOWN)
                in_jump = True
                if outcome != TOUCHDOWN:  # it never came down
                    finish(outcome, work, row)
                    return jump + 1
                note_mode(before, jump, work, row, changes)
            mode = work[MODE]
            if in_jump:
                control(work, limits[FLIP_TICK])
                if work[MODE] != mode:
                    note_mode(mode, jump, work, row, changes)
            outcome = given_up(work)
            if work[MODE] == FLIGHT and work[AIRBORNE] == 1 and limits[STOP_AFTER] == STOP_AFTER_LIFTOFF:
                outcome = LIFTOFF_REACHED
            if outcome >= 0:
                continue
            mode = work[MODE]
            event = stride(limits, work)
            if event == REJECTED:
                outcome = GOES_ON
                continue
            if recorded < trace.shape[0]:
                recorded = record(mode, jump, recorded, work, trace)
            outcome = finish_step(event, work, row, limits[STOP_AFTER])
            if outcome == TOUCHDOWN and in_jump:
                outcome = touch_down(work, row)
            if sampled and in_jump and mode == FLIGHT and work[MODE] != FLIGHT:
                while work[TICK] / work[rate] < work[TIME]:
                    work[TICK] += 1
            if work[MODE] != mode:
                note_mode(mode, jump, work, row, changes)
            if pauses and in_jump and outcome == GOES_ON and steps_alone(work):
                return -1 - jump

    return jump_loop


@made_once
def make_run(composition: Composition) -> Function:
    """Compose the kernel `(work, limits, rows, changes, trace)`; it returns the number of jumps written.

    `work`, shape (size of the composition,): the scene's parameters in their places. `rows`, shape (jumps, columns).
    `changes`, shape (any, 4): jump, time, mode before, mode after. `trace`, shape (any, 4 + 4 states): the accepted
    steps.
    """
    begin_scene, jump_loop = make_begin_scene(composition), make_jump_loop(composition)

    @inner
    def run(work: Row, limits: Row, rows: Row, changes: Row, trace: Row) -> int:
        outcome = begin_scene(work, limits)
        return jump_loop(work, limits, rows, changes, trace, 0, False, outcome, False)

    return run
