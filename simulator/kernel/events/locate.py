"""The event that is due as a step starts, and the landing on one within it, by steps to the instant itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.events.effect_events import make_due
from simulator.kernel.layout import (
    BETWEEN,
    GUARDS_AFTER,
    GUARDS_BEFORE,
    GUARDS_BETWEEN,
    NOW,
    PROMPT,
    STALE,
    SWITCHES,
    TOUCHES,
    TRIAL,
    V_FOOT,
)
from simulator.kernel.limits import SLOW_M_S

Row = NDArray[np.float64]
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
