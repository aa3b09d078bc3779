"""Conditions simulated many times over, with parameters that have one value in all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.outcomes import Outcome
from simulator.jump import parameter_row
from simulator.kernel.build import kernel_for
from simulator.scene import Scene
from simulator.sweep.chunks import Recipe, recipe_of_rows
from simulator.sweep.compute import simulate_on_all_cores
from simulator.sweep.outputs import PLACE

Floats = NDArray[np.float64]

_OUTPUT = {Outcome.JOULES: "cost_J", Outcome.APEX: "apex_height_m"}


@dataclass(frozen=True, slots=True, eq=False)
class ManyScenes:
    """Scenes with the same effects as rows of parameters, and where in a row those stand that are changed."""

    recipe: Recipe
    rows: Floats
    places: tuple[int, ...]

    def means(self, values: Floats, *, times: bool = False) -> Mapping[Outcome, Floats]:
        """Simulate every scene with each of m sets of values, shape (m, parameters), or with its own times these.

        Returns by outcome the means over a scene's jumps, shape (m, scenes); NaN where the robot does not jump.
        """
        n, m = len(self.rows), len(values)
        table, given = np.tile(self.rows, (m, 1)), np.repeat(values, n, axis=0)
        table[:, self.places] = given * table[:, self.places] if times else given
        block = simulate_on_all_cores(self.recipe, table).reshape(m, n, self.recipe.jumps, -1)
        found = {outcome: block[..., PLACE[name]].mean(axis=2) for outcome, name in _OUTPUT.items()}
        jumps = np.isfinite(found[Outcome.APEX])
        return {outcome: np.where(jumps, means, np.nan) for outcome, means in found.items()}


def many_scenes(scenes: Sequence[Scene], names: Sequence[str], accuracy: float) -> ManyScenes:
    """Prepare scenes with the same effects, and compile their kernel; `names` are the parameters to change."""
    kernel = kernel_for(scenes[0].effects)
    columns = [parameter.name for parameter in kernel.composition.parameters]
    return ManyScenes(
        recipe_of_rows(scenes[0], accuracy),
        np.array([parameter_row(kernel, scene) for scene in scenes]),
        tuple(columns.index(name) for name in names),
    )
