"""What may happen within a step of several lanes: guards at its nodes, as the scalar kernel looks at them."""

from __future__ import annotations

from typing import Any

from simulator.compiled import inlined, inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.events.first_event import may_peak
from simulator.kernel.events.guards import beyond_cap
from simulator.kernel.layout import (
    BEYOND,
    CLEAR,
    CLEARED,
    DEEPEST,
    FLIGHT,
    FOLDS,
    HALF,
    INTRUDING,
    NEAR,
    PERSISTENT,
    QUARTER,
    SATURATED,
    THREE_QUARTERS,
    TRIAL,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
    places,
)
from simulator.kernel.mechanics.margins import make_forces
from simulator.kernel.steps.dense_output import make_fit_quintics, make_interpolate
from simulator.kernel.steps.step_limits import step_share
from simulator.kernel.working_row import choose, lanes_in

Lanes = Any
"""A number of every lane, or whether something holds in each (`simulator.kernel.lanes.numbers`)."""
Row = Any
"""The working rows of all lanes, place by place."""
GUARDS = 6
"""Guards a mode, in its own order: the leg is folded, straight; the foot stops or touches; in the ground the cone is
complete, in the air the foot clears; the body falls; the force reaches its cap."""
PROMPT = {INTRUDING: (0, 1, 2, 5), FLIGHT: (0, 1, 2, 3, 5)}
"""Those that are never positive while the mode lasts."""
AT_START, AT_QUARTER, AT_HALF, AT_THREE_QUARTERS, AT_END = places(PERSISTENT, PERSISTENT + 5 * GUARDS, GUARDS)
"""Places of the guards' values at the start of a step, inside it and at its end."""
FREE = PERSISTENT + 5 * GUARDS
"""First place that guards leave free."""


def make_guards(composition: Composition, mode: int) -> Function:
    """Compose `(work, row, place)`: the guards of the mode at the state at `row`."""
    forces = make_forces(composition)
    upper, lower = composition.position["upper_link"], composition.position["lower_link"]
    capped, flying = composition.has("cap_n"), mode == FLIGHT
    (cone,) = composition.effect_guards  # no other scenes are in lanes
    is_complete = cone.value
    ends, levered = composition.straight_ends_flight, composition.levered

    @inlined
    def guards(work: Row, row: int, place: int) -> None:
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        work[place] = work[lower] - work[upper] - length_m
        beyond_m = length_m - work[upper] - work[lower]
        work[place + 1] = beyond_m
        if flying:
            if levered and not ends:
                work[place + 1] = choose(work[BEYOND] == 0.0, beyond_m, -beyond_m)
            elif not ends:
                work[place + 1] = -1.0
            clear, height_m = work[CLEARED] == CLEAR, work[row + X_FOOT]
            work[place + 2] = choose(clear, -height_m, work[DEEPEST] - height_m)
            work[place + 3] = choose(clear, -1.0, height_m)
            work[place + 4] = -work[row + V_BODY]
        else:
            work[place + 2] = work[row + V_FOOT]
            work[place + 3] = is_complete(work, row)
            work[place + 4] = -1.0
        work[place + 5] = -1.0
        if capped:
            commanded_n, _, most_n = forces(work, row)
            work[place + 5] = beyond_cap(work[SATURATED], commanded_n, most_n)

    return guards


@inlined
def rises(before: int, after: int, work: Row) -> Lanes:
    """Whether some guard rises through zero between two nodes."""
    found = work[before] < work[before]
    for guard in range(GUARDS):
        found |= (work[before + guard] <= 0.0) & (work[after + guard] > 0.0)
    return found


@inlined
def peaks(earlier: int, before: int, after: int, near: int, work: Row) -> Lanes:
    """Whether some guard comes near zero between three nodes, as `simulator.kernel.events.first_event.peaks` has it.

    The first `near` guards are lengths, of which it is noted how near.
    """
    found = work[before] < work[before]
    for guard in range(GUARDS):
        distance = work[NEAR + FOLDS] if guard < near else 0.0
        found |= may_peak(work[earlier + guard], work[before + guard], work[after + guard], distance)
    return found


def make_events(composition: Composition, mode: int, guards: Function, *, exact: bool) -> Function:
    """Compose `(h, omega, considered, work)`: whether something may happen in the step, in considered lanes."""
    fit, interpolate = make_fit_quintics(composition), make_interpolate(composition)
    near = 2 if mode == INTRUDING else 3

    @inlined
    def place(h: Lanes, share: float, work: Row, row: int) -> None:
        if not exact:  # a closed form has put it there already
            interpolate(h, share, work, row)

    @inner
    def events(h: Lanes, omega: Lanes, considered: Lanes, work: Row) -> Lanes:
        fit(h, work)
        longest = step_share(work, mode)
        four, two = h * omega > 0.5 * longest, h * omega > 0.25 * longest
        if exact:
            four = two = considered
        guards(work, TRIAL, AT_END)
        found = rises(AT_START, AT_END, work) & ~two
        if lanes_in(two & considered) != 0:
            place(h, 0.5, work, HALF)
            guards(work, HALF, AT_HALF)
            halves = rises(AT_START, AT_HALF, work) | rises(AT_HALF, AT_END, work)
            found |= (halves | peaks(AT_START, AT_HALF, AT_END, near, work)) & two & ~four
            if lanes_in(four & considered) != 0:
                place(h, 0.25, work, QUARTER)
                guards(work, QUARTER, AT_QUARTER)
                place(h, 0.75, work, THREE_QUARTERS)
                guards(work, THREE_QUARTERS, AT_THREE_QUARTERS)
                first = rises(AT_START, AT_QUARTER, work) | rises(AT_QUARTER, AT_HALF, work)
                first |= peaks(AT_START, AT_QUARTER, AT_HALF, near, work)
                second = rises(AT_HALF, AT_THREE_QUARTERS, work) | rises(AT_THREE_QUARTERS, AT_END, work)
                second |= peaks(AT_HALF, AT_THREE_QUARTERS, AT_END, near, work)
                found |= (first | second) & four
        return found & considered

    return events
