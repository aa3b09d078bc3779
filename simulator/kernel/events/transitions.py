"""What happens at an event: the mode graph's edges, and the outcomes that end a jump.

intruding --stops--> jammed --yields--> intruding (or creeping, on very stiff ground) ; creeping --settles--> jammed
jammed --lifts--> flight --touches--> intruding | jammed | carried ; carried --lifts--> flight
intruding --bottoms--> jammed (the emulator's stop)
"""

from __future__ import annotations

import math

import numpy as np

from simulator.compiled import Function, Row, inner
from simulator.kernel.combined import nothing
from simulator.kernel.composition import Composition
from simulator.kernel.control.controller import make_conditions, make_note_conditions, make_rule
from simulator.kernel.events.contact import (
    GOES_ON,
    make_held_still,
    make_join_grains,
    make_note_saturation,
    make_stop_foot,
    make_turn_hold,
    note_near,
)
from simulator.kernel.layout import (
    ABOVE_PRINT,
    AIRBORNE,
    APEX,
    ASLEEP,
    BEYOND,
    BOTTOMED,
    BOTTOMS,
    CAP_KINK,
    CARRIED,
    CLEAR,
    CLEARED,
    CLEARS,
    COMPRESSION,
    CONDITIONS,
    COST_CAPPED,
    COST_KINK,
    CREEPING,
    DEEPEST,
    DEPTH,
    EMULATOR,
    EMULATOR_SINCE,
    EXTENSION,
    FALLS,
    FLIGHT,
    FOLDS,
    HOLD_SINCE,
    HOLD_TURNS,
    INTRUDING,
    JAMMED,
    K1,
    LEG_FOLDED,
    LEG_STRAIGHT,
    LENGTH_UNIT,
    LIFTS,
    MODE,
    NO_LIFTOFF,
    NOW,
    PHASE,
    RELEASE,
    RELEASE_MISSED,
    RELEASED,
    RELEASES,
    SETTLES,
    SLIDES,
    SPEED_UNIT,
    STOPS,
    STRAIGHTENS,
    SWITCHED,
    SWITCHES,
    TIME,
    TOUCHDOWN,
    TOUCHES,
    V_BODY,
    V_FOOT,
    WORST_GROWTH,
    X_BODY,
    X_FOOT,
    YIELDS,
)
from simulator.kernel.limits import MOST_SWITCHES, SLOW_SWITCH, STOP_AFTER_APEX
from simulator.kernel.mechanics.leg import make_forces
from simulator.kernel.mechanics.motion import make_stop_platform
from simulator.kernel.rows import COLUMN
from simulator.parameter import GRAVITY_M_S2


def make_touches(composition: Composition) -> Function:
    """The foot meets the ground in flight: `(work)`. On grains a rising body goes on with its stance."""
    granular, join_grains = composition.on("hydrostatic_stiffness"), make_join_grains(composition)

    @inner
    def touches(work: Row) -> int:
        if not granular:
            return TOUCHDOWN
        note_near(work[NOW + V_BODY], work[SPEED_UNIT], work)
        if work[NOW + V_BODY] < 0.0:
            return TOUCHDOWN
        if work[CLEARED] == CLEAR:  # the foot dips below the surface while the body rises: its old print lies deeper
            work[CLEARED] = ABOVE_PRINT
            return GOES_ON
        work[NOW + X_FOOT] = work[DEEPEST]
        work[MODE], work[AIRBORNE], work[ASLEEP] = INTRUDING, 0, 0
        join_grains(work)
        return GOES_ON

    return touches


@inner
def rest(work: Row) -> None:
    """The foot rests where it is."""
    work[NOW + V_FOOT] = 0.0
    work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])


def make_stops(composition: Composition, settle: Function) -> Function:
    """The ground has stopped the foot, or a platform that moves without it has come to rest: `(work)`."""
    slides = composition.platform >= 0
    stop_foot, stop_platform = make_stop_foot(composition), make_stop_platform(composition)

    @inner
    def stops(work: Row) -> None:
        if slides and work[MODE] == FLIGHT:
            stop_platform(work)
            return
        if work[NOW + V_FOOT] < 0.0:  # stopped at once, by ground too stiff to follow how
            stop_foot(work)
        rest(work)
        settle(work)

    return stops


def make_unsettles(composition: Composition, settle: Function, lift_off: Function) -> Function:
    """Compose `(work)`: the ground under the foot yields, or the foot is lifted."""
    slides, platform = composition.platform >= 0, composition.platform

    @inner
    def unsettles(work: Row) -> None:
        if slides and work[MODE] == INTRUDING:
            work[NOW + platform], work[NOW + platform + 1] = work[NOW + X_FOOT], work[NOW + V_FOOT]
            work[SLIDES] = 1
            lift_off(work)
        elif work[MODE] == CARRIED:
            lift_off(work)
        else:
            settle(work)

    return unsettles


def make_falls(composition: Composition) -> Function:
    """The body turns and falls: `(work, row, stop_after)`. On the ground it then never leaves it."""
    apex_height, apex_time, apex_foot = COLUMN["apex_height_m"], COLUMN["apex_time_s"], COLUMN["apex_foot_height_m"]
    granular = composition.on("hydrostatic_stiffness")

    @inner
    def falls(work: Row, row: Row, stop_after: float) -> int:
        if work[MODE] != FLIGHT:
            return NO_LIFTOFF
        if granular:  # had the foot touched before, its stance might go on
            met_m = 0.0 if work[CLEARED] == CLEAR else work[DEEPEST]
            note_near(work[NOW + X_FOOT] - met_m, work[LENGTH_UNIT], work)
        if np.isnan(row[apex_height]) and work[AIRBORNE] == 1:
            row[apex_height], row[apex_time] = work[NOW + X_BODY], work[TIME]
            row[apex_foot] = work[NOW + X_FOOT]
            if stop_after == STOP_AFTER_APEX:
                return APEX
        if work[CLEARED] < ABOVE_PRINT:  # the body falls and the foot never rose: it is still on the ground
            work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])
            return TOUCHDOWN
        return GOES_ON

    return falls


def make_bottoms(composition: Composition, settle: Function) -> Function:
    """The platform comes to the end of its travel: `(work)`."""
    if not composition.has("travel_m"):
        return nothing
    slides, travel = composition.platform >= 0, composition.position["platform_travel"]
    stop_foot, stop_platform = make_stop_foot(composition), make_stop_platform(composition)

    @inner
    def bottoms(work: Row) -> None:
        work[BOTTOMED] += 1
        if slides and work[MODE] == FLIGHT:
            stop_platform(work)
            work[DEEPEST] = -work[travel]
            return
        work[NOW + X_FOOT] = -work[travel]
        work[DEPTH] = min(work[DEPTH], work[travel])
        stop_foot(work)
        settle(work)

    return bottoms


def make_cap_turns(composition: Composition, settle: Function) -> Function:
    """The force reaches its cap or leaves it: `(work)`."""
    note, follows = make_note_saturation(composition), composition.follows

    @inner
    def cap_turns(work: Row) -> None:
        note(work)
        if follows and work[MODE] == CREEPING:
            settle(work)

    return cap_turns


def make_note_conjunction(composition: Composition, conditions: Function) -> Function:
    """Compose `(work, condition)`: note how near the other one of two conditions that must hold together is.

    It decides where one begins to hold as the other ends; where both begin, their order changes nothing.
    """
    latched = composition.on("latched_switching")

    @inner
    def note_conjunction(work: Row, condition: int) -> None:
        stretching_m_s2, rising_m_s2 = work[K1 + V_BODY] - work[K1 + V_FOOT], work[K1 + V_BODY]
        shortening_m_s, other = work[NOW + V_FOOT] - work[NOW + V_BODY], 1 - condition
        rates = shortening_m_s * stretching_m_s2 if latched else stretching_m_s2 * rising_m_s2
        if other >= 0 and rates <= 0.0:
            unit = work[LENGTH_UNIT] if latched and other == 0 else work[SPEED_UNIT]
            note_near(conditions(work, work[PHASE], NOW)[other], unit, work)

    return note_conjunction


def make_note_slow_switch(composition: Composition) -> Function:
    """Compose `(work, condition)`: note how much an error of the state grows in the instant of a switch.

    The slower what decides it passes zero (the speed of a leg that has nearly come to rest), the less that is known.
    """
    latched = composition.on("latched_switching")
    per_fall, of_speed = composition.position["inverse_fall_speed"], 1 if latched else 0

    @inner
    def note_slow_switch(work: Row, condition: int) -> None:
        rate = abs(work[NOW + V_BODY] - work[NOW + V_FOOT]) * work[per_fall]  # of a length
        if condition == of_speed and (not latched or work[PHASE] == COMPRESSION):
            rate = abs(work[K1 + V_BODY] - work[K1 + V_FOOT]) / GRAVITY_M_S2
        elif not latched and condition == 1:
            rate = abs(work[K1 + V_BODY]) / GRAVITY_M_S2
        elif not latched and condition == 2:
            rate = abs(work[NOW + V_FOOT]) * work[per_fall]
        if rate < SLOW_SWITCH:
            work[WORST_GROWTH] = max(work[WORST_GROWTH], -math.log(rate + 1e-300))

    return note_slow_switch


def make_note_release(composition: Composition) -> Function:
    """Note how near to each other the shortest hold ends and the leg turns soft: `(work)`.

    The platform is released only if the hold ends first.
    """
    if not composition.has("travel_m"):
        return nothing
    conditions, shortest = make_conditions(composition), composition.position["shortest_hold"]

    @inner
    def note_release(work: Row) -> None:
        held_m = (work[TIME] - work[HOLD_SINCE] - work[shortest]) * (work[NOW + V_BODY] - work[NOW + V_FOOT])
        note_near(max(abs(held_m), abs(conditions(work, EXTENSION, NOW)[0])), work[LENGTH_UNIT], work)

    return note_release


def make_switches(composition: Composition, switch: Function, settle: Function) -> Function:
    """A condition of a controller without a clock has changed: `(work, condition)`; it may change its phase."""
    conditions = make_conditions(composition)
    rule, note_conditions = make_rule(composition), make_note_conditions(conditions)
    note_conjunction = make_note_conjunction(composition, conditions)
    note, held_still = make_note_saturation(composition), make_held_still(composition)
    note_release, note_slow_switch = make_note_release(composition), make_note_slow_switch(composition)

    @inner
    def switches(work: Row, condition: int) -> int:
        note_conjunction(work, condition)
        if not rule(work):
            note_conditions(work, condition)
            if not rule(work):
                return GOES_ON
        missed = work[RELEASE_MISSED]
        work[SWITCHED] += 1
        if work[SWITCHED] > MOST_SWITCHES:
            note_near(0.0, 1.0, work)
        else:
            note_slow_switch(work, condition)
        switch(work)
        note_conditions(work, -1)
        note(work)
        if work[RELEASE_MISSED] > missed:
            note_release(work)
        if work[MODE] in (JAMMED, CREEPING):
            settle(work)
        return NO_LIFTOFF if held_still(work) else GOES_ON

    return switches


def make_releases(composition: Composition, settle: Function) -> Function:
    """The ratchet lets the platform go: `(work)`."""
    stop_foot, stop_platform = make_stop_foot(composition), make_stop_platform(composition)
    note_release = make_note_release(composition)

    @inner
    def releases(work: Row) -> None:
        note_release(work)
        work[EMULATOR], work[RELEASED] = RELEASE, 1
        work[EMULATOR_SINCE] = work[TIME]
        stop_platform(work)
        if work[MODE] in (INTRUDING, CREEPING):
            stop_foot(work)
            settle(work)

    return releases


def make_transition(composition: Composition, switch: Function, settle: Function, lift_off: Function) -> Function:
    """Compose `(guard, work, row, stop_after)`.

    Returns an outcome that ends the jump, or `GOES_ON`. A touchdown leaves the foot where it is.
    """
    touches, falls, turn_hold = make_touches(composition), make_falls(composition), make_turn_hold(composition)
    stops, bottoms = make_stops(composition, settle), make_bottoms(composition, settle)
    unsettles, cap_turns = make_unsettles(composition, settle, lift_off), make_cap_turns(composition, settle)
    switches, releases = make_switches(composition, switch, settle), make_releases(composition, settle)
    forces, straight_ends_flight = make_forces(composition), composition.straight_ends_flight

    @inner
    def transition(guard: int, work: Row, row: Row, stop_after: float) -> int:
        if guard == STOPS:
            stops(work)
        elif guard in (YIELDS, LIFTS):
            unsettles(work)
        elif guard == SETTLES:
            rest(work)
            work[MODE] = JAMMED
        elif guard == TOUCHES:
            return touches(work)
        elif guard == CLEARS:
            work[CLEARED] += 1  # the states of a flying foot follow each other
        elif guard == FALLS:
            return falls(work, row, stop_after)
        elif guard == CAP_KINK:
            cap_turns(work)
        elif guard == COST_KINK:
            turned = 1.0 if forces(work, NOW)[1] > 0.0 else -1.0
            work[COST_CAPPED] = turned if work[COST_CAPPED] == 0.0 else 0.0
        elif guard == FOLDS:
            return LEG_FOLDED
        elif guard == STRAIGHTENS:
            if work[MODE] != FLIGHT or straight_ends_flight:
                return LEG_STRAIGHT
            work[BEYOND] = 1 - work[BEYOND]
        elif SWITCHES <= guard < SWITCHES + CONDITIONS:
            return switches(work, guard - SWITCHES)
        elif guard == RELEASES:
            releases(work)
        elif guard == BOTTOMS:
            bottoms(work)
        elif guard == HOLD_TURNS:
            turn_hold(work)
        return GOES_ON

    return transition
