"""What the events of the foot do: it touches the ground, stops, yields or lifts; the body falls, the platform ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.events.standstill import GOES_ON, make_stop_foot
from simulator.kernel.layout import (
    ABOVE_PRINT,
    AIRBORNE,
    APEX,
    ASLEEP,
    BOTTOMED,
    CARRIED,
    CLEAR,
    CLEARED,
    DEEPEST,
    DEPTH,
    FLIGHT,
    INTRUDING,
    LENGTH_UNIT,
    MARGIN,
    MARGIN_TICK,
    MODE,
    NO_LIFTOFF,
    NOW,
    SLIDES,
    SPEED_UNIT,
    TIME,
    TOUCHDOWN,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.limits import NEAR_PEAK, STOP_AFTER_APEX
from simulator.kernel.mechanics.platform import make_stop_platform
from simulator.kernel.rows import COLUMN

Row = NDArray[np.float64]


@inner
def note_near(distance: float, unit: float, work: Row) -> None:
    """Note how near another event was, in local errors of the state, by which the jump would have gone on otherwise."""
    if abs(distance) < unit * min(work[MARGIN], NEAR_PEAK):
        work[MARGIN], work[MARGIN_TICK] = abs(distance) / unit, -1.0


def make_touches(composition: Composition) -> Function:
    """The foot meets the ground in flight: `(work)`. On grains a rising body goes on with its stance."""
    granular = composition.on("hydrostatic_stiffness")
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    grain = composition.integrals.get("grain_energy", -1)

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
        if has_mass:
            work[NOW + grain] += 0.5 * mass(work, -work[NOW + X_FOOT]) * work[NOW + V_FOOT] * work[NOW + V_FOOT]
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
    apex_height, apex_time = COLUMN["apex_height_m"], COLUMN["apex_time_s"]
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
        return inner(lambda work: None)
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
