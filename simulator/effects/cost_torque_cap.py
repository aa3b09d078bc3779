"""The cost counts at most the stall torque of both motors, though the dynamics know no cap (set 1, thesis 3.2.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.effects.shared import STALL_TORQUE


def _functions(at: ParameterIndex) -> dict[str, Function]:
    torque = at("stall_torque")

    @inner
    def cost_cap_n(p: NDArray[np.float64], lever_m: float) -> float:
        return 2.0 * p[torque] / lever_m

    @inner
    def cost_force_n(p: NDArray[np.float64], lever_m: float, commanded_n: float, applied_n: float) -> float:
        most = cost_cap_n(p, lever_m)
        return min(max(applied_n, -most), most)

    return {"cost_force_n": cost_force_n, "cost_cap_n": cost_cap_n}


EFFECT = Effect(
    name="cost_torque_cap",
    meaning="the cost counts no more than the stall torque",
    source="thesis 3.2.1",
    parameters=(STALL_TORQUE,),
    excludes={
        "cost_of_commanded_force": "the cost counts one force: leave out cost_of_commanded_force or cost_torque_cap"
    },
    functions=_functions,
)
