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

    It looks at 1, 2 or 4 nodes of the step. Returns the guard (-1: none) and its instant as a share of the step.
    """

    @inner
    def refine(guard: int, low: float, high: float, t: float, h: float, work: Row) -> float:
        g_low, g_high = work[GUARDS_BEFORE + guard], work[GUARDS_AFTER + guard]
        for _ in range(12):
            middle = high - g_high * (high - low) / (g_high - g_low)
            if not low < middle:  # the root is at the lower end, as where a guard starts at zero
                return min(high, low + CLOSE)
            if not middle < high:
                break
            interpolate(h, middle, work, BETWEEN)
            guards(t + middle * h, work, BETWEEN, GUARDS_BETWEEN)
            g = work[GUARDS_BETWEEN + guard]
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
    def first_event(t: float, h: float, nodes: int, work: Row) -> tuple[int, float]:
        quarters = 4 // nodes
        for node in range(quarters, 5, quarters):
            low, high = 0.25 * (node - quarters), 0.25 * node
            guards(t + high * h, work, TRIAL if node == 4 else QUARTER + WIDTH * (node - 1), GUARDS_AFTER)
            rising = 0
            for guard in range(GUARDS):
                rising += 1 if work[GUARDS_BEFORE + guard] <= 0.0 and work[GUARDS_AFTER + guard] > 0.0 else 0
            if rising > 0:
                found, share = -1, 2.0
                for guard in range(GUARDS):
                    if work[GUARDS_BEFORE + guard] <= 0.0 and work[GUARDS_AFTER + guard] > 0.0:
                        instant = refine(guard, low, high, t, h, work)
                        if instant < share:
                            found, share = guard, instant
                return found, share
            for guard in range(GUARDS):
                work[GUARDS_BEFORE + guard] = work[GUARDS_AFTER + guard]
        return -1, 1.0

    return first_event


def make_land(guards: Function, interpolate: Function, attempt: Function) -> Function:
    """Compose the landing on an event: steps from the start until the guard is positive by no more than `allowed`.

    `(guard, share, allowed, t, h, work)` returns the step's length; `TRIAL` holds the state there.
    """

    @inner
    def land(
        guard: int,
        share: float,
        allowed: float,
        t: float,
        h: float,
        work: Row,
    ) -> float:
        aside = min(1e-3, 0.25 * share)
        interpolate(h, share - aside, work, BETWEEN)
        guards(t + (share - aside) * h, work, BETWEEN, GUARDS_BEFORE)
        interpolate(h, share + aside, work, BETWEEN)
        guards(t + (share + aside) * h, work, BETWEEN, GUARDS_AFTER)
        slope = (work[GUARDS_AFTER + guard] - work[GUARDS_BEFORE + guard]) / (2.0 * aside * h)
        low, high, length = 0.0, h, share * h
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
            if high - low <= 4e-16 * (t + h):
                attempt(t, high, work)
                length = high
                break
            guess = length - (g - 0.5 * allowed) / slope if slope > 0.0 else -1.0
            length = guess if low < guess < high and iteration < 8 else 0.5 * (low + high)
        return length

    return land
