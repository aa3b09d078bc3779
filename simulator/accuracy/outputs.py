"""The four numbers of a jump that methods are compared by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import COLUMN, COST_PARTS
from simulator.scene import Scene

NAMES = ("max_depth_m", "liftoff_time_s", "apex_height_m", "cost_J")
"""Deepest point of the foot, time of lift-off since touchdown, apex of the body, cost."""


@dataclass(frozen=True, slots=True)
class Outputs:
    """A jump's outcome and its four numbers; None: not reached. The cost is the motors', without passive draw."""

    outcome: str
    values: Mapping[str, float | None]


def outputs_of(scene: Scene, row: NDArray[np.float64]) -> Outputs:
    """Read the outputs from a row of the kernel, shape (columns,)."""
    span = "jump" if "cost_of_whole_jump" in scene.effects else "stance"
    values = {name: _number(float(row[COLUMN[name]])) for name in NAMES[:-1]}
    cost_j = sum(float(row[COLUMN[f"{span}_{part}_J"]]) for part in COST_PARTS)
    return Outputs(OUTCOMES[int(row[COLUMN["outcome"]])], {**values, NAMES[-1]: _number(cost_j)})


def relative_errors(found: Outputs, truth: Mapping[str, float | None]) -> dict[str, float | None]:
    """Relative error of each output: None where there is no true number or it is 0, infinite where `found` lacks it."""
    errors: dict[str, float | None] = {}
    for name in NAMES:
        true, value = truth[name], found.values[name]
        if true is None or true == 0.0:
            errors[name] = None
        else:
            errors[name] = math.inf if value is None else abs(value / true - 1.0)
    return errors


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
