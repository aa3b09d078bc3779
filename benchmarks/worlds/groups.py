"""Worlds of groups (foot, extension gain) whose savings are alike, or not, on days of their own or shared."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.worlds.world import Campaign, World, holds_truth
from data_schema.vocabulary import Undefined
from stats.days.decision import Contrast, contrast_by_day
from stats.days.overall import overall_savings

RUNS_OF_CONTROL, RUNS_TREATED = 3, 10
"""Runs of a group on each of its days."""
SD_PERCENT = 2.5
"""Standard deviation of a run's joules; days differ by three times as much."""


def _contrasts(rng: np.random.Generator, savings: Sequence[float], days: Sequence[range]) -> dict[str, Contrast]:
    """Draw the runs of groups that save so much percent, each on its days."""
    of_day = rng.normal(100.0, 3.0 * SD_PERCENT, 1 + max(day for each in days for day in each))

    def runs(share: float, each: range, count: int) -> tuple[np.ndarray, list[str]]:
        day = np.repeat(np.array(each), count)
        return share * of_day[day] + rng.normal(0.0, SD_PERCENT, day.size), [str(one) for one in day]

    found = {}
    for place, (saving, each) in enumerate(zip(savings, days, strict=True)):
        control, days_control = runs(1.0, each, RUNS_OF_CONTROL)
        treated, days_treated = runs(1.0 - saving / 100.0, each, RUNS_TREATED)
        found[str(place)] = contrast_by_day(treated, control, days_treated=days_treated, days_control=days_control)
    return found


def _campaigns(savings: Sequence[float], days: Sequence[range]) -> Callable[[np.random.Generator], Campaign]:
    def simulate(rng: np.random.Generator) -> Campaign:
        found = overall_savings(_contrasts(rng, savings, days))
        ci, p, apart = found.estimate.ci, found.estimate.p, found.heterogeneity
        warns = not isinstance(apart, Undefined) and apart.p <= 0.05
        return Campaign(holds_truth(ci, float(np.mean(savings))), isinstance(p, float) and p <= 0.05, warns)

    return simulate


def _world(name: str, savings: Sequence[float], days: Sequence[range]) -> World:
    truth = " and ".join(f"{each:g} %" for each in dict.fromkeys(savings))
    return World(name, truth, len(set(savings)) > 1, _campaigns(savings, days))


WORLDS = (
    _world("2 groups on 4 days of their own", (5.0, 5.0), (range(4), range(4, 8))),
    _world("4 groups on the same 4 days", (5.0,) * 4, (range(4),) * 4),
    _world("4 groups on 5 days, 2 shared with the next", (5.0,) * 4, [range(3 * at, 3 * at + 5) for at in range(4)]),
    _world("2 groups on 3 days, within days", (5.0, 5.0), (range(3), range(3, 6))),
    _world("2 groups on 6 days of their own", (5.0, 0.0), (range(6), range(6, 12))),
    _world("2 groups on the same 6 days", (5.0, 0.0), (range(6),) * 2),
)
