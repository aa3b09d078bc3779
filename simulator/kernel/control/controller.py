"""The leg's controller: when it changes its phase (thesis 4.2.5, 5.1.1, and the published rule of ch. 3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import (
    COMPRESSION,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)

Row = NDArray[np.float64]


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
