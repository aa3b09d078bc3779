"""Heat in the windings of both motors, R I^2 / 2 for the current I of both together (thesis Eq. 3.5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, Energy, ParameterIndex
from simulator.effects.shared import MOTOR_RESISTANCE, TORQUE_CONSTANT


def _functions(at: ParameterIndex) -> dict[str, Function]:
    resistance, constant = at("motor_resistance"), at("torque_constant")

    heat_at = at("heat_factor")

    @inner
    def prepare(p: NDArray[np.float64]) -> None:
        p[heat_at] = 0.5 * p[resistance] / (p[constant] * p[constant])

    @inner
    def heat_w(p: NDArray[np.float64], lever_m: float, v_r: float, force_n: float) -> float:
        torque_n_m = force_n * lever_m
        return p[heat_at] * torque_n_m * torque_n_m

    return {"prepare": prepare, "heat_w": heat_w}


EFFECT = Effect(
    name="motor_heat",
    meaning="heat in the windings of both motors",
    source="R I^2 / 2 for the current I of two motors that share the torque, thesis Eq. 3.5",
    parameters=(TORQUE_CONSTANT, MOTOR_RESISTANCE),
    energies=(Energy("heat", "heat in the motors' windings", 0, "heat in the motors"),),
    derived=("heat_factor",),
    functions=_functions,
)
