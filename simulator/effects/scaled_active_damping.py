"""Active damping scaled with the extension gain (thesis 4.3): its gain is a share of the extension spring's.

Gains become physical units by the fits of thesis 5.1.1: k = 2.56 g + 67.36 N/m; the damping's slope 3.32 serves b_ad.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.gains import DAMPING_PER_GAIN, STIFFNESS_AT_ZERO_GAIN_N_M, STIFFNESS_PER_GAIN_N_M
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    stiffness, share = at("k_extension"), at("ad_share")

    @inner
    def active_damping_kg_m(p: NDArray[np.float64]) -> float:
        gain = (p[stiffness] - STIFFNESS_AT_ZERO_GAIN_N_M) / STIFFNESS_PER_GAIN_N_M
        return DAMPING_PER_GAIN * p[share] * max(gain, 0.0)

    return {"active_damping_kg_m": active_damping_kg_m}


EFFECT = Effect(
    name="scaled_active_damping",
    meaning="active damping whose gain is a share of the extension gain",
    source="thesis 4.3, 5.1.1",
    parameters=(
        Parameter("ad_share", "controller", "1", "active-damping gain as a share of the extension gain", 0.0, 10.0),
    ),
    excludes={
        "active_damping": "active damping is constant or scaled with the gain: leave out one of "
        "active_damping and scaled_active_damping"
    },
    functions=_functions,
)
