"""Values as at the mean position of their day: a drift over the day is taken off.

Source: docs/statistics.md, "Order within the day".
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from labbook.scripts.templates.runs import Pair, Run, Runs, Source, of_conditions, values_of

GROUPS: Mapping[str, Pair] = {}
"""By group, the conditions of its control and of its treatment."""


def indicators(labels: Sequence[str]) -> NDArray[np.float64]:
    """Return a column of 0 and 1 for each different label."""
    return np.array([[float(label == each) for each in dict.fromkeys(labels)] for label in labels])


def at_mean_position(runs: Runs) -> list[Run]:
    """Take slope * (position - mean position of the group's day) off every value.

    The slope is that of least squares of value on position, with a constant for every side of a group's day and for
    every condition. Its error is one that all values share.
    """
    placed = [
        (run, f"{group} {run.row['day']}", side)
        for group, pair in GROUPS.items()
        for side in (0, 1)
        for run in of_conditions(runs, pair[side])
    ]
    found, days = [run for run, _day, _side in placed], [day for _run, day, _side in placed]
    position, value = np.array([float(run.row["position_in_day"]) for run in found]), np.array(values_of(found))
    sides = indicators([f"{day} {side}" for _run, day, side in placed])
    constants = np.hstack([sides, indicators([run.row["condition"] for run in found])])
    free = position - constants @ np.linalg.lstsq(constants, position)[0]
    squares = float(free @ free)
    slope = float(free @ value) / squares
    left = value - slope * position
    left = left - constants @ np.linalg.lstsq(constants, left)[0]
    df = len(found) - int(np.linalg.matrix_rank(constants)) - 1.0
    slope_se = math.sqrt(float(left @ left) / df / squares)
    of_day = indicators(days)
    away = position - of_day @ (of_day.T @ position / of_day.sum(axis=0))
    return [
        Run(run.row, run.value - slope * off, {**run.shared, Source("position", "slope", df): -slope_se * off})
        for run, off in zip(found, away.tolist(), strict=True)
    ]
