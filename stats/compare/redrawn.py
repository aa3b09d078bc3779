"""Differences of redrawn values, and the intervals that they give: studentised, BCa, percentiles.

A redraw of values x* in each day and group changes the difference by the weighted sum of its means' changes. Efron and
Tibshirani 1993, "An introduction to the bootstrap": the bootstrap-t interval of 12.5, BCa of 14.3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from data_schema.vocabulary import Undefined
from stats.days.two_by_day import Cell

Floats = NDArray[np.float64]
Interval = tuple[float, float]

BATCH_VALUES = 2_000_000
"""Values drawn at a time, so that memory stays small."""


@dataclass(frozen=True, slots=True)
class Redrawn:
    """What redraws change the difference by, shape (resamples,); intervals are about the difference found."""

    cells: Sequence[Cell]
    changes: Floats
    """In ascending order."""
    ratios: Floats
    """Changes over the standard error of their own redraw, in ascending order; infinite where it has no scatter."""

    def studentised(self, tail: float) -> Interval | Undefined:
        """Return the bootstrap-t interval that leaves out `tail` at each end."""
        single = next((cell for cell in self.cells if cell.values.size < 2), None)
        if single is not None:
            return Undefined(f"a day holds a single value of group {single.name}, and its scatter needs at least 2")
        place = math.floor((self.ratios.size + 1) * tail)
        if place < 1:
            return Undefined(f"{self.ratios.size} redraws are too few for a tail of {tail:g}")
        low, high = float(self.ratios[place - 1]), float(self.ratios[-place])
        if math.isinf(low) or math.isinf(high):
            return Undefined("there are so few values that too many redraws repeat one and have no scatter")
        se = math.sqrt(math.fsum(_squared_error(cell) for cell in self.cells))
        return -high * se, -low * se

    def percentiles(self, tail: float) -> Interval:
        """Return the plain percentiles of the changes."""
        low, high = np.quantile(self.changes, [tail, 1.0 - tail])
        return float(low), float(high)

    def bca(self, tail: float) -> Interval | Undefined:
        """Return the bias-corrected and accelerated percentiles of the changes."""
        changes = self.changes
        below = (np.count_nonzero(changes < 0.0) + np.count_nonzero(changes <= 0.0)) / (2.0 * changes.size)
        if not 0.0 < below < 1.0:
            return Undefined("all draws lie on one side of the difference")
        bias, acceleration = float(special.ndtri(below)), _acceleration(self.cells)
        ends = []
        for z in (float(special.ndtri(tail)), -float(special.ndtri(tail))):
            moved = bias + (bias + z) / (1.0 - acceleration * (bias + z))
            ends.append(float(np.quantile(changes, float(special.ndtr(moved)))))
        return ends[0], ends[1]


def redraw(cells: Sequence[Cell], resamples: int, seed: int) -> Redrawn:
    """Redraw each cell's values `resamples` times; some cell scatters."""
    rng = np.random.default_rng(seed)
    changes, variances = np.zeros(resamples), np.zeros(resamples)
    for cell in cells:
        n = cell.values.size
        batch = max(1, BATCH_VALUES // n)
        for start in range(0, resamples, batch):
            drawn = cell.values[rng.integers(0, n, (min(batch, resamples - start), n))]
            about = slice(start, start + batch)
            means = drawn.mean(axis=1)
            changes[about] += cell.weight * means
            if n > 1:
                squares = np.square(drawn - means[:, None]).sum(axis=1)
                squares[drawn.min(axis=1) == drawn.max(axis=1)] = 0.0
                variances[about] += cell.weight**2 / (n * (n - 1)) * squares
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(changes == 0.0, 0.0, changes / np.sqrt(variances))
    return Redrawn(cells, np.sort(changes), np.sort(ratios))


def _squared_error(cell: Cell) -> float:
    n = cell.values.size
    return cell.weight**2 * float(cell.values @ cell.values) / (n * (n - 1))


def _acceleration(cells: Sequence[Cell]) -> float:
    """Return a of BCa for several samples: cubes of the values' influence on the difference over their squares."""
    influence = np.concatenate([cell.weight / cell.values.size * cell.values for cell in cells])
    influence = influence / np.max(np.abs(influence))
    return float(np.sum(influence**3) / (6.0 * np.sum(influence**2) ** 1.5))
