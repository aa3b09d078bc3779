"""A leg that the motors drive straight, by pinion or belt through a gear, in place of the five-bar's links."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    radius, ratio, arm = at("pinion_radius"), at("gear_ratio"), at("pinion_lever")

    @inner
    def prepare(p: NDArray[np.float64]) -> None:
        p[arm] = p[radius] / p[ratio]

    return {"prepare": prepare, "lever_m": inner(lambda p, leg_length_m: p[arm])}


EFFECT = Effect(
    name="linear_leg",
    meaning="a leg that two motors drive straight, by a pinion through a gear; off, the five-bar of the thesis",
    source="torque of both motors = force x pinion_radius / gear_ratio",
    lacks="inertia J of a motor's rotor, as a mass of 2 J (gear_ratio / pinion_radius)^2 between body and foot; "
    "friction and efficiency of the gear",
    parameters=(
        Parameter(
            "pinion_radius",
            "drive",
            "m",
            "radius of pinion or pulley",
            1e-3,
            0.5,
            0.02,
            "as large as a motor's shaft asks",
        ),
        Parameter(
            "gear_ratio", "drive", "1", "turns of a motor for one of the pinion", 0.1, 1000.0, 1.0, "direct drive"
        ),
    ),
    derived=("pinion_lever",),
    functions=_functions,
)
