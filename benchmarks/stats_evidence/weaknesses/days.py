"""W21, W23 and W24: exact permutations, and conditions measured over days."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.stats_evidence.weaknesses.case import Number, Peer, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import module, pg, pingouin, scipy, scipy_stats, statsmodels
from stats.compare.resampling import permutation_test
from stats.days.blocked import blocked_by_day
from tests.helpers.exact_tests import additive
from tests.helpers.shared_days import Labels, crossed

TENTHS_A = ("9.9", "11.4", "10.6", "9.9", "10.0", "10.3")
TENTHS_B = ("10.4", "11.7", "10.1", "11.7", "11.9", "10.4")


def by_fractions() -> float:
    """Return the two-sided p over all arrangements, of decimals as written."""
    pooled = [Fraction(x) for x in TENTHS_A + TENTHS_B]
    centre = sum(pooled, Fraction(0)) / len(pooled)
    scores = [x - centre for x in pooled]
    found = abs(sum(scores[: len(TENTHS_A)], Fraction(0)))
    sums = [abs(sum(chosen, Fraction(0))) for chosen in combinations(scores, len(TENTHS_A))]
    return sum(each >= found for each in sums) / len(sums)


def _permutation(offset: int, recorded: float) -> Question:
    a, b = ([float(Decimal(x) + offset) for x in each] for each in (TENTHS_A, TENTHS_B))

    def difference(x: Any, y: Any, axis: int) -> Any:
        return np.mean(x, axis) - np.mean(y, axis)

    def by_permutations() -> float:
        found = scipy_stats().permutation_test((a, b), difference, n_resamples=10_000, vectorized=True)
        return float(found.pvalue)

    def by_t() -> float:
        stats = scipy_stats()
        return float(stats.ttest_ind(a, b, method=stats.PermutationMethod(n_resamples=10_000)).pvalue)

    return Question(
        f"p at +{offset:.0e}",
        Number(by_fractions, "exact arithmetic on the decimals"),
        lambda: permutation_test(a, b).p,
        (
            scipy("permutation_test", by_permutations, recorded),
            scipy("ttest_ind, PermutationMethod", by_t, recorded),
        ),
        digits=4,
    )


def _mixed(days: int, times: int, seed: int, recorded: float) -> Question:
    condition, day = crossed(2, days, times)
    rng = np.random.default_rng(seed)
    values = rng.normal(size=condition.size) + 1.2 * condition + rng.normal(0.0, 2.0, days)[day]

    def by_mixedlm() -> float:
        api = module("statsmodels.api")
        return float(api.MixedLM(values, api.add_constant(condition.astype(float)), groups=day).fit().pvalues[1])

    return Question(
        f"p of two conditions over {days} days",
        Number(lambda: float(additive(values, condition.tolist(), day.tolist())[2]), "exact F-test"),
        lambda: exact_of(values, condition, day, "p"),
        (statsmodels("MixedLM", by_mixedlm, recorded),),
    )


def exact_of(values: NDArray[np.float64], condition: Labels, day: Labels, what: str) -> Any:
    """Return one number of the exact test, or why there is none."""
    exact = blocked_by_day(values, condition, day).exact
    return getattr(exact, what, exact)


ALIKE = np.tile([1.0, 2.0, 3.0, 5.0, 2.0, 4.0, 3.5, 5.5], 3)


def _alike() -> Question:
    condition, day = crossed(2, 3, 4)

    def by_mixedlm() -> float:
        api = module("statsmodels.api")
        return float(api.MixedLM(ALIKE, api.add_constant(condition.astype(float)), groups=day).fit().pvalues[1])

    return Question(
        "p where days are alike",
        Number(lambda: float(additive(ALIKE, condition.tolist(), day.tolist())[2]), "exact F-test"),
        lambda: exact_of(ALIKE, condition, day, "p"),
        (statsmodels("MixedLM", by_mixedlm, "LinAlgError"),),
    )


CONDITION, DAY = crossed(3, 6, 3)
_RNG = np.random.default_rng(1)
REPLICATES = _RNG.normal(size=54) + 0.8 * CONDITION + _RNG.normal(size=6)[DAY]
KEPT = ~((CONDITION == 2) & (DAY == 4))


def _rm_anova(kept: NDArray[np.bool_], column: str, place: int) -> Callable[[], float]:
    def of_pingouin() -> float:
        data = module("pandas").DataFrame({"y": REPLICATES[kept], "condition": CONDITION[kept], "day": DAY[kept]})
        return float(
            pingouin().rm_anova(data, dv="y", within="condition", subject="day", detailed=True)[column].iloc[place]
        )

    return of_pingouin


def _replicates(what: str, kept: NDArray[np.bool_], *others: Peer, field: str, place: int) -> Question:
    data = REPLICATES[kept], CONDITION[kept], DAY[kept]
    return Question(
        what,
        Number(lambda: float(additive(data[0], data[1].tolist(), data[2].tolist())[place]), "exact F-test"),
        lambda: exact_of(*data, field),
        others,
    )


ALL = np.ones(54, dtype=np.bool_)

CASES = (
    Weakness(
        "W21",
        "exact permutation test of values with one decimal",
        f"{', '.join(TENTHS_A)} and {', '.join(TENTHS_B)}, plus an offset",
        (_permutation(10**6, 0.0996),),
    ),
    Weakness(
        "W23",
        "conditions over few days, the day at random",
        "conditions four or five times a day, effect 1.2, standard deviation 1, of days 2, drawn at random and chosen "
        "by their p; three days of 1, 2, 3, 5 and 2, 4, 3.5, 5.5",
        (_mixed(5, 5, 223, 1.3e-5), _mixed(3, 4, 821, 9.5e-4), _alike()),
    ),
    Weakness(
        "W24",
        "replicates, and a missing cell",
        "three conditions three times a day on six days, effect 0.8, standard deviation 1, of days 1, drawn at random "
        "for this table; without condition 3 on day 5",
        (
            _replicates(
                "degrees of freedom of the error",
                ALL,
                pg("rm_anova", _rm_anova(ALL, "DF", 1), 10.0),
                field="df_within",
                place=0,
            ),
            _replicates("F", ALL, pg("rm_anova", _rm_anova(ALL, "F", 0), 8.81), field="f", place=1),
            _replicates(
                "degrees of freedom without the cell",
                KEPT,
                pg("rm_anova", _rm_anova(KEPT, "DF", 1), 8.0),
                field="df_within",
                place=0,
            ),
            _replicates("F without the cell", KEPT, pg("rm_anova", _rm_anova(KEPT, "F", 0), 5.58), field="f", place=1),
        ),
    ),
)
