"""Guards of the foot: in flight it comes down and clears the ground, on the ground it stops, yields and lifts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inlined
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import (
    ABOVE_PRINT,
    BOTTOMS,
    CARRIED,
    CLEAR,
    CLEARED,
    CLEARS,
    CREEPING,
    DEEPEST,
    EXTENSION,
    FALLS,
    IN_PRINT,
    INTRUDING,
    JAMMED,
    LIFTS,
    PHASE,
    SETTLES,
    SINKING,
    SLIDES,
    STOPS,
    TOUCHES,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
    YIELDS,
)
from simulator.kernel.mechanics.body import make_body_acceleration
from simulator.kernel.mechanics.leg import make_apply, make_command, make_lever
from simulator.kernel.mechanics.margins import make_foot_margins
from simulator.kernel.mechanics.motion import make_force_rate, make_ground
from simulator.kernel.mechanics.platform import make_platform

Row = NDArray[np.float64]


def make_flight_guards(composition: Composition) -> Function:
    """Compose `(t, work, row, place)`: the body falls, and the foot touches the ground, or clears it."""
    platform, platform_place = make_platform(composition), composition.platform
    slides, travel_m = composition.platform >= 0, composition.slot("travel_m")
    granular = composition.on("hydrostatic_stiffness")

    @inlined
    def flight_guards(t: float, work: Row, row: int, place: int) -> None:
        height_m = work[row + X_FOOT]
        if work[CLEARED] == CLEAR:
            work[place + TOUCHES] = -height_m
        elif granular and work[CLEARED] == SINKING:
            work[place + CLEARS] = work[row + V_FOOT]
        elif granular and work[CLEARED] == IN_PRINT:
            work[place + CLEARS] = height_m - work[DEEPEST]
        elif slides and work[SLIDES] == 1:
            work[place + TOUCHES] = work[row + platform_place] - height_m
            work[place + STOPS] = work[row + platform_place + 1]
            work[place + BOTTOMS] = -work[row + platform_place] - travel_m(work)
        elif work[CLEARED] == ABOVE_PRINT:
            work[place + TOUCHES] = platform(work, t)[0] - height_m
            if granular:
                work[place + CLEARS] = height_m
        work[place + FALLS] = -work[row + V_BODY]

    return flight_guards


def make_intruding_guards(composition: Composition) -> Function:
    """Compose `(work, row, place, applied_n)`: the foot stops, is at the end of the travel, or is lifted."""
    emulated, travel_m = composition.has("travel_m"), composition.slot("travel_m")
    slides, foot, ground = composition.platform >= 0, composition.position["foot_mass"], make_ground(composition)

    @inlined
    def intruding_guards(work: Row, row: int, place: int, applied_n: float) -> None:
        work[place + STOPS] = work[row + V_FOOT]
        if emulated:
            work[place + BOTTOMS] = -work[row + X_FOOT] - travel_m(work)
        if slides:  # the foot leaves a platform that slows down less than it does
            a_f = ground(work, applied_n, work[row + X_FOOT], work[row + V_FOOT])[0]
            work[place + LIFTS] = applied_n - work[foot] * (a_f + GRAVITY_M_S2)

    return intruding_guards


def make_creeping_guards(composition: Composition) -> Function:
    """Compose `(work, row, place, length_m, applied_n)`: the ground no longer yields, or the platform is at its end."""
    if not composition.follows:
        force_rate, accelerate = make_force_rate(composition), make_body_acceleration(composition)

        @inlined
        def creeping_guards(work: Row, row: int, place: int, length_m: float, applied_n: float) -> None:
            a_b = accelerate(CREEPING, work, row, applied_n)
            work[place + SETTLES] = force_rate(work, length_m, work[row + V_BODY], a_b)

        return creeping_guards
    margins, lever, travel_m = make_foot_margins(composition), make_lever(composition), composition.slot("travel_m")
    command, apply = make_command(composition), make_apply(composition)

    @inlined
    def following_guards(work: Row, row: int, place: int, length_m: float, applied_n: float) -> None:
        resting_n = apply(work, lever(work, length_m), command(work, length_m, work[row + V_BODY], 0.0))
        beyond_m = -work[row + X_FOOT] - travel_m(work)
        work[place + BOTTOMS] = beyond_m
        if beyond_m < 0.0:  # where the platform ends nothing yields, and a foot does not settle but bottoms
            work[place + SETTLES] = -margins(work, row, resting_n)[1]

    return following_guards


def make_contact_guards(composition: Composition) -> Function:
    """Compose `(t, work, row, place, mode, applied_n)`: those of a foot on the ground, by its mode."""
    margins, platform, foot = (
        make_foot_margins(composition),
        make_platform(composition),
        composition.position["foot_mass"],
    )
    unyielding = composition.on("touchdown_impact")
    intruding_guards, creeping_guards = make_intruding_guards(composition), make_creeping_guards(composition)

    @inlined
    def contact_guards(t: float, work: Row, row: int, place: int, mode: float, applied_n: float) -> None:
        if unyielding and work[PHASE] == EXTENSION:
            work[place + FALLS] = -work[row + V_BODY]
        if mode == INTRUDING:
            intruding_guards(work, row, place, applied_n)
        elif mode == CREEPING:
            creeping_guards(work, row, place, work[row + X_BODY] - work[row + X_FOOT], applied_n)
        else:
            lifting_n, yielding_n = margins(work, row, applied_n)
            if mode == JAMMED:
                work[place + LIFTS], work[place + YIELDS] = lifting_n, yielding_n
            elif mode == CARRIED:
                work[place + LIFTS] = lifting_n - work[foot] * platform(work, t)[2]

    return contact_guards
