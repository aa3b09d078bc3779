"""Electromechanical drag of the motors, K_tau K_v / R (d beta / dt)^2 (thesis Eq. 3.5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, Energy, ParameterIndex
from simulator.effects.shared import MOTOR_RESISTANCE, TORQUE_CONSTANT, VELOCITY_CONSTANT


def _functions(at: ParameterIndex) -> dict[str, Function]:
    resistance, constant, velocity = at("motor_resistance"), at("torque_constant"), at("velocity_constant")

    drag_at = at("drag_factor")

    @inner
    def prepare(p: NDArray[np.float64]) -> None:
        p[drag_at] = p[constant] * p[velocity] / p[resistance]

    @inner
    def drag_w(p: NDArray[np.float64], lever_m: float, v_r: float, force_n: float) -> float:
        joint_speed_rad_s = v_r / lever_m
        return p[drag_at] * joint_speed_rad_s * joint_speed_rad_s

    return {"prepare": prepare, "drag_w": drag_w}


EFFECT = Effect(
    name="drag",
    meaning="electromechanical drag of the motors, as if they were short-circuited: not for geared motors",
    source="thesis Eq. 3.5",
    parameters=(TORQUE_CONSTANT, MOTOR_RESISTANCE, VELOCITY_CONSTANT),
    energies=(Energy("drag", "electromechanical drag of the motors", 0, "motors' drag", singular=True),),
    derived=("drag_factor",),
    functions=_functions,
)
