"""Campaigns of the studies beside the jumps: force plate, emulator, flasks of grains, oscillating legs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.stats_evidence.worlds.world import Campaign, World
from data_schema.vocabulary import Undefined
from stats.lines.regression import slope_through_origin

Interval = tuple[float, float] | Undefined


def _covers(ci: Interval, truth: float) -> bool | None:
    return None if isinstance(ci, Undefined) else ci[0] <= truth <= ci[1]


_SLOPE, _JOULES = 1.06, (45.0, 57.0, 63.4, 67.1)


def _plate(runs_of_days: Sequence[int], of_day: float) -> World:
    """Runs of four gains in turn; days and runs scatter by these shares."""

    def simulate(chance: np.random.Generator) -> Campaign:
        days = np.repeat(np.arange(len(runs_of_days)), runs_of_days)
        measured_j = np.resize(_JOULES, days.size)
        shares = 1.0 + chance.normal(0.0, of_day, len(runs_of_days))[days] + chance.normal(0.0, 0.01, days.size)
        found = slope_through_origin(measured_j, _SLOPE * measured_j * shares, days.tolist())
        covers = _covers(found.ci, _SLOPE)
        return Campaign(covers, finds=_covers(found.ci, 1.0) is False, warns=False)

    name = f"force plate, days of {', '.join(map(str, runs_of_days))} runs, days scatter by {100.0 * of_day:g} %"
    return World(name, f"slope {_SLOPE:g}", warning_needed=False, simulate=simulate)


WORLDS = (
    _plate((4, 4, 4, 4), 0.01),
    _plate((8, 4, 2, 2), 0.0),
    _plate((8, 4, 2, 2), 0.01),
    _plate((12, 1, 1, 1), 0.01),
    _plate((8, 4, 4, 2, 2, 1), 0.02),
)
