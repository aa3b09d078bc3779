"""Guards: functions of time and state whose rise through zero is an event, and the margins that decide on contact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.body import make_body_acceleration
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ABOVE_PRINT,
    BEYOND,
    BOTTOMS,
    CAP_KINK,
    CARRIED,
    CLEAR,
    CLEARED,
    CLEARS,
    CONE_KINK,
    COST_CAPPED,
    COST_KINK,
    CREEPING,
    DEEPEST,
    EMULATOR,
    EXTENSION,
    FALLS,
    FLIGHT,
    FOLDS,
    GUARDS,
    HOLD,
    HOLD_SINCE,
    IN_PRINT,
    INTRUDING,
    JAMMED,
    LIFTS,
    MODE,
    PHASE,
    RAIL,
    RELEASED,
    RELEASES,
    RESTS,
    SATURATED,
    SETTLES,
    SLIDES,
    STOPS,
    STRAIGHTENS,
    SWITCHES,
    TOUCHES,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
    YIELDS,
)
from simulator.kernel.leg import make_apply, make_command, make_lever
from simulator.kernel.limits import DEEPEST_DIP_M
from simulator.kernel.motion import make_force_rate, make_ground
from simulator.kernel.platform import make_platform

Row = NDArray[np.float64]
AT_REST = 1e-12
"""Share of the forces on a foot that counts as rounding: less neither lifts it nor makes the ground yield."""
HARD_GROUND_INSETS_M = (1e-3, 1e-4)
"""On rigid and emulated ground the leg counts as folded or straight this much before it is, in flight too: the cost
counts there, and the joint's speed has a pole at both lengths."""
KINK = 1e-12
"""Share of the cap within which the force is at it."""


@made_once
def make_forces(composition: Composition) -> Function:
    """Commanded and applied force of the leg, and its cap, N: `(work, row)`."""
    lever, command, apply = make_lever(composition), make_command(composition), make_apply(composition)
    capped, cap_n = composition.has("cap_n"), composition.slot("cap_n")

    @inner
    def forces(work: Row, row: int) -> tuple[float, float, float]:
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        arm_m = lever(work, length_m)
        commanded_n = command(work, length_m, work[row + V_BODY] - work[row + V_FOOT], work[row + V_FOOT])
        most_n = cap_n(work, arm_m) if capped else np.inf
        return commanded_n, apply(work, arm_m, commanded_n), most_n

    return forces


@made_once
def make_foot_margins(composition: Composition) -> Function:
    """What lifts a resting foot and what makes the ground yield, N: `(work, row, applied_n)`.

    Both are positive only beyond rounding. Rigid ground, a ratchet outside *hold* and a platform at its stop do not
    yield.
    """
    foot = composition.position["foot_mass"]
    resistance_n = composition.slot("resistance_n")
    yields = composition.has("resistance_n")
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    emulated, travel_m = composition.has("travel_m"), composition.slot("travel_m")

    @inner
    def margins(work: Row, row: int, applied_n: float) -> tuple[float, float]:
        weight_n = work[foot] * GRAVITY_M_S2
        lifting_n = applied_n - weight_n - AT_REST * (abs(applied_n) + weight_n)
        if not yields:
            return lifting_n, -1.0
        depth_m = -work[row + X_FOOT]
        if emulated and (work[EMULATOR] != HOLD or depth_m >= travel_m(work)):
            return lifting_n, -1.0
        if has_mass:
            weight_n += mass(work, depth_m) * GRAVITY_M_S2
        hold_n = resistance_n(work, depth_m)
        yielding_n = weight_n - applied_n - hold_n - AT_REST * (abs(applied_n) + weight_n + hold_n)
        return lifting_n, yielding_n

    return margins


def make_guards(composition: Composition, wants_switch: Function) -> Function:
    """Compose `(t, work, row, place)`; guards that cannot fire in the mode read -1."""
    forces, margins, platform = make_forces(composition), make_foot_margins(composition), make_platform(composition)
    capped = composition.has("cap_n")
    cost_capped, cost_cap_n = composition.has("cost_cap_n"), composition.slot("cost_cap_n")
    kinked, kink_m = composition.has("kink_depth_m"), composition.slot("kink_depth_m")
    emulated, travel_m = composition.has("travel_m"), composition.slot("travel_m")
    continuous, unyielding = not composition.on("sampled_control"), composition.on("touchdown_impact")
    friction, friction_n = composition.has("rail_friction_n"), composition.slot("rail_friction_n")
    force_rate, granular = make_force_rate(composition), composition.on("hydrostatic_stiffness")
    levered, straight_ends_flight = composition.levered, composition.straight_ends_flight
    inset_folded_m, inset_straight_m = HARD_GROUND_INSETS_M if unyielding else (0.0, 0.0)
    at = composition.position
    upper, lower, rest, body, foot = (
        at["upper_link"],
        at["lower_link"],
        at["rest_length"],
        at["body_mass"],
        at["foot_mass"],
    )
    tolerance, shortest = at.get("release_tolerance", -1), at.get("shortest_hold", -1)

    follows, lever = composition.follows, make_lever(composition)
    command, apply = make_command(composition), make_apply(composition)
    slides, platform_place = composition.platform >= 0, composition.platform
    ground, accelerate = make_ground(composition), make_body_acceleration(composition)

    @inner
    def guards(t: float, work: Row, row: int, place: int) -> None:
        for i in range(GUARDS):
            work[place + i] = -1.0
        mode = work[MODE]
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        commanded_n, applied_n, most_n = forces(work, row)
        if mode == FLIGHT:
            height_m = work[row + X_FOOT]
            if work[CLEARED] == CLEAR:
                work[place + TOUCHES] = -height_m
            elif granular and work[CLEARED] == IN_PRINT:
                work[place + TOUCHES] = min(work[DEEPEST] - DEEPEST_DIP_M - height_m, -work[row + V_FOOT])
                work[place + CLEARS] = min(height_m - work[DEEPEST], work[row + V_FOOT])
            elif slides and work[SLIDES] == 1:
                work[place + TOUCHES] = work[row + platform_place] - height_m
                work[place + STOPS] = work[row + platform_place + 1]
                work[place + BOTTOMS] = -work[row + platform_place] - travel_m(work)
            elif work[CLEARED] == ABOVE_PRINT:
                work[place + TOUCHES] = platform(work, t)[0] - height_m
                if granular:
                    work[place + CLEARS] = height_m
            work[place + FALLS] = -work[row + V_BODY]
        work[place + FOLDS] = work[lower] - work[upper] + inset_folded_m - length_m
        if mode != FLIGHT or straight_ends_flight:
            work[place + STRAIGHTENS] = length_m - work[upper] - work[lower] + inset_straight_m
        elif levered:  # the lever's corner
            beyond_m = length_m - work[upper] - work[lower]
            work[place + STRAIGHTENS] = beyond_m if work[BEYOND] == 0 else -beyond_m
        if mode != FLIGHT:
            if unyielding and work[PHASE] == EXTENSION:
                work[place + FALLS] = -work[row + V_BODY]
            if mode == INTRUDING:
                work[place + STOPS] = work[row + V_FOOT]
                if kinked:
                    work[place + CONE_KINK] = -work[row + X_FOOT] - kink_m(work)
                if emulated:
                    work[place + BOTTOMS] = -work[row + X_FOOT] - travel_m(work)
                if slides:  # the foot leaves a platform that slows down less than it does
                    a_f = ground(work, applied_n, work[row + X_FOOT], work[row + V_FOOT])[0]
                    work[place + LIFTS] = applied_n - work[foot] * (a_f + GRAVITY_M_S2)
            elif follows and mode == CREEPING:
                resting_n = apply(work, lever(work, length_m), command(work, length_m, work[row + V_BODY], 0.0))
                beyond_m = -work[row + X_FOOT] - travel_m(work)
                work[place + BOTTOMS] = beyond_m
                if beyond_m < 0.0:  # where the platform ends nothing yields, and a foot does not settle but bottoms
                    work[place + SETTLES] = -margins(work, row, resting_n)[1]
            elif mode == CREEPING:
                work[place + SETTLES] = force_rate(work, length_m, work[row + V_BODY], accelerate(work, applied_n))
            else:
                lifting_n, yielding_n = margins(work, row, applied_n)
                if mode == JAMMED:
                    work[place + LIFTS], work[place + YIELDS] = lifting_n, yielding_n
                elif mode == CARRIED:
                    work[place + LIFTS] = lifting_n - work[foot] * platform(work, t)[2]
        if capped:
            sign = work[SATURATED]
            beyond_n = abs(commanded_n) - most_n if sign == 0.0 else most_n - sign * commanded_n
            work[place + CAP_KINK] = beyond_n - KINK * most_n
        if cost_capped:
            sign, most_n = work[COST_CAPPED], cost_cap_n(work, lever(work, length_m))
            beyond_n = abs(applied_n) - most_n if sign == 0.0 else most_n - sign * applied_n
            work[place + COST_KINK] = beyond_n - KINK * most_n
        if continuous and (not granular or mode != FLIGHT):  # on grains the controller waits for the ground
            work[place + SWITCHES] = wants_switch(work, work[PHASE], row, 1.0, 1.0)
        if emulated and work[EMULATOR] == HOLD and work[PHASE] == EXTENSION and work[RELEASED] == 0:
            near_m = length_m - work[rest] + work[tolerance]
            work[place + RELEASES] = min(near_m, t - work[HOLD_SINCE] - work[shortest])
        if friction:
            drive_n = -applied_n - work[body] * GRAVITY_M_S2
            if work[RAIL] == 0.0:
                work[place + RESTS] = abs(drive_n) - friction_n(work)
            else:
                work[place + RESTS] = -work[RAIL] * work[row + V_BODY]

    return guards
