"""Guards: functions of time and state whose rise through zero is an event."""

from __future__ import annotations

from simulator.compiled import Function, Row, inlined, inner
from simulator.effects.effect import MODES
from simulator.kernel.combined import in_turn, nothing
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.control.controller import make_conditions, make_rule
from simulator.kernel.effect_functions import EffectGuard
from simulator.kernel.layout import (
    ABOVE_PRINT,
    ARMED,
    ASLEEP,
    BEYOND,
    BOTTOMS,
    CAP_KINK,
    CARRIED,
    CLEAR,
    CLEARED,
    CLEARS,
    CONDITIONS,
    COST_CAPPED,
    COST_KINK,
    CREEPING,
    DEEPEST,
    EMULATOR,
    EXTENSION,
    FALLS,
    FLIGHT,
    FOLDS,
    GUARDS_BEFORE,
    HOLD,
    HOLD_SINCE,
    HOLD_TURNS,
    HOLDS,
    IN_PRINT,
    INTRUDING,
    JAMMED,
    LIFTS,
    MODE,
    NOW,
    OF_EFFECTS,
    PHASE,
    RELEASED,
    RELEASES,
    SATURATED,
    SETTLES,
    SINKING,
    SLIDES,
    STOPS,
    STRAIGHTENS,
    SWITCHES,
    TIME,
    TOUCHES,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
    YIELDS,
)
from simulator.kernel.mechanics.leg import (
    make_apply,
    make_command,
    make_cost_force,
    make_foot_margins,
    make_forces,
    make_lever,
    make_most,
)
from simulator.kernel.mechanics.motion import (
    make_body_acceleration,
    make_drive,
    make_force_rate,
    make_ground,
    make_platform,
)
from simulator.kernel.working_row import choose
from simulator.parameter import GRAVITY_M_S2, HARD_GROUND_INSETS_M


def _in_modes(one: EffectGuard) -> tuple[bool, ...]:
    return tuple(mode in one.guard.modes for mode in MODES)


def make_effect_guards(composition: Composition) -> Function:
    """Compose `(mode, work, row, place, commanded_n, applied_n)`: guards that effects declare, each in its modes."""
    filled = (
        _filled_of_force(composition, one) if one.guard.of_force else _filled(one) for one in composition.effect_guards
    )
    return in_turn(filled)


def _filled(one: EffectGuard) -> Function:
    value, guard, acts = one.value, one.place, _in_modes(one)

    @inlined
    def filled(mode: float, work: Row, row: int, place: int, commanded_n: float, applied_n: float) -> None:
        if acts[int(mode)]:
            work[place + guard] = value(work, row)

    return filled


def _filled_of_force(composition: Composition, one: EffectGuard) -> Function:
    """Compose the guard of a force: below zero on the side where the step starts (`_with_side`)."""
    value, guard, other_side, acts = one.value, one.place, ARMED + one.place - OF_EFFECTS, _in_modes(one)
    lever, cost_force = make_lever(composition), make_cost_force(composition)

    @inlined
    def filled(mode: float, work: Row, row: int, place: int, commanded_n: float, applied_n: float) -> None:
        if acts[int(mode)]:
            lever_m = lever(work, work[row + X_BODY] - work[row + X_FOOT])
            cost_n = cost_force(work, lever_m, commanded_n, applied_n)
            size = value(work, lever_m, work[row + V_BODY] - work[row + V_FOOT], cost_n)
            work[place + guard] = choose(work[other_side] == 1.0, -size, size)

    return filled


def make_due(composition: Composition) -> Function:
    """Compose `(work)`: the event of an effect that is due as a step starts, -1 for none.

    It is one that was not positive before, and became so as another event ended the step. Guards of the start are known
    (`GUARDS_BEFORE`); those that are not positive are armed.
    """
    due = inner(lambda work: -1)
    for one in composition.effect_guards:
        if one.guard.of_force:
            due = _with_side(due, one)
        elif one.happens is not None:
            due = _with_due(due, one)
    return due


def _with_side(before: Function, one: EffectGuard) -> Function:
    """Take the side on which a guard of a force starts: it is below zero there."""
    guard, other_side = one.place, ARMED + one.place - OF_EFFECTS

    @inner
    def due(work: Row) -> int:
        if work[GUARDS_BEFORE + guard] > 0.0:
            work[GUARDS_BEFORE + guard] = -work[GUARDS_BEFORE + guard]
            work[other_side] = 1 - work[other_side]
        return before(work)

    return due


def _with_due(before: Function, one: EffectGuard) -> Function:
    guard, armed, acts = one.place, ARMED + one.place - OF_EFFECTS, _in_modes(one)

    @inner
    def due(work: Row) -> int:
        found = before(work)
        if acts[int(work[MODE])]:
            if work[GUARDS_BEFORE + guard] <= 0.0:
                work[armed] = 1
            elif work[armed] == 1 and found < 0:
                found = guard
        return found

    return due


def make_effects_happen(composition: Composition) -> Function:
    """Compose `(event, work)`: what effects do at this event, their own or another that ends their mode as well."""
    return in_turn(_happening(one, one.happens) for one in composition.effect_guards if one.happens is not None)


def _happening(one: EffectGuard, act: Function) -> Function:
    guard, armed, acts, value = one.place, ARMED + one.place - OF_EFFECTS, _in_modes(one), one.value

    @inner
    def happen(event: int, work: Row) -> None:
        if event == guard or (work[armed] == 1 and acts[int(work[MODE])] and value(work, NOW) > 0.0):
            work[armed] = 0
            act(work, NOW)

    return happen


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
    emulated, travel_m = composition.optional("travel_m")
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
        speed_m_s = work[row + V_BODY]
        resting_n = apply(work, lever(work, length_m), speed_m_s, command(work, length_m, speed_m_s, 0.0))
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


KINK = 1e-12
"""Share of the cap within which the force is at it."""


def make_reach_guards(composition: Composition) -> Function:
    """Compose `(work, place, mode, length_m)`: the leg is folded, or straight."""
    upper, lower = composition.position["upper_link"], composition.position["lower_link"]
    levered, straight_ends_flight = composition.levered, composition.straight_ends_flight
    unyielding = composition.on("touchdown_impact")
    inset_folded_m, inset_straight_m = HARD_GROUND_INSETS_M if unyielding else (0.0, 0.0)

    @inlined
    def reach_guards(work: Row, place: int, mode: float, length_m: float) -> None:
        work[place + FOLDS] = work[lower] - work[upper] + inset_folded_m - length_m
        if mode != FLIGHT or straight_ends_flight:
            work[place + STRAIGHTENS] = length_m - work[upper] - work[lower] + inset_straight_m
        elif levered:  # the lever's corner
            beyond_m = length_m - work[upper] - work[lower]
            work[place + STRAIGHTENS] = beyond_m if work[BEYOND] == 0 else -beyond_m

    return reach_guards


@inlined
def beyond_cap(sign: float, force_n: float, most_n: float) -> float:
    """How far the force is beyond its cap (where `sign` is 0), or back from it, N."""
    return choose(sign == 0.0, abs(force_n) - most_n, most_n - sign * force_n) - KINK * most_n


def make_cap_guards(composition: Composition) -> Function:
    """Compose `(work, row, place, commanded_n, most_n)`: the force goes beyond its cap, or back; where the cap falls
    with the leg's speed, also as it comes to 0, beyond which the motors give nothing, or back.
    """
    if not composition.has("cap_n"):
        return nothing
    if not composition.has("cap_slows"):

        @inlined
        def cap_guards(work: Row, row: int, place: int, commanded_n: float, most_n: float) -> None:
            work[place + CAP_KINK] = beyond_cap(work[SATURATED], commanded_n, most_n)

        return cap_guards
    most, lever = make_most(composition), make_lever(composition)

    @inlined
    def slowing_cap_guards(work: Row, row: int, place: int, commanded_n: float, most_n: float) -> None:
        length_m, speed_m_s = work[row + X_BODY] - work[row + X_FOOT], work[row + V_BODY] - work[row + V_FOOT]
        arm_m, saturated = lever(work, length_m), work[SATURATED]
        if saturated == 0.0:  # both ways, so that it is continuous where the force changes its sign
            pull_n, push_n = max(most(work, arm_m, speed_m_s, 1.0), 0.0), max(most(work, arm_m, speed_m_s, -1.0), 0.0)
            beyond_n = max(commanded_n - (1.0 + KINK) * pull_n, -commanded_n - (1.0 + KINK) * push_n)
        else:
            wanted_n = commanded_n if saturated > 0.0 else -commanded_n
            most_n = most(work, arm_m, speed_m_s, saturated)
            given = abs(saturated) == 1.0
            beyond_n = max(most_n - wanted_n, -most_n) if given else max(most_n, -wanted_n)
            beyond_n -= KINK * abs(wanted_n)
        work[place + CAP_KINK] = beyond_n

    return slowing_cap_guards


def make_cost_guards(composition: Composition) -> Function:
    """Compose `(work, place, length_m, applied_n)`: the force goes beyond the cap of the cost, or back."""
    if not composition.has("cost_cap_n"):
        return nothing
    cost_cap_n, lever = composition.slots["cost_cap_n"], make_lever(composition)

    @inlined
    def cost_guards(work: Row, place: int, length_m: float, applied_n: float) -> None:
        most_n = cost_cap_n(work, lever(work, length_m))
        work[place + COST_KINK] = beyond_cap(work[COST_CAPPED], applied_n, most_n)

    return cost_guards


def make_release_guards(composition: Composition) -> Function:
    """Compose `(work, place, length_m)`: the ratchet lets the platform go; a step ends when it may do so first."""
    if not composition.has("travel_m"):
        return nothing
    at = composition.position
    rest, tolerance, shortest = at["rest_length"], at["release_tolerance"], at["shortest_hold"]

    @inlined
    def release_guards(work: Row, place: int, length_m: float) -> None:
        held_long = work[EMULATOR] == HOLD and work[TIME] >= work[HOLD_SINCE] + work[shortest]
        if held_long and work[PHASE] == EXTENSION and work[RELEASED] == 0:
            work[place + RELEASES] = length_m - work[rest] + work[tolerance]

    return release_guards


def make_hold_guards(composition: Composition) -> Function:
    """Compose `(mode, work, row, place, applied_n)`: the body stops where an effect may hold it, or is pushed on."""
    if not composition.has("hold_guard"):
        return nothing
    hold_guard, drive_n = composition.slots["hold_guard"], make_drive(composition)

    @inlined
    def hold_guards(mode: float, work: Row, row: int, place: int, applied_n: float) -> None:
        work[place + HOLD_TURNS] = hold_guard(work, drive_n(mode, work, row, applied_n), work[row + V_BODY])

    return hold_guards


@made_once
def make_guards(composition: Composition) -> Function:
    """Compose `(t, work, row, place)`; guards that cannot fire in the mode read -1."""
    forces, cap_guards = make_forces(composition), make_cap_guards(composition)
    flight_guards, contact_guards = make_flight_guards(composition), make_contact_guards(composition)
    reach_guards, cost_guards = make_reach_guards(composition), make_cost_guards(composition)
    release_guards, hold_guards = make_release_guards(composition), make_hold_guards(composition)
    effect_guards = make_effect_guards(composition)
    conditions, rule, count = make_conditions(composition), make_rule(composition), composition.guards
    continuous, granular = not composition.on("sampled_control"), composition.on("hydrostatic_stiffness")

    @inner
    def guards(t: float, work: Row, row: int, place: int) -> None:
        for i in range(count):
            work[place + i] = -1.0
        mode = work[MODE]
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        commanded_n, applied_n, most_n = forces(work, row)
        reach_guards(work, place, mode, length_m)
        if mode == FLIGHT:
            flight_guards(t, work, row, place)
        else:
            contact_guards(t, work, row, place, mode, applied_n)
        cap_guards(work, row, place, commanded_n, most_n)
        cost_guards(work, place, length_m, applied_n)
        # on grains the controller waits for the ground
        if continuous and (not granular or (mode != FLIGHT and work[ASLEEP] == 0)):
            values = conditions(work, work[PHASE], row)
            for one in range(CONDITIONS):
                work[place + SWITCHES + one] = values[one] if work[HOLDS + one] == 0.0 else -values[one]
            if rule(work):  # the phase was changed by something else
                work[place + SWITCHES] = 1.0
        release_guards(work, place, length_m)
        hold_guards(mode, work, row, place, applied_n)
        effect_guards(mode, work, row, place, commanded_n, applied_n)

    return guards
