"""Drag of the air on the body, quadratic in its speed: F = -1/2 rho c_d A v |v|."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, inner
from simulator.effects.effect import MODES, BodyForce, Effect, Energy, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    density, area = at("air_density"), at("drag_area")

    @inner
    def body_force_n(p: NDArray[np.float64], height_m: float, velocity_m_s: float) -> float:
        return -0.5 * p[density] * p[area] * velocity_m_s * abs(velocity_m_s)

    return {"body_force_n": body_force_n}


EFFECT = Effect(
    name="air_drag",
    meaning="drag of the air on the body, quadratic in its speed",
    source="law of quadratic drag, F = -1/2 rho c_d A v |v|",
    parameters=(
        Parameter("air_density", "robot", "kg/m^3", "density of the air", 0.0, 10.0, 1.2, "dry air at 20 °C"),
        Parameter(
            "drag_area",
            "robot",
            "m^2",
            "drag coefficient of the body times its frontal area",
            0.0,
            1.0,
            0.01,
            "nobody measured it; a body of 0.1 m by 0.1 m with a coefficient of 1",
        ),
    ),
    body_force=BodyForce(
        loss=Energy("air_drag_loss", "energy lost to the air's drag on the body", -1, "lost to the air"),
        modes=MODES,
        breaks_closed_form=MODES,
    ),
    functions=_functions,
)
