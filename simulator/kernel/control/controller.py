"""The leg's controller: when it changes its phase (thesis 4.2.5, 5.1.1, and the published rule of ch. 3).

A clock asks the whole rule at its ticks. Without one each condition of the rule is an event of its own, so that no
moment in which all of them hold is passed over.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
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

Row = NDArray[np.float64]
SHORT = CONDITIONS - 1
"""Number of the condition that holds by itself: the leg is short."""


def make_wants_switch(composition: Composition) -> Function:
    """Compose `(work, phase, row, length_unit_m, speed_unit_m_s)`, positive where the phase should change.

    Its value is the distance to the decision in units of the given errors: its sign decides, its size is the margin.
    """
    guarded, guard_m = composition.has("guard_length_m"), composition.slot("guard_length_m")
    rest = composition.position["rest_length"]
    if composition.on("latched_switching"):
        compression_m = composition.slots["switch_compression_m"]
        tolerance_m_s, tolerance_m = (
            composition.slots["switch_speed_tolerance_m_s"],
            composition.slots["rest_tolerance_m"],
        )

        @inner
        def latched(work: Row, phase: int, row: int, length_unit_m: float, speed_unit_m_s: float) -> float:
            length_m = work[row + X_BODY] - work[row + X_FOOT]
            if phase == COMPRESSION:
                compressed = (work[rest] - compression_m(work) - length_m) / length_unit_m
                still = (work[row + V_BODY] - work[row + V_FOOT] + tolerance_m_s(work)) / speed_unit_m_s
                wish = min(compressed, still)
                if guarded:
                    wish = max(wish, (guard_m(work) - length_m) / length_unit_m)
                return wish
            return (length_m - work[rest] + tolerance_m(work)) / length_unit_m

        return latched

    @inner
    def unlatched(work: Row, phase: int, row: int, length_unit_m: float, speed_unit_m_s: float) -> float:
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        x_f = work[row + X_FOOT]
        # a foot in the ground is known to be there: its depth is known to a share of itself
        below = np.inf if x_f < 0.0 else -x_f / length_unit_m
        rising = work[row + V_BODY] / speed_unit_m_s
        lengthening = (work[row + V_BODY] - work[row + V_FOOT]) / speed_unit_m_s
        wish = min(lengthening, rising, below)
        if guarded:
            wish = max(wish, (guard_m(work) - length_m) / length_unit_m)
        return wish if phase == COMPRESSION else -wish

    return unlatched


def make_conditions(composition: Composition) -> Function:
    """Compose `(work, row, place)`: put what the rule asks for in the phase in force, each positive where it holds."""
    guarded, guard_m = composition.has("guard_length_m"), composition.slot("guard_length_m")
    rest, latched = composition.position["rest_length"], composition.on("latched_switching")
    compression_m, tolerance_m = composition.slot("switch_compression_m"), composition.slot("rest_tolerance_m")
    tolerance_m_s = composition.slot("switch_speed_tolerance_m_s")

    @inner
    def conditions(work: Row, row: int, place: int) -> None:
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        lengthening_m_s = work[row + V_BODY] - work[row + V_FOOT]
        work[place + SHORT] = guard_m(work) - length_m if guarded else -1.0
        if not latched:
            work[place], work[place + 1] = lengthening_m_s, work[row + V_BODY]
            work[place + 2] = -work[row + X_FOOT]
        elif work[PHASE] == COMPRESSION:
            work[place], work[place + 1] = (
                work[rest] - compression_m(work) - length_m,
                lengthening_m_s + tolerance_m_s(work),
            )
            work[place + 2] = 1.0
        else:
            work[place] = length_m - work[rest] + tolerance_m(work)
            work[place + 1], work[place + 2], work[place + SHORT] = 1.0, 1.0, -1.0

    return conditions


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
    """Compose `(work, place, turned)`: note which conditions hold; number `turned` (-1: none) has just changed."""

    @inner
    def note_conditions(work: Row, place: int, turned: int) -> None:
        conditions(work, NOW, place)
        for one in range(CONDITIONS):
            if one == turned:
                work[HOLDS + one] = 1.0 - work[HOLDS + one]
            else:
                work[HOLDS + one] = 1.0 if work[place + one] > 0.0 else 0.0

    return note_conditions
