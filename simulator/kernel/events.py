"""What happens at an event: the mode graph's edges, and the outcomes that end a jump.

intruding --stops--> jammed --yields--> intruding (or creeping, on very stiff ground) ; creeping --settles--> jammed
jammed --lifts--> flight --touches--> intruding | jammed | carried ; carried --lifts--> flight
intruding --bottoms--> jammed (the emulator's stop)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.contact import make_note_saturation
from simulator.kernel.guards import make_forces
from simulator.kernel.layout import (
    ABOVE_PRINT,
    AIRBORNE,
    ALLOWED,
    APEX,
    BEYOND,
    BOOK,
    BOTTOMED,
    BOTTOMS,
    CAP_KINK,
    CARRIED,
    CLEAR,
    CLEARED,
    CLEARS,
    COMPRESSION,
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
    HOLD,
    IMPACT,
    IN_PRINT,
    INTRUDING,
    JAMMED,
    LEG_FOLDED,
    LEG_STRAIGHT,
    LIFTS,
    MODE,
    NO_LIFTOFF,
    NOW,
    PHASE,
    RAIL,
    RELEASE,
    RELEASE_MISSED,
    RELEASED,
    RELEASES,
    RESTS,
    SATURATED,
    SETTLES,
    SLIDES,
    STOPS,
    STRAIGHTENS,
    SWITCHES,
    TIME,
    TOUCHDOWN,
    TOUCHES,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
    YIELDS,
)
from simulator.kernel.limits import STOP_AFTER_APEX
from simulator.kernel.moved_mass import make_moved_mass
from simulator.kernel.platform import make_stop_platform
from simulator.kernel.rows import COLUMN

Row = NDArray[np.float64]
GOES_ON = -1


def make_stop_foot(composition: Composition) -> Function:
    """Stop the foot at once: `(work)`; what it moved with is lost and booked."""
    moved_mass_kg = make_moved_mass(composition)

    @inner
    def stop_foot(work: Row) -> None:
        lost_j = 0.5 * moved_mass_kg(work, -work[NOW + X_FOOT]) * work[NOW + V_FOOT] * work[NOW + V_FOOT]
        work[BOOK] += lost_j
        work[IMPACT] += lost_j
        work[NOW + V_FOOT] = 0.0
        work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])
        work[MODE] = JAMMED

    return stop_foot


def make_rail_turns(composition: Composition) -> Function:
    """The body has stopped on its rail, or is pushed off it: `(work)`."""
    if not composition.has("rail_friction_n"):
        return inner(lambda work: None)
    forces, friction_n = make_forces(composition), composition.slots["rail_friction_n"]
    body = composition.position["body_mass"]

    @inner
    def rail_turns(work: Row) -> None:
        work[NOW + V_BODY] = 0.0
        drive_n = -forces(work, NOW)[1] - work[body] * GRAVITY_M_S2
        if abs(drive_n) <= friction_n(work):
            work[RAIL] = 0.0
        else:
            work[RAIL] = 1.0 if drive_n > 0.0 else -1.0

    return rail_turns


def make_held_still(composition: Composition) -> Function:
    """Whether the two phases hold the body where it is, each driving it back over the threshold of the other: `(work)`,
    after a switch. Without a clock the controller then switches without end, and the foot never leaves the ground.
    """
    if composition.on("sampled_control") or composition.on("latched_switching"):
        return inner(lambda work: False)
    forces, body = make_forces(composition), composition.position["body_mass"]

    @inner
    def held_still(work: Row) -> bool:
        if work[MODE] != JAMMED or abs(work[NOW + V_BODY]) > work[ALLOWED]:
            return False
        drive_n = -forces(work, NOW)[1] - work[body] * GRAVITY_M_S2
        return drive_n < 0.0 if work[PHASE] == EXTENSION else drive_n > 0.0

    return held_still


def make_happen(composition: Composition, switch: Function, settle: Function, lift_off: Function) -> Function:
    """Compose `(guard, work, row, stop_after)`.

    Returns an outcome that ends the jump, or `GOES_ON`. A touchdown leaves the foot where it is.
    """
    note, stop_foot, rail_turns = (
        make_note_saturation(composition),
        make_stop_foot(composition),
        make_rail_turns(composition),
    )
    forces, stop_platform = make_forces(composition), make_stop_platform(composition)
    held_still = make_held_still(composition)
    slides, platform, follows = composition.platform >= 0, composition.platform, composition.follows
    travel, emulated = composition.position.get("platform_travel", -1), composition.has("travel_m")
    granular, straight_ends_flight = composition.on("hydrostatic_stiffness"), composition.straight_ends_flight
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    grain = composition.integrals.get("grain_energy", -1)
    apex_height, apex_time = COLUMN["apex_height_m"], COLUMN["apex_time_s"]

    @inner
    def touches(work: Row) -> int:
        if not granular:
            return TOUCHDOWN
        if work[CLEARED] == IN_PRINT:  # pressed down too far for a foot that has left the ground
            work[DEEPEST] = work[NOW + X_FOOT]
        if work[NOW + V_BODY] < 0.0:
            return TOUCHDOWN
        if work[CLEARED] == CLEAR:  # the foot dips below the surface while the body rises: its old print lies deeper
            work[CLEARED] = ABOVE_PRINT
            return GOES_ON
        work[NOW + X_FOOT] = work[DEEPEST]
        work[MODE], work[AIRBORNE] = INTRUDING, 0
        if has_mass:
            work[NOW + grain] += 0.5 * mass(work, -work[NOW + X_FOOT]) * work[NOW + V_FOOT] * work[NOW + V_FOOT]
        return GOES_ON

    @inner
    def happen(guard: int, work: Row, row: Row, stop_after: float) -> int:
        if slides and guard == STOPS and work[MODE] == FLIGHT:
            stop_platform(work)
        elif guard == STOPS:
            if work[NOW + V_FOOT] < 0.0:  # stopped at once, by ground too stiff to follow how
                stop_foot(work)
            work[NOW + V_FOOT] = 0.0
            work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])
            settle(work)
        elif guard in (YIELDS, LIFTS):
            if slides and work[MODE] == INTRUDING:
                work[NOW + platform], work[NOW + platform + 1] = work[NOW + X_FOOT], work[NOW + V_FOOT]
                work[SLIDES] = 1
                lift_off(work)
            elif work[MODE] == CARRIED:
                lift_off(work)
            else:
                settle(work)
        elif guard == SETTLES:
            work[NOW + V_FOOT] = 0.0
            work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])
            work[MODE] = JAMMED
        elif guard == TOUCHES:
            return touches(work)
        elif guard == CLEARS:
            work[CLEARED] = ABOVE_PRINT if work[CLEARED] == IN_PRINT else CLEAR
        elif guard == FALLS:
            if work[MODE] != FLIGHT:
                return NO_LIFTOFF
            if np.isnan(row[apex_height]) and work[AIRBORNE] == 1:
                row[apex_height], row[apex_time] = work[NOW + X_BODY], work[TIME]
                if stop_after == STOP_AFTER_APEX:
                    return APEX
            if work[CLEARED] == IN_PRINT:  # the body falls and the foot never rose: it is still on the ground
                work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])
                return TOUCHDOWN
        elif guard == CAP_KINK:
            if work[SATURATED] == 0.0:
                work[SATURATED] = 1.0 if forces(work, NOW)[0] > 0.0 else -1.0
            else:
                work[SATURATED] = 0.0
            if follows and work[MODE] == CREEPING:
                settle(work)
        elif guard == COST_KINK:
            turned = 1.0 if forces(work, NOW)[1] > 0.0 else -1.0
            work[COST_CAPPED] = turned if work[COST_CAPPED] == 0.0 else 0.0
        elif guard == FOLDS:
            return LEG_FOLDED
        elif guard == STRAIGHTENS:
            if work[MODE] != FLIGHT or straight_ends_flight:
                return LEG_STRAIGHT
            work[BEYOND] = 1 - work[BEYOND]
        elif guard == SWITCHES:
            switch(work)
            note(work)
            if emulated and work[EMULATOR] == HOLD and work[PHASE] == COMPRESSION and work[RELEASED] == 0:
                work[RELEASE_MISSED] += 1
            if work[MODE] in (JAMMED, CREEPING):
                settle(work)
            if held_still(work):
                return NO_LIFTOFF
        elif guard == RELEASES:
            work[EMULATOR], work[RELEASED] = RELEASE, 1
            work[EMULATOR_SINCE] = work[TIME]
            stop_platform(work)
            if work[MODE] in (INTRUDING, CREEPING):
                stop_foot(work)
                settle(work)
        elif emulated and guard == BOTTOMS:
            work[BOTTOMED] += 1
            if slides and work[MODE] == FLIGHT:
                stop_platform(work)
                work[DEEPEST] = -work[travel]
                return GOES_ON
            work[NOW + X_FOOT] = -work[travel]
            work[DEPTH] = min(work[DEPTH], work[travel])
            stop_foot(work)
            settle(work)
        elif guard == RESTS:
            rail_turns(work)
        return GOES_ON

    return happen
