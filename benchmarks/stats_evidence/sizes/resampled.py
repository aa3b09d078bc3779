"""Shuffled labels and redrawn values."""

from __future__ import annotations

import math
import zlib
from functools import lru_cache
from itertools import combinations

import numpy as np

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import (
    EVERY_N,
    UNEQUAL_N,
    Design,
    Floats,
    Groups,
    designs_over_days,
    equal_groups,
)
from benchmarks.stats_evidence.sizes.method import Method, of_one_interval, of_one_p, of_p, studies
from stats.compare.resampling import Bootstrap, bootstrap_difference, permutation_test

QUICK, MOST_ARRANGEMENTS = 1000, 200_000
"""Arrangements of which many studies, and any, are counted over arrays."""
AT_A_TIME = 20
SHUFFLES, REDRAWS = 999, 2000
"""Of one study; fewer than the library's defaults, which changes p and ends a little and their errors hardly."""
DESIGNS = (
    *(Design((n, n), ratio) for n in EVERY_N for ratio in (1.0, 2.0, 3.0)),
    *(Design(n, ratio) for n in UNEQUAL_N for ratio in (1.0, 2.0)),
)
BY_DAY = tuple(
    Design((times * days,) * 2, 1.0, days, 1.0, "shared") for times, days in ((3, 2), (3, 3), (3, 6), (5, 2), (10, 2))
)
ONE_DAY = tuple(Design((times, times), 1.0, 1, 1.0, "shared") for times in (3, 5, 10))
MORE_BY_DAY = tuple(
    design for design in designs_over_days(2, "shared", times_a_day=(3, 5, 10), fewest_days=2) if design not in BY_DAY
)
UNLIKE_BY_DAY = tuple(
    Design(tuple(times * days for times in each), ratio, days, 1.0, "shared")
    for each, ratio in (((5, 5), 2.0), ((3, 10), 0.5), ((3, 10), 2.0))
    for days in (1, 2, 3, 6)
)
MANY_BY_DAY = tuple(Design((25 * days,) * 2, 1.0, days, 1.0, "shared") for days in (2, 6))
ALIKE = equal_groups(2, (1.0,))
UNLIKE = tuple(design for design in DESIGNS if design not in ALIKE)
FEW = tuple(design for design in DESIGNS if math.comb(sum(design.n), design.n[0]) <= QUICK)
MANY = tuple(design for design in DESIGNS if design not in FEW)


@lru_cache
def _arrangements(n_a: int, n: int) -> Floats:
    """Return which values belong to the first group, shape (n, arrangements)."""
    chosen = np.array(list(combinations(range(n), n_a)))
    found = np.zeros((len(chosen), n))
    np.put_along_axis(found, chosen, 1.0, axis=1)
    return np.ascontiguousarray(found.T)


def _all_shuffles(groups: Groups) -> Floats:
    groups = list(map(arrays.flat, groups))
    values = np.concatenate(groups, axis=1)
    scores = values - values.mean(axis=1, keepdims=True)
    n_a = groups[0].shape[1]
    member = _arrangements(n_a, values.shape[1])
    p = np.empty(len(scores))
    for start in range(0, len(scores), AT_A_TIME):
        part = scores[start : start + AT_A_TIME]
        observed = np.abs(part[:, :n_a].sum(axis=1, keepdims=True))
        p[start : start + AT_A_TIME] = (np.abs(part @ member) >= observed - 1e-9).mean(axis=1)
    return p


def _permutation_one(groups: Groups, _design: Design) -> tuple[float, bool]:
    return of_one_p(permutation_test(*_with_days(groups), resamples=SHUFFLES, seed=_seed(groups)).p)


def _permutation(groups: Groups, design: Design) -> Floats:
    if math.comb(sum(design.n), design.n[0]) <= MOST_ARRANGEMENTS:
        return of_p(_all_shuffles(groups))
    return np.array([_permutation_one(study, design) for study in studies(groups)])


def _redrawn(groups: Groups) -> Bootstrap:
    return bootstrap_difference(*_with_days(groups), resamples=REDRAWS, seed=_seed(groups))


def _bootstrap_one(groups: Groups, _design: Design) -> tuple[float, float, bool]:
    return of_one_interval(_redrawn(groups).interval, 0.0)


def _percentile_one(groups: Groups, _design: Design) -> tuple[float, float, bool]:
    return of_one_interval(_redrawn(groups).percentile_interval, 0.0)


def _bca_one(groups: Groups, _design: Design) -> tuple[float, float, bool]:
    return of_one_interval(_redrawn(groups).bca_interval, 0.0)


def _with_days(groups: Groups) -> tuple[Floats, Floats, list[str] | None, list[str] | None]:
    """Return both groups' values and the days of each, None where there are none."""
    a, b = groups
    of_a, of_b = (
        None if group.ndim == 1 else [str(day) for day in range(len(group)) for _ in group[day]] for group in groups
    )
    return a.ravel(), b.ravel(), of_a, of_b


def _seed(groups: Groups) -> int:
    """Return another seed for each study, so that draws that happen to be odd are not the same in all."""
    return zlib.crc32(groups[0].tobytes())


METHODS = (
    Method("permutation", "size", FEW, _permutation_one, _permutation),
    Method("permutation", "size", MANY, _permutation_one, _permutation, runs=2000),
    Method("permutation", "size", ONE_DAY, _permutation_one, _permutation, runs=2000),
    Method("permutation", "size", (*BY_DAY, *MORE_BY_DAY), _permutation_one, runs=1000),
    Method("bootstrap", "coverage", DESIGNS, _bootstrap_one, runs=2000),
    Method("bootstrap", "coverage", (*ONE_DAY, *BY_DAY, *MORE_BY_DAY), _bootstrap_one, runs=1000),
    Method("bootstrap_bca", "coverage", (*ALIKE, *UNLIKE), _bca_one, runs=1000),
    Method("bootstrap_percentile", "coverage", (*ALIKE, *UNLIKE), _percentile_one, runs=1000),
    Method("permutation", "size", (*UNLIKE_BY_DAY, *MANY_BY_DAY), _permutation_one, runs=1000),
    Method("bootstrap", "coverage", (*UNLIKE_BY_DAY, *MANY_BY_DAY), _bootstrap_one, runs=1000),
    *(
        Method(
            f"bootstrap_{name}",
            "coverage",
            (*ONE_DAY, *BY_DAY, *MORE_BY_DAY, *UNLIKE_BY_DAY, *MANY_BY_DAY),
            one,
            runs=1000,
        )
        for name, one in (("bca", _bca_one), ("percentile", _percentile_one))
    ),
)
