"""When within a step an event happens: first by the dense output, then by steps to the instant itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.layout import (
    BETWEEN,
    GUARDS,
    GUARDS_AFTER,
    GUARDS_BEFORE,
    GUARDS_BETWEEN,
    GUARDS_EARLIER,
    NOW,
    PROMPT,
    QUARTER,
    STALE,
    TRIAL,
    WIDTH,
)

Row = NDArray[np.float64]


CLOSE = 1e-9
"""Share of a step to which the dense output's instant is refined before steps are taken to it."""
MOST_PASSED = 3
"""Events that a landing may pass and go back to."""
CLIMBS = 4
"""Parabolas by which a peak between nodes is looked for."""
NEVER = 2.0
"""A share of a step beyond its end."""


def make_at_once(guards: Function) -> Function:
    """Compose `(t, work)`: the guard that is positive already at the start of a step and must not be, -1 for none.

    After a step without an event the guards at its end are those at the start of the next.
    """

    @inner
    def at_once(t: float, work: Row) -> int:
        if work[STALE] == 1:
            guards(t, work, NOW, GUARDS_BEFORE)
        positive = 0
        for guard in range(PROMPT):
            positive += 1 if work[GUARDS_BEFORE + guard] > 0.0 else 0
        if positive > 0:
            for guard in range(PROMPT):
                if work[GUARDS_BEFORE + guard] > 0.0:
                    return guard
        return -1

    return at_once


def make_first_event(guards: Function, interpolate: Function) -> Function:
    """Compose the search for the first guard that rises through zero: `(t, h, nodes, work)`, after `at_once`.

    It looks at 1, 2 or 4 nodes of the step, and where a parabola through three of them rises over zero. Returns the
    guard (-1: none) and its instant as a share of the step.
    """

    @inner
    def value(guard: int, share: float, t: float, h: float, work: Row) -> float:
        interpolate(h, share, work, BETWEEN)
        guards(t + share * h, work, BETWEEN, GUARDS_BETWEEN)
        return work[GUARDS_BETWEEN + guard]

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

    @inner
    def peaks(guard: int, work: Row) -> bool:
        earlier, before, after = work[GUARDS_EARLIER + guard], work[GUARDS_BEFORE + guard], work[GUARDS_AFTER + guard]
        rise, bend = after - earlier, 2.0 * before - earlier - after
        over = rise * rise + 8.0 * bend * before > 0.0 and abs(rise) < 2.0 * bend
        return over and earlier <= 0.0 and before <= 0.0 and after <= 0.0

    @inner
    def rises_to_peak(guard: int, middle: float, width: float, t: float, h: float, work: Row) -> float:
        low, high = middle - width, middle + width
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
            if g > 0.0:
                return refine(guard, low, middle, g_low, g, t, h, work)
        return NEVER

    @inner
    def first_event(t: float, h: float, nodes: int, work: Row) -> tuple[int, float]:
        quarters, twice = 4 // nodes, False
        for node in range(quarters, 5, quarters):
            low, high = 0.25 * (node - quarters), 0.25 * node
            guards(t + high * h, work, TRIAL if node == 4 else QUARTER + WIDTH * (node - 1), GUARDS_AFTER)
            rising, peaking = 0, 0
            for guard in range(GUARDS):
                rising += 1 if work[GUARDS_BEFORE + guard] <= 0.0 and work[GUARDS_AFTER + guard] > 0.0 else 0
            if twice:
                for guard in range(GUARDS):
                    peaking += 1 if peaks(guard, work) else 0
            if rising + peaking > 0:
                found, share = -1, NEVER
                for guard in range(GUARDS):
                    g_low, g_high, instant = work[GUARDS_BEFORE + guard], work[GUARDS_AFTER + guard], NEVER
                    if g_low <= 0.0 and g_high > 0.0:
                        instant = refine(guard, low, high, g_low, g_high, t, h, work)
                    elif twice and peaks(guard, work):
                        instant = rises_to_peak(guard, low, high - low, t, h, work)
                    if instant < share:
                        found, share = guard, instant
                if found >= 0:
                    return found, share
            twice = not twice
            for guard in range(GUARDS):
                work[GUARDS_EARLIER + guard] = work[GUARDS_BEFORE + guard]
                work[GUARDS_BEFORE + guard] = work[GUARDS_AFTER + guard]
        return -1, 1.0

    return first_event


def make_land(guards: Function, interpolate: Function, attempt: Function) -> Function:
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
            if 0.0 < g <= allowed:
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
        for other in range(PROMPT):
            if other != guard and work[GUARDS_BETWEEN + other] > allowed:
                return other
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
