"""Control limits of runs (Shewhart 1931): each run's value beside those of the runs of its condition before it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from data_schema.queries.runs import RunRow

LIMIT_SDS = 3.0
"""Control limits lie three standard deviations from the mean of the condition's earlier runs (Shewhart 1931)."""
LIMITS_FROM_RUNS = 5
"""Fewer earlier runs than this give no limits: their standard deviation is too uncertain."""


class ControlLimits(NamedTuple):
    """Limits from `n` earlier runs: of their mean, and the sum of squared deviations from it."""

    n: int = 0
    mean: float = 0.0
    squares: float = 0.0

    @property
    def ends(self) -> tuple[float, float] | None:
        """The limits, from 0 or above: a jump takes energy. None where runs are too few or both ends are below 0."""
        if self.n < LIMITS_FROM_RUNS:
            return None
        width = LIMIT_SDS * math.sqrt(self.squares / (self.n - 1))
        return (max(self.mean - width, 0.0), self.mean + width) if self.mean + width > 0.0 else None

    def outside(self, value: float) -> bool:
        """Return whether a run of this value is out of the limits, as far as there are any."""
        ends = self.ends
        return ends is not None and not ends[0] <= value <= ends[1]


def limits_of(runs: Sequence[RunRow], values: Mapping[str, float]) -> dict[str, ControlLimits]:
    """Return the limits of each run that has a value, by uid, from those of its condition that were made before it.

    Runs at one place of a day are not before each other. Mean and squares are updated from run to run: a book may have
    ten thousand.
    """
    by_condition: dict[str, list[RunRow]] = {}
    for run in runs:
        if run.uid in values:
            by_condition.setdefault(run.condition_key, []).append(run)
    found = {}
    for several in by_condition.values():
        n, mean, squares, last, limits = 0, 0.0, 0.0, None, ControlLimits()
        for run in sorted(several, key=_place):
            if (place := _place(run)) != last:
                last, limits = place, ControlLimits(n, mean, squares)
            found[run.uid] = limits
            n, off = n + 1, values[run.uid] - mean
            mean += off / n
            squares += off * (values[run.uid] - mean)
    return found


def runs_outside(runs: Sequence[RunRow], values: Mapping[str, float]) -> list[RunRow]:
    """Return the runs whose value is out of its limits."""
    limits = limits_of(runs, values)
    return [run for run in runs if run.uid in limits and limits[run.uid].outside(values[run.uid])]


def _place(run: RunRow) -> tuple[str, int]:
    return run.day, run.position_in_day
