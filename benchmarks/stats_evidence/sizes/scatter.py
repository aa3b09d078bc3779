"""Tests of equal variances, on normal values and on others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import (
    DISTRIBUTIONS,
    EVERY_N,
    FURTHER_PAIRS,
    FURTHER_TRIPLES,
    UNEQUAL_N,
    Design,
    Floats,
    Groups,
    by_layout,
)
from benchmarks.stats_evidence.sizes.method import LEVEL, Method, of_interval, of_one_interval, of_one_p, of_p
from stats.groups.variances import VarianceTest, bartlett, brown_forsythe, f_test, levene

TWO = (
    *(Design(n, distribution=name) for name in DISTRIBUTIONS for n in (*((n, n) for n in (*EVERY_N, 30)), *UNEQUAL_N)),
    *map(Design, (*FURTHER_PAIRS[1:], (6, 6))),
)
THREE = (
    *(Design((n,) * 3, distribution=name) for name in DISTRIBUTIONS for n in EVERY_N),
    *map(Design, (*FURTHER_TRIPLES, (6, 6, 6))),
)
"""Of two values each a middle tells no distances."""
OF_TWO = (*TWO, *by_layout(2))
OF_ANY = (*TWO, *THREE, *by_layout(2), *by_layout(3))


def _exact(design: Design) -> bool:
    """Say that scatter is what F takes it for: normal, alike, and of one day or none, which has no part in it."""
    return design.normal_and_alike and design.days in (None, 1)


def _bartlett(groups: Groups, _design: Design) -> Floats:
    groups = list(map(arrays.flat, groups))
    dfs = np.array([group.shape[1] - 1 for group in groups])[:, None]
    variances = np.stack([arrays.variance(group) for group in groups])
    pooled = (dfs * variances).sum(axis=0) / dfs.sum()
    ratio = variances / pooled
    statistic = (dfs * (ratio - 1.0 - np.log(ratio))).sum(axis=0)
    correction = 1.0 + ((1.0 / dfs).sum() - 1.0 / dfs.sum()) / (3.0 * (len(groups) - 1))
    return of_p(special.chdtrc(len(groups) - 1, statistic / correction))


def _of_distances(middle: Callable[..., Floats]) -> Callable[[Groups, Design], Floats]:
    def many(groups: Groups, _design: Design) -> Floats:
        distances = [np.abs(group - middle(group, axis=1, keepdims=True)) for group in map(arrays.flat, groups)]
        f, between, within = arrays.anova_f(distances)
        return of_p(special.fdtrc(between, within, f))

    return many


def _library(test: Callable[..., VarianceTest]) -> Callable[[Groups, Design], tuple[float, bool]]:
    return lambda groups, _design: of_one_p(test({str(place): group.ravel() for place, group in enumerate(groups)}).p)


def _f_ratio(groups: Groups, _design: Design) -> Floats:
    a, b = map(arrays.flat, groups)
    ratio = arrays.variance(a) / arrays.variance(b)
    low, high = (special.fdtri(b.shape[1] - 1, a.shape[1] - 1, tail) for tail in ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
    return of_interval(ratio * low, ratio * high, 1.0)


def _f_ratio_one(groups: Groups, _design: Design) -> tuple[float, float, bool]:
    return of_one_interval(f_test(groups[0].ravel(), groups[1].ravel()).ratio_ci, 1.0)


METHODS = (
    Method(
        "f_test",
        "size",
        OF_TWO,
        lambda groups, _: of_one_p(f_test(groups[0].ravel(), groups[1].ravel()).p),
        lambda groups, _: of_p(arrays.f_p(*map(arrays.flat, groups))),
        _exact,
    ),
    Method("bartlett", "size", OF_ANY, _library(bartlett), _bartlett),
    Method("levene", "size", OF_ANY, _library(levene), _of_distances(np.mean)),
    Method("brown_forsythe", "size", OF_ANY, _library(brown_forsythe), _of_distances(np.median)),
    Method("f_ratio_ci", "coverage", OF_TWO, _f_ratio_one, _f_ratio, _exact),
)
