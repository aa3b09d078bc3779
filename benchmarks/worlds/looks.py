"""Looks at growing data: reports that were not planned, looks that were, and a single report.

Each look is at more days of five runs of the control and five of the treatment, which differ from day to day by half of
what runs differ by. An interval covers where those of all looks do.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.worlds.world import Campaign, World
from labbook.analysis.comparison.deciding import decide_by_contrast
from labbook.analysis.preregistration.looks import look_at
from stats.days.decision import contrast_by_day

RUNS, DAY_SD, RUN_SD, MEAN = 5, 0.05, 0.10, 1.0


def _campaign(rng: np.random.Generator, *, saving: float, days: tuple[int, ...], planned: int) -> Campaign:
    labels = np.repeat(np.arange(days[-1]), RUNS)
    of_day = rng.normal(0.0, DAY_SD, days[-1])[labels]
    control = MEAN + of_day + rng.normal(0.0, RUN_SD, labels.size)
    treated = (1.0 - saving) * MEAN + of_day + rng.normal(0.0, RUN_SD, labels.size)
    covers, finds, unplanned, sizes = True, False, False, list[int]()
    for day in days:
        n = day * RUNS
        sizes.append(2 * n)
        look = look_at(sizes, planned=planned, runs_planned=2 * days[-1] * RUNS)
        contrast = contrast_by_day(treated[:n], control[:n], days_treated=labels[:n], days_control=labels[:n])
        found = decide_by_contrast(contrast, "J", look.level, with_savings=True, shares_error=False)
        saved = found.savings
        if saved is not None and isinstance(saved.ci_low, float) and isinstance(saved.ci_high, float):
            covers = covers and saved.ci_low <= 100.0 * saving <= saved.ci_high
        finds = finds or found.rejected is True
        unplanned = look.unplanned
    return Campaign(covers, finds, unplanned)


_LOOKS = (
    ("ten looks, none planned", True, tuple(range(1, 11)), 1),
    ("five planned looks", False, (2, 4, 6, 8, 10), 5),
    ("a single look", False, (10,), 1),
)
WORLDS = tuple(
    World(name, f"{100 * saving:g} %", needed, partial(_campaign, saving=saving, days=days, planned=planned))
    for saving in (0.0, 0.05)
    for name, needed, days, planned in _LOOKS
)
