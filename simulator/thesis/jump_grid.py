"""Single jumps over grids of parameters, for the figures that vary something."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simulator.jump import ill_conditioned, limits_for, parameter_row
from simulator.kernel.build import kernel_for
from simulator.kernel.layout import APEX, TOUCHDOWN
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.scene import Scene

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Jumps:
    """One jump for each point of a grid; all arrays have the grid's shape, joules are those of the stance (Eq. 3.5).

    Where `jumped` is false the jump did not reach an apex, and every number of it is NaN: it is drawn as a gap.
    `ill_conditioned` jumps hang on a knife's edge of the sampled controller, or grow errors that much.
    """

    jumped: BoolArray
    ill_conditioned: BoolArray
    heat_j: FloatArray
    mechanical_j: FloatArray
    drag_j: FloatArray
    apex_height_m: FloatArray

    @property
    def cost_j(self) -> FloatArray:
        """Energetic cost of the jump, J (Eq. 3.5)."""
        return self.heat_j + self.mechanical_j + self.drag_j

    @property
    def efficiency(self) -> FloatArray:
        """Share of the cost that becomes mechanical energy."""
        return self.mechanical_j / self.cost_j


def jumps_over(scene: Scene, values: Mapping[str, ArrayLike], accuracy: float) -> Jumps:
    """Simulate a jump of the scene for each point of a grid: the parameters' arrays, broadcast against each other.

    Raises `UsageError` for a parameter that the scene does not read, or a value outside its box.
    """
    for name, given in values.items():
        for extreme in (np.min(given), np.max(given)):
            scene.changed({name: float(extreme)})
    grid = np.broadcast_arrays(*(np.asarray(given, np.float64) for given in values.values()))
    kernel = kernel_for(scene.effects)
    names = [parameter.name for parameter in kernel.composition.parameters]
    table = np.tile(parameter_row(kernel, scene), (grid[0].size, 1))
    for name, column in zip(values, grid, strict=True):
        table[:, names.index(name)] = column.ravel()
    rows = np.zeros((len(table), 1, len(COLUMNS)))
    nothing = np.zeros((0, 4)), np.zeros((0, 4 + 4 * kernel.composition.state_size))
    kernel.batch(table, limits_for(accuracy), rows, np.zeros(len(table), np.int64), *nothing)
    return _jumps(rows[:, 0].reshape(*grid[0].shape, len(COLUMNS)), accuracy)


def _jumps(rows: FloatArray, accuracy: float) -> Jumps:
    jumped = np.isin(rows[..., COLUMN["outcome"]], (APEX, TOUCHDOWN))

    def column(name: str) -> FloatArray:
        return np.where(jumped, rows[..., COLUMN[name]], np.nan)

    return Jumps(
        jumped=jumped,
        ill_conditioned=ill_conditioned(
            rows[..., COLUMN["decision_margin"]], rows[..., COLUMN["error_growth"]], accuracy
        ),
        heat_j=column("stance_heat_J"),
        mechanical_j=column("stance_mechanical_J"),
        drag_j=column("stance_drag_J"),
        apex_height_m=column("apex_height_m"),
    )
