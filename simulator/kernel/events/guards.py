"""Guards: functions of time and state whose rise through zero is an event."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inlined, inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.control.controller import make_conditions, make_rule
from simulator.kernel.events.effect_events import make_effect_guards
from simulator.kernel.events.foot_guards import make_contact_guards, make_flight_guards
from simulator.kernel.layout import (
    ASLEEP,
    BEYOND,
    CAP_KINK,
    CONDITIONS,
    COST_CAPPED,
    COST_KINK,
    EMULATOR,
    EXTENSION,
    FLIGHT,
    FOLDS,
    HOLD,
    HOLD_SINCE,
    HOLD_TURNS,
    HOLDS,
    MODE,
    PHASE,
    RELEASED,
    RELEASES,
    SATURATED,
    STRAIGHTENS,
    SWITCHES,
    TIME,
    V_BODY,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.body import make_drive
from simulator.kernel.mechanics.leg import make_lever
from simulator.kernel.mechanics.margins import make_forces
from simulator.kernel.working_row import choose

Row = NDArray[np.float64]
HARD_GROUND_INSETS_M = (1e-3, 1e-4)
"""On rigid and emulated ground the leg counts as folded or straight this much before it is, in flight too: the cost
counts there, and the joint's speed has a pole at both lengths."""
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


def make_cost_guards(composition: Composition) -> Function:
    """Compose `(work, place, length_m, applied_n)`: the force goes beyond the cap of the cost, or back."""
    if not composition.has("cost_cap_n"):
        return inner(lambda work, place, length_m, applied_n: None)
    cost_cap_n, lever = composition.slots["cost_cap_n"], make_lever(composition)

    @inlined
    def cost_guards(work: Row, place: int, length_m: float, applied_n: float) -> None:
        most_n = cost_cap_n(work, lever(work, length_m))
        work[place + COST_KINK] = beyond_cap(work[COST_CAPPED], applied_n, most_n)

    return cost_guards


def make_release_guards(composition: Composition) -> Function:
    """Compose `(work, place, length_m)`: the ratchet lets the platform go; a step ends when it may do so first."""
    if not composition.has("travel_m"):
        return inner(lambda work, place, length_m: None)
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
        return inner(lambda mode, work, row, place, applied_n: None)
    hold_guard, drive_n = composition.slots["hold_guard"], make_drive(composition)

    @inlined
    def hold_guards(mode: float, work: Row, row: int, place: int, applied_n: float) -> None:
        work[place + HOLD_TURNS] = hold_guard(work, drive_n(mode, work, row, applied_n), work[row + V_BODY])

    return hold_guards


@made_once
def make_guards(composition: Composition) -> Function:
    """Compose `(t, work, row, place)`; guards that cannot fire in the mode read -1."""
    forces, capped = make_forces(composition), composition.has("cap_n")
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
        if capped:
            work[place + CAP_KINK] = beyond_cap(work[SATURATED], commanded_n, most_n)
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
        effect_guards(mode, work, row, place)

    return guards
