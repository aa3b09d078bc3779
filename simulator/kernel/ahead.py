"""What limits a step before it is taken, and what control does inside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.interpolant import interpolate
from simulator.kernel.layout import (
    ALLOWED,
    BETWEEN,
    FLIGHT,
    FRESH,
    INTRUDING,
    LENGTH_UNIT,
    LONGEST,
    MARGIN,
    MARGIN_TICK,
    NOW,
    PHASE,
    SHORTEST,
    SPEED_UNIT,
    STEP,
    TICK,
    TIME,
    TRIAL,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)

Row = NDArray[np.float64]
FRESH_SHARE = 0.2
"""First step after the ground yields or the foot leaves it, in units of the foot's time scale: shorter than an
intrusion that ends at once."""
QUIET_SHARE, LONGEST_QUIET_STEP_S = 0.1, 0.02
INTRUDING_SHARE, SMOOTH_SHARE = 1.5, 0.7
"""Longest steps of a foot in the ground and otherwise, in the same units: no guard rises and falls unseen inside
one.
"""


def make_longest_step(composition: Composition) -> Function:
    """Longest step in a mode whose fastest frequency is `omega` (rad/s), s: `(work, mode, omega)`.

    In flight a leg that has stopped ringing, to what an event is allowed, limits nothing.
    """
    rest = composition.position["rest_length"]

    @inner
    def longest_step(work: Row, mode: float, omega: float) -> float:
        if mode == FLIGHT:
            stretch_m = work[NOW + X_BODY] - work[NOW + X_FOOT] - work[rest]
            ringing_m = abs(stretch_m) + abs(work[NOW + V_BODY] - work[NOW + V_FOOT]) / omega
            if ringing_m < QUIET_SHARE * work[ALLOWED] * work[rest]:
                return min(work[STEP], LONGEST_QUIET_STEP_S)
        return min(work[STEP], step_share(work, mode) / omega)

    return longest_step


@inner
def nodes_within(work: Row, mode: float, h: float, omega: float, exact: bool) -> int:
    """At how many nodes of a step guards are looked at: 4 in the longest one and in closed form, where the motion does
    not limit steps; fewer in one cut short by a tick.
    """
    if exact or h * omega > 0.5 * step_share(work, mode):
        return 4
    return 2 if h * omega > 0.25 * step_share(work, mode) else 1


@inner
def step_share(work: Row, mode: float) -> float:
    """Longest step of a mode in units of its time scale."""
    if work[FRESH] == 1:
        return FRESH_SHARE
    return INTRUDING_SHARE if mode == INTRUDING else SMOOTH_SHARE


def make_deciding_tick(composition: Composition, wants_switch: Function) -> Function:
    """Find the first tick inside a step at which the phase changes: `(h, until, work, flip_tick)`.

    Returns its time, or infinity; ticks passed without a change count as decided, with their margins.
    """
    rate = composition.position.get("control_rate", -1)

    @inner
    def deciding_tick(h: float, until: float, work: Row, flip_tick: float) -> float:
        while work[TICK] / work[rate] < until:
            tick_s = work[TICK] / work[rate]
            interpolate(h, (tick_s - work[TIME]) / h, work, BETWEEN)
            wish = wants_switch(work, work[PHASE], BETWEEN, work[LENGTH_UNIT], work[SPEED_UNIT])
            if (wish > 0.0) != (work[TICK] == flip_tick) and tick_s > work[TIME]:
                return tick_s
            if abs(wish) < work[MARGIN]:
                work[MARGIN], work[MARGIN_TICK] = abs(wish), work[TICK]
            work[TICK] += 1
        return np.inf

    return deciding_tick


@inner
def note_leg_lengths(h: float, work: Row) -> None:
    """Keep the shortest and the longest leg; inside a step they are where the leg's speed changes its sign."""
    length_m = work[TRIAL + X_BODY] - work[TRIAL + X_FOOT]
    work[SHORTEST], work[LONGEST] = min(work[SHORTEST], length_m), max(work[LONGEST], length_m)
    before = work[NOW + V_BODY] - work[NOW + V_FOOT]
    after = work[TRIAL + V_BODY] - work[TRIAL + V_FOOT]
    if before * after < 0.0:
        low, high = 0.0, 1.0
        for _ in range(30):
            share = 0.5 * (low + high)
            interpolate(h, share, work, BETWEEN)
            if before * (work[BETWEEN + V_BODY] - work[BETWEEN + V_FOOT]) > 0.0:
                low = share
            else:
                high = share
        length_m = work[BETWEEN + X_BODY] - work[BETWEEN + X_FOOT]
        work[SHORTEST], work[LONGEST] = min(work[SHORTEST], length_m), max(work[LONGEST], length_m)
