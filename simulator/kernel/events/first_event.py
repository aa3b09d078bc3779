"""When within a step the first event happens, by the dense output at a few nodes of the step."""

from __future__ import annotations

from simulator.compiled import Function, Row, inlined, inner
from simulator.kernel.composition import Composition
from simulator.kernel.events.guards import make_due
from simulator.kernel.layout import (
    BETWEEN,
    FALLS,
    FOLDS,
    GUARDS,
    GUARDS_AFTER,
    GUARDS_BEFORE,
    GUARDS_BETWEEN,
    GUARDS_EARLIER,
    LENGTH_UNIT,
    LIFTS,
    MARGIN,
    MARGIN_TICK,
    NEAR,
    NOW,
    PROMPT,
    QUARTER,
    RELEASES,
    SPEED_UNIT,
    STALE,
    STRAIGHTENS,
    SWITCHES,
    TOUCHES,
    TRIAL,
    V_BODY,
    V_FOOT,
    WIDTH,
)
from simulator.kernel.limits import NEAR_PEAK, SLOW_M_S

MOST_PASSED = 3
"""Events that a landing may pass and go back to."""
SLOW_S_M = 10.0
"""For how long the instant of a slow foot's contact is uncertain, for each metre allowed to a landing: starting at the
ground it takes long to sink by so much.
"""


@inner
def is_prompt(guard: int) -> bool:
    """Whether a guard is never positive while its mode lasts."""
    return guard < PROMPT or guard >= SWITCHES


def make_at_once(composition: Composition, guards: Function) -> Function:
    """Compose `(t, work)`: the guard that is positive already at the start of a step and must not be, -1 for none.

    After a step without an event the guards at its end are those at the start of the next.
    """
    count, due = composition.guards, make_due(composition)

    @inner
    def at_once(t: float, work: Row) -> int:
        if work[STALE] == 1:
            guards(t, work, NOW, GUARDS_BEFORE)
        positive = 0
        for guard in range(count):
            positive += 1 if work[GUARDS_BEFORE + guard] > 0.0 else 0
        if positive > 0:
            for guard in range(count):
                if work[GUARDS_BEFORE + guard] > 0.0 and is_prompt(guard):
                    return guard
        return due(work)

    return at_once


def make_land(guards: Function, interpolate: Function, attempt: Function, count: int) -> Function:
    """Compose the landing on an event: steps from the start until the guard is positive by no more than `allowed`.

    `(guard, share, allowed, t, h, work)` returns the guard and the step's length; `TRIAL` holds the state there. It is
    another guard that has happened where the dense output saw one too early: steps to it then pass the other; and none,
    -1, where only the dense output had it rise.
    """

    @inner
    def slope_at(guard: int, share: float, t: float, h: float, work: Row) -> float:
        aside = min(1e-3, 0.25 * share)
        interpolate(h, share - aside, work, BETWEEN)
        guards(t + (share - aside) * h, work, BETWEEN, GUARDS_BEFORE)
        interpolate(h, share + aside, work, BETWEEN)
        guards(t + (share + aside) * h, work, BETWEEN, GUARDS_AFTER)
        return (work[GUARDS_AFTER + guard] - work[GUARDS_BEFORE + guard]) / (2.0 * aside * h)

    @inner
    def close_in(guard: int, length: float, high: float, slope: float, allowed: float, t: float, work: Row) -> float:
        low, end = 0.0, t + high
        for iteration in range(80):
            attempt(t, length, work)
            guards(t + length, work, TRIAL, GUARDS_BETWEEN)
            g = work[GUARDS_BETWEEN + guard]
            if 0.0 < g <= allowed and (
                guard != TOUCHES or work[TRIAL + V_FOOT] < -SLOW_M_S or length - low <= SLOW_S_M * allowed
            ):
                break
            if g > 0.0:
                high = length
            else:
                low = length
            if high - low <= 4e-16 * end:
                length = high
                attempt(t, length, work)
                guards(t + length, work, TRIAL, GUARDS_BETWEEN)
                break
            guess = length - (g - 0.5 * allowed) / slope if slope > 0.0 else -1.0
            length = guess if low < guess < high and iteration < 8 else 0.5 * (low + high)
        return length

    @inner
    def passed(guard: int, allowed: float, work: Row) -> int:
        for other in range(count):
            if other != guard and work[GUARDS_BETWEEN + other] > allowed and is_prompt(other):
                return other
        if guard != FALLS and work[NOW + V_BODY] > 0.0 and work[GUARDS_BETWEEN + FALLS] > 0.0:
            return FALLS  # the landing of a guard that rises slowly ran past the body's turn
        return -1

    @inner
    def land(guard: int, share: float, allowed: float, t: float, h: float, work: Row) -> tuple[int, float]:
        length = close_in(guard, share * h, h, slope_at(guard, share, t, h, work), allowed, t, work)
        for _ in range(MOST_PASSED):
            if not work[GUARDS_BETWEEN + guard] > 0.0:
                guard = -1
            other = passed(guard, allowed, work)
            if other < 0:
                break
            guard, length = other, close_in(other, 0.5 * length, length, 0.0, allowed, t, work)
        return guard, length

    return land


CLOSE = 1e-9
"""Share of a step to which the dense output's instant is refined before steps are taken to it."""
ASIDE = 0.01
"""Share of the way between two nodes at which a guard is looked at that is zero at the first."""
CLIMBS = 4
"""Parabolas by which a peak between nodes is looked for."""
PARABOLA = 0.25
"""By how much a guard may rise over a parabola through three nodes, as a share of the parabola's bend."""
FROM_AFAR = 0.1
"""Share of the distance within which a peak is noted from beyond which it must come: a guard starts at zero after an
event.
"""
NEVER = 2.0
"""A share of a step beyond its end."""


def make_value(guards: Function, interpolate: Function) -> Function:
    """Compose `(guard, share, t, h, work)`: a guard's value at a share of the step, by the dense output."""

    @inner
    def value(guard: int, share: float, t: float, h: float, work: Row) -> float:
        interpolate(h, share, work, BETWEEN)
        guards(t + share * h, work, BETWEEN, GUARDS_BETWEEN)
        return work[GUARDS_BETWEEN + guard]

    return value


def make_refine(value: Function) -> Function:
    """Compose `(guard, low, high, g_low, g_high, t, h, work)`: the share at which a guard rises between two others."""

    @inner
    def refine(
        guard: int, low: float, high: float, g_low: float, g_high: float, t: float, h: float, work: Row
    ) -> float:
        for _ in range(12):
            middle = high - g_high * (high - low) / (g_high - g_low)
            if not low < middle:  # the root is at the lower end, as where a guard starts at zero
                return min(high, low + CLOSE)
            if not middle < high:
                break
            g = value(guard, middle, t, h, work)
            if g > 0.0:
                close = high - middle < CLOSE
                high, g_high, g_low = middle, g, 0.5 * g_low
            else:
                close = middle - low < CLOSE
                low, g_low, g_high = middle, g, 0.5 * g_high
            if close:
                break
        return high

    return refine


def make_set_near(composition: Composition) -> Function:
    """Set how near to zero a peak hangs on the error of the state: `(work)`, for guards whose events change a jump at
    once.
    """
    k_compression, k_extension = composition.position["k_compression"], composition.position["k_extension"]

    @inner
    def set_near(work: Row) -> None:
        length_m, speed_m_s = NEAR_PEAK * work[LENGTH_UNIT], NEAR_PEAK * work[SPEED_UNIT]
        for guard in range(GUARDS):
            work[NEAR + guard] = max(length_m, speed_m_s) if guard >= SWITCHES else 0.0
        work[NEAR + LIFTS] = max(work[k_compression], work[k_extension]) * length_m
        work[NEAR + TOUCHES] = work[NEAR + FOLDS] = work[NEAR + STRAIGHTENS] = work[NEAR + RELEASES] = length_m

    return set_near


@inner
def note_peak(guard: int, peak: float, work: Row) -> None:
    """Keep how near to zero a guard has its peak, where no decision was nearer and it does not come from there."""
    near, peak = work[NEAR + guard], abs(peak)
    if peak < near and work[GUARDS_EARLIER + guard] < -FROM_AFAR * near and NEAR_PEAK * peak < work[MARGIN] * near:
        work[MARGIN], work[MARGIN_TICK] = NEAR_PEAK * peak / near, -1.0


@inlined
def may_peak(earlier: float, before: float, after: float, near: float) -> bool:
    """Whether a parabola through three values, none positive, comes so near to zero that a guard may rise over it, or
    has its peak as near.
    """
    rise, bend = after - earlier, 2.0 * before - earlier - after
    high = before + PARABOLA * bend + near
    over = (rise * rise + 8.0 * bend * high > 0.0) & (abs(rise) < 2.0 * bend)
    return over & (earlier <= 0.0) & (before <= 0.0) & (after <= 0.0)


@inner
def peaks(guard: int, work: Row) -> bool:
    """Whether a guard may rise over zero between the last three nodes, or have its peak near it."""
    earlier, before, after = work[GUARDS_EARLIER + guard], work[GUARDS_BEFORE + guard], work[GUARDS_AFTER + guard]
    return may_peak(earlier, before, after, work[NEAR + guard])


def make_rises_to_peak(value: Function, refine: Function) -> Function:
    """Compose `(guard, middle, width, t, h, work)`: the share at which a guard that peaks rises, or `NEVER`.

    How near to zero the peak is found is noted.
    """

    @inner
    def rises_to_peak(guard: int, middle: float, width: float, t: float, h: float, work: Row) -> float:
        low, high = middle - width, middle + width
        nearest = low + ASIDE * width if work[GUARDS_EARLIER + guard] == 0.0 else low  # beside a zero rounding may rise
        g_low, g_middle, g_high = (
            work[GUARDS_EARLIER + guard],
            work[GUARDS_BEFORE + guard],
            work[GUARDS_AFTER + guard],
        )
        for _ in range(CLIMBS):
            up, down = (middle - low) * (g_middle - g_high), (high - middle) * (g_middle - g_low)
            if not up + down > 0.0:
                break
            peak = middle - 0.5 * ((middle - low) * up - (high - middle) * down) / (up + down)
            if not (low < peak < high and peak != middle):
                break
            g = value(guard, peak, t, h, work)
            if peak < middle:
                high, middle, g_high, g_middle = middle, peak, g_middle, g
            else:
                low, middle, g_low, g_middle = middle, peak, g_middle, g
            if g > 0.0 and middle > nearest:
                note_peak(guard, g, work)
                return refine(guard, max(low, nearest), middle, g_low, g, t, h, work)
        note_peak(guard, g_middle, work)
        return NEVER

    return rises_to_peak


@inlined
def candidates(count: int, twice: bool, work: Row) -> int:
    """Count the guards that may rise since the node before; counted rather than looked for, which takes no branches."""
    found = 0
    for guard in range(count):
        found += 1 if work[GUARDS_BEFORE + guard] <= 0.0 and work[GUARDS_AFTER + guard] > 0.0 else 0
    if twice:
        for guard in range(count):
            found += 1 if peaks(guard, work) else 0
    return found


def make_earliest(value: Function, refine: Function, rises_to_peak: Function, count: int) -> Function:
    """Compose `(low, high, twice, t, h, work)`: the guard that rises first between two nodes (-1: none), and when."""

    @inner
    def earliest(low: float, high: float, twice: bool, t: float, h: float, work: Row) -> tuple[int, float]:
        found, share = -1, NEVER
        for guard in range(count):
            g_low, g_high, instant = work[GUARDS_BEFORE + guard], work[GUARDS_AFTER + guard], NEVER
            if g_low <= 0.0 and g_high > 0.0:
                first, beside = low, low + ASIDE * (high - low)
                g_beside = value(guard, beside, t, h, work) if g_low == 0.0 else 0.0
                if g_beside < 0.0:  # it leaves zero downward, and rises through it later
                    first, g_low = beside, g_beside
                instant = refine(guard, first, high, g_low, g_high, t, h, work)
            elif twice and peaks(guard, work):
                instant = rises_to_peak(guard, low, high - low, t, h, work)
            if instant < share:
                found, share = guard, instant
        return found, share

    return earliest


def make_first_event(guards: Function, interpolate: Function, count: int) -> Function:
    """Compose the search for the first guard that rises through zero: `(t, h, nodes, work)`, after `at_once`.

    It looks at 1, 2 or 4 nodes of the step, and where a parabola through three of them rises over zero. Returns the
    guard (-1: none) and its instant as a share of the step.
    """
    value = make_value(guards, interpolate)
    refine = make_refine(value)
    earliest = make_earliest(value, refine, make_rises_to_peak(value, refine), count)

    @inner
    def first_event(t: float, h: float, nodes: int, work: Row) -> tuple[int, float]:
        quarters, twice = 4 // nodes, False
        for node in range(quarters, 5, quarters):
            low, high = 0.25 * (node - quarters), 0.25 * node
            guards(t + high * h, work, TRIAL if node == 4 else QUARTER + WIDTH * (node - 1), GUARDS_AFTER)
            if candidates(count, twice, work) > 0:
                found, share = earliest(low, high, twice, t, h, work)
                if found >= 0:
                    return found, share
            twice = not twice
            for guard in range(count):
                work[GUARDS_EARLIER + guard] = work[GUARDS_BEFORE + guard]
                work[GUARDS_BEFORE + guard] = work[GUARDS_AFTER + guard]
        return -1, 1.0

    return first_event
