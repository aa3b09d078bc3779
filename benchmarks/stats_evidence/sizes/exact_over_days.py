"""The exact test's interval of a difference over days, and the test that depends on the order of the conditions."""

from __future__ import annotations

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes.design import RUNS_A_DAY, Design, Floats, Groups
from benchmarks.stats_evidence.sizes.method import LEVEL, Method, of_interval, of_one_interval, of_one_p, there
from benchmarks.stats_evidence.sizes.over_days import (
    FULL,
    OF_MODEL_ONLY,
    PAIRS,
    UNEQUAL_PAIRS,
    UNEVEN,
    UNLIKE_WITH_RUNS,
    WITH_RUNS,
    fit_of,
    squares_of,
)

DESIGNS = (*FULL, *PAIRS, *UNEQUAL_PAIRS, *UNEVEN, *WITH_RUNS, *UNLIKE_WITH_RUNS)
HOLES = tuple(one for one in OF_MODEL_ONLY if one.layout == "holes")


def _one(groups: Groups, design: Design) -> tuple[float, float, bool]:
    return of_one_interval(there(fit_of(groups, design).exact).contrasts[0].interval, 0.0)


def _many(groups: Groups, design: Design) -> Floats:
    if design.layout == "runs":  # the means of runs are what is compared
        groups = [group.reshape(*group.shape[:2], RUNS_A_DAY, -1).mean(axis=3) for group in groups]
    found = squares_of(groups, design)
    below, df = (found.days, found.days_df) if design.layout == "own" else (found.rest, found.rest_df)
    sizes = [group.shape[1] * group.shape[2] for group in groups]
    difference = groups[1].mean(axis=(1, 2)) - groups[0].mean(axis=(1, 2))
    half = -special.stdtrit(df, (1.0 - LEVEL) / 2.0) * np.sqrt(below * (1.0 / sizes[0] + 1.0 / sizes[1]))
    return of_interval(difference - half, difference + half, 0.0)


def _alike(design: Design) -> bool:
    return design.normal_and_alike


METHODS = (
    Method("blocked_by_day_exact_ci", "coverage", DESIGNS, _one, _many, _alike, runs=10_000),
    Method(
        "blocked_by_day_lmertest",
        "size",
        HOLES,
        lambda groups, design: of_one_p(fit_of(groups, design).mixed.lmertest_p),
        runs=1000,
    ),
)
