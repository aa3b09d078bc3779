"""Conditions over days: the mixed model, the exact test, and values taken together as if there were no days."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes.design import (
    DAYS,
    RUNS_A_DAY,
    Design,
    Floats,
    Groups,
    designs_over_days,
    mostly,
    partly,
)
from benchmarks.stats_evidence.sizes.method import LEVEL, Method, of_interval, of_one_interval, of_one_p, of_p
from benchmarks.stats_evidence.sizes.two_groups import test_of
from stats.compare.two_sample import ROUTES
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import BlockedByDay, ExactTest

CONDITIONS, DAY_SDS = 3, (0.0, 1.0)
HOLES = 0.4
"""Share of the values of all days but the first that is missing from a study with holes."""


SHARED, OWN = (
    designs_over_days(CONDITIONS, "shared", DAY_SDS),
    designs_over_days(CONDITIONS, "own", DAY_SDS, fewest_days=2),
)
UNEQUAL = tuple(replace(one, sd_ratio=2.0) for one in (*SHARED, *OWN) if one.day_sd == 1.0)
FULL = (*SHARED, *OWN, *UNEQUAL)
SEVERAL_DAYS = tuple(one for one in FULL if one.days != 1)
PAIRS = (*designs_over_days(2, "shared"), *designs_over_days(2, "own", fewest_days=2))
POOLED = (*designs_over_days(2, "own"), *designs_over_days(2, "shared"), *partly(2), *mostly(2))
UNEQUAL_PAIRS = tuple(replace(one, sd_ratio=2.0) for one in PAIRS)
UNEVEN_TIMES = (3, 10)
"""Values a day of two conditions that were measured unequally often."""
UNEVEN, UNEVEN_OWN = (
    tuple(
        Design(tuple(times * days for times in UNEVEN_TIMES), ratio, days, 1.0, layout)
        for ratio in ratios
        for days in DAYS[fewest_days - 1 :]
    )
    for layout, ratios, fewest_days in (("shared", (0.5, 1.0, 2.0), 1), ("own", (1.0,), 2))
)
NOT_ALL = (*partly(2, (3, 10)), *mostly(2, (3, 10)))
WITH_HOLES, MORE_WITH_HOLES = (
    tuple(Design((3 * days,) * 3, 1.0, days, day_sd, "holes") for days in each for day_sd in DAY_SDS)
    for each in ((2, 3, 6), (4, 5))
)
WITH_RUNS = tuple(Design((6 * days,) * 3, 1.0, days, 1.0, "runs") for days in DAYS)
UNLIKE_WITH_HOLES, UNLIKE_WITH_RUNS = (
    tuple(replace(one, sd_ratio=2.0) for one in designs if one.day_sd == 1.0)
    for designs in ((*WITH_HOLES, *MORE_WITH_HOLES), WITH_RUNS)
)
OF_MODEL_ONLY = tuple(
    one
    for one in (*WITH_HOLES, *MORE_WITH_HOLES, *WITH_RUNS, *UNLIKE_WITH_HOLES, *UNLIKE_WITH_RUNS)
    if one.day_sd == 1.0 and one.days in (2, 3, 6)
)
"""Values that are missing or lie in runs, on days that differ: the model has no formula there."""


@dataclass(frozen=True, slots=True)
class Squares:
    """Mean squares of designs whose days are all alike, each of shape (runs,)."""

    conditions: Floats
    days: Floats
    days_df: int
    rest: Floats
    rest_df: int

    @property
    def pooled(self) -> tuple[Floats, int]:
        """Days and rest in one."""
        df = self.days_df + self.rest_df
        return (self.days * self.days_df + self.rest * self.rest_df) / df, df


def squares_of(groups: Groups, design: Design) -> Squares:
    """Return the mean squares of each study."""
    k, days = len(groups), groups[0].shape[1]
    times = np.array([group.shape[2] for group in groups])  # a day; on days of their own all are alike
    of_condition = np.stack([group.mean(axis=(1, 2)) for group in groups])
    grand = times @ of_condition / times.sum()
    between = days * (times @ (of_condition - grand) ** 2) / (k - 1)
    left = [group - mean[:, None, None] for group, mean in zip(groups, of_condition, strict=True)]
    whole = sum((each**2).sum(axis=(1, 2)) for each in left)
    sums = np.stack([each.sum(axis=2) for each in left])  # conditions, runs, days
    if design.layout == "own":
        of_days = (sums**2).sum(axis=(0, 2)) / times[0]
        days_df = k * (days - 1)
    else:
        of_days = (sums.sum(axis=0) ** 2).sum(axis=1) / times.sum()
        days_df = days - 1
    rest_df = days * int(times.sum()) - k - days_df
    return Squares(between, of_days / max(days_df, 1), days_df, (whole - of_days) / rest_df, rest_df)


def _mixed(groups: Groups, design: Design) -> tuple[Floats, Floats, Floats]:
    """Return the mean square of conditions, and the one that REML compares it with and its degrees of freedom."""
    found = squares_of(groups, design)
    pooled, pooled_df = found.pooled
    day_counts = (found.days > found.rest) & (found.days_df > 0)
    below, df = (found.days, found.days_df) if design.layout == "own" else (found.rest, found.rest_df)
    return found.conditions, np.where(day_counts, below, pooled), np.where(day_counts, df, pooled_df)


def _size_many(groups: Groups, design: Design) -> Floats:
    between, below, df = _mixed(groups, design)
    return of_p(special.fdtrc(len(groups) - 1, df, between / below))


def _exact_many(groups: Groups, design: Design) -> Floats:
    if design.layout == "runs":  # the means of runs are what is compared
        groups = [group.reshape(*group.shape[:2], RUNS_A_DAY, -1).mean(axis=3) for group in groups]
    found = squares_of(groups, design)
    below, df = (found.days, found.days_df) if design.layout == "own" else (found.rest, found.rest_df)
    return of_p(special.fdtrc(len(groups) - 1, df, found.conditions / below))


def _contrast_many(groups: Groups, design: Design) -> Floats:
    _between, below, df = _mixed(groups, design)
    difference = groups[1].mean(axis=(1, 2)) - groups[0].mean(axis=(1, 2))
    half = -special.stdtrit(df, (1.0 - LEVEL) / 2.0) * np.sqrt(below * (1.0 / design.n[0] + 1.0 / design.n[1]))
    return of_interval(difference - half, difference + half, 0.0)


def _mean_many(groups: Groups, design: Design) -> Floats:
    found, k = squares_of(groups, design), len(groups)
    pooled, pooled_df = found.pooled
    day_counts = found.days > found.rest
    # The variance of a mean is a weighted sum of mean squares over n; on days of their own it is the days' alone.
    of_days, of_rest = (1.0, 0.0) if design.layout == "own" else (1.0 / k, 1.0 - 1.0 / k)
    parts = of_days * found.days, of_rest * found.rest
    joined = (parts[0] + parts[1]) ** 2 / (parts[0] ** 2 / found.days_df + parts[1] ** 2 / found.rest_df)
    df = np.where(day_counts, joined, pooled_df)
    squared = np.where(day_counts, parts[0] + parts[1], pooled) / design.n[0]
    mean = groups[0].mean(axis=(1, 2))
    half = -special.stdtrit(df, (1.0 - LEVEL) / 2.0) * np.sqrt(squared)
    return of_interval(mean - half, mean + half, 0.0)


def fit_of(groups: Groups, design: Design) -> BlockedByDay:
    """Return the library's own fit of one study."""
    k, days = len(groups), groups[0].shape[0]
    values = np.concatenate([group.ravel() for group in groups])
    condition = np.repeat(np.arange(k), design.n)
    day = np.concatenate([np.repeat(np.arange(days), times) for times in design.times])
    day = np.where(day < design.common_days, day, (day + 1) * k + condition)
    if design.layout == "runs":
        half = design.times[0] // RUNS_A_DAY
        return blocked_by_day(values, condition, day, condition * RUNS_A_DAY + np.arange(values.size) // half % 2)
    if design.layout == "holes":  # the same ones in every study of a design
        kept = np.ones((k, *groups[0].shape), dtype=bool)
        kept[:, 1:] = np.random.default_rng(design.n[0]).random(kept[:, 1:].shape) >= HOLES
        values, condition, day = (each[kept.ravel()] for each in (values, condition, day))
    return blocked_by_day(values, condition, day)


def _size_one(groups: Groups, design: Design) -> tuple[float, bool]:
    return of_one_p(fit_of(groups, design).mixed.p)


def _exact_one(groups: Groups, design: Design) -> tuple[float, bool]:
    exact = fit_of(groups, design).exact
    return of_one_p(exact.p if isinstance(exact, ExactTest) else exact)


def _contrast_one(groups: Groups, design: Design) -> tuple[float, float, bool]:
    return of_one_interval(fit_of(groups, design).mixed.contrasts[0].interval, 0.0)


def _mean_one(groups: Groups, design: Design) -> tuple[float, float, bool]:
    return of_one_interval(fit_of(groups, design).conditions[0].interval, 0.0)


def _alike(design: Design) -> bool:
    return design.normal_and_alike


def _one_day(design: Design) -> bool:
    return design.normal_and_alike and design.days == 1


METHODS = (
    Method("blocked_by_day", "size", FULL, _size_one, _size_many, _one_day, runs=10_000),
    Method("blocked_by_day", "size", WITH_HOLES, _size_one, runs=4000),
    Method("blocked_by_day", "size", WITH_RUNS, _size_one, runs=2000),
    Method("blocked_by_day_exact", "size", FULL, _exact_one, _exact_many, _alike, runs=10_000),
    Method("blocked_by_day_exact", "size", WITH_RUNS, _exact_one, _exact_many, _alike, runs=10_000),
    Method("blocked_by_day_ci", "coverage", FULL, _contrast_one, _contrast_many, _one_day, runs=10_000),
    Method("blocked_by_day", "size", PAIRS, _size_one, _size_many, _one_day, runs=10_000),
    Method("blocked_by_day", "size", NOT_ALL, _size_one, runs=2000),
    Method("blocked_by_day_exact", "size", PAIRS, _exact_one, _exact_many, _alike, runs=10_000),
    Method("blocked_by_day_ci", "coverage", PAIRS, _contrast_one, _contrast_many, _one_day, runs=10_000),
    Method("blocked_by_day_ci", "coverage", NOT_ALL, _contrast_one, runs=2000),
    Method("blocked_by_day", "size", MORE_WITH_HOLES, _size_one, runs=2000),
    *(
        method
        for designs in (UNEQUAL_PAIRS, UNEVEN)
        for method in (
            Method("blocked_by_day", "size", designs, _size_one, _size_many, _one_day, runs=10_000),
            Method("blocked_by_day_exact", "size", designs, _exact_one, _exact_many, _alike, runs=10_000),
            Method("blocked_by_day_ci", "coverage", designs, _contrast_one, _contrast_many, _one_day, runs=10_000),
        )
    ),
    Method("blocked_by_day", "size", UNEVEN_OWN, _size_one, runs=2000),
    Method("blocked_by_day_mean_ci", "coverage", SEVERAL_DAYS, _mean_one, _mean_many, runs=10_000),
    Method("blocked_by_day", "size", (*UNLIKE_WITH_HOLES, *UNLIKE_WITH_RUNS), _size_one, runs=1000),
    Method("blocked_by_day_ci", "coverage", OF_MODEL_ONLY, _contrast_one, runs=1000),
    Method("blocked_by_day_mean_ci", "coverage", (*OF_MODEL_ONLY, *NOT_ALL[::2]), _mean_one, runs=1000),
    Method("blocked_by_day_exact", "size", UNLIKE_WITH_RUNS, _exact_one, _exact_many, _alike, runs=10_000),
    *(test_of(route, POOLED) for route in ROUTES),
)
