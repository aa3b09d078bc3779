"""The leg's controller: when it changes its phase (thesis 4.2.5, 5.1.1, and the published rule of ch. 3).

A clock asks the whole rule at its ticks. Without one each condition of the rule is an event of its own, so that no
moment in which all of them hold is passed over.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    COMPRESSION,
    CONDITIONS,
    HOLDS,
    NOW,
    PHASE,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.working_row import choose

Row = NDArray[np.float64]
SHORT = CONDITIONS - 1
"""Number of the condition that holds by itself: the leg is short."""


@made_once
def make_conditions(composition: Composition) -> Function:
    """Compose `(work, phase, row)`: what the rule asks for in a phase, each positive where it holds.

    Three conditions that must hold together, in m and m/s, and last that the leg is short, or 1 and -1 for none.
    """
    guarded, guard_m = composition.has("guard_length_m"), composition.slot("guard_length_m")
    rest, latched = composition.position["rest_length"], composition.on("latched_switching")
    compression_m, tolerance_m = composition.slot("switch_compression_m"), composition.slot("rest_tolerance_m")
    tolerance_m_s = composition.slot("switch_speed_tolerance_m_s")

    @inner
    def conditions(work: Row, phase: int, row: int) -> tuple[float, float, float, float]:
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        if latched and phase != COMPRESSION:
            return length_m - work[rest] + tolerance_m(work), 1.0, 1.0, -1.0
        short_m = guard_m(work) - length_m if guarded else -1.0
        lengthening_m_s = work[row + V_BODY] - work[row + V_FOOT]
        if latched:
            return work[rest] - compression_m(work) - length_m, lengthening_m_s + tolerance_m_s(work), 1.0, short_m
        return lengthening_m_s, work[row + V_BODY], -work[row + X_FOOT], short_m

    return conditions


def make_wants_switch(composition: Composition) -> Function:
    """Compose `(work, phase, row, length_unit_m, speed_unit_m_s)`, positive where the phase should change.

    Its value is the distance to the decision in units of the given errors: its sign decides, its size is the margin.
    """
    conditions, guarded = make_conditions(composition), composition.has("guard_length_m")
    if composition.on("latched_switching"):

        @inner
        def latched(work: Row, phase: int, row: int, length_unit_m: float, speed_unit_m_s: float) -> float:
            first_m, still_m_s, _, short_m = conditions(work, phase, row)
            if phase != COMPRESSION:
                return first_m / length_unit_m
            wish = min(first_m / length_unit_m, still_m_s / speed_unit_m_s)
            return max(wish, short_m / length_unit_m) if guarded else wish

        return latched

    @inner
    def unlatched(work: Row, phase: int, row: int, length_unit_m: float, speed_unit_m_s: float) -> float:
        lengthening_m_s, rising_m_s, depth_m, short_m = conditions(work, phase, row)
        # a foot in the ground is known to be there: its depth is known to a share of itself
        below = choose(depth_m > 0.0, np.inf, depth_m / length_unit_m)
        wish = min(lengthening_m_s / speed_unit_m_s, rising_m_s / speed_unit_m_s, below)
        if guarded:
            wish = max(wish, short_m / length_unit_m)
        return choose(phase == COMPRESSION, wish, -wish)

    return unlatched


@made_once
def make_rule(composition: Composition) -> Function:
    """Compose `(work)`: whether the phase should change, by which conditions are noted to hold."""
    latched = composition.on("latched_switching")

    @inner
    def rule(work: Row) -> bool:
        every = work[HOLDS] == 1.0 and work[HOLDS + 1] == 1.0 and work[HOLDS + 2] == 1.0
        extends = every or work[HOLDS + SHORT] == 1.0
        return extends if latched or work[PHASE] == COMPRESSION else not extends

    return rule


def make_note_conditions(conditions: Function) -> Function:
    """Compose `(work, turned)`: note which conditions hold; number `turned` (-1: none) has just changed."""

    @inner
    def note_conditions(work: Row, turned: int) -> None:
        values = conditions(work, work[PHASE], NOW)
        for one in range(CONDITIONS):
            held = work[HOLDS + one]
            work[HOLDS + one] = 1.0 - held if one == turned else 1.0 if values[one] > 0.0 else 0.0

    return note_conditions
