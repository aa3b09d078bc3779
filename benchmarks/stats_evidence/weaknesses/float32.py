"""W14 and W15: logs and groups stored as float32."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.stats_evidence.weaknesses.case import Number, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import (
    frame,
    module,
    numpy,
    pg,
    pingouin,
    scipy,
    scipy_stats,
    sm_oneway,
    statsmodels,
    xarray,
)
from stats.compare.summary import describe
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.tukey import compare_all_pairs
from tests.helpers.exact_fit import root
from tests.helpers.exact_tests import moments, one_way, welch_one_way

LENGTHS = (100_000, 1_000_000)
BITS = 20
"""Float32 between 8 and 16 holds multiples of 2^-20."""


@cache
def log(n: int) -> NDArray[np.float32]:
    """Return a battery's voltage twice, shape (n, 2): 12.6 V, standard deviation 0.01 V."""
    return np.random.default_rng(14).normal(12.6, 0.01, (n, 2)).astype(np.float32)


@cache
def exact_moments(n: int) -> tuple[float, float]:
    """Return mean and standard deviation of the first column, in whole numbers of 2^-20."""
    counts = np.ldexp(log(n)[:, 0].astype(np.float64), BITS).astype(np.int64)
    middle = round(12.6 * 2**BITS)
    from_middle = counts - middle
    total, squares = int(from_middle.sum()), int((from_middle * from_middle).sum())
    mean = Fraction(total, n) + middle
    return float(mean / 2**BITS), root(Fraction(n * squares - total * total, n * (n - 1) << 2 * BITS))


def as_xarray(n: int) -> Any:
    """Return the log with dimensions time and channel."""
    return module("xarray").DataArray(log(n), dims=("time", "channel"))


def _length(n: int, sd: float, mean: float) -> tuple[Question, ...]:
    return (
        Question(
            f"standard deviation of {n} values",
            Number(lambda: exact_moments(n)[1], "exact arithmetic"),
            lambda: describe(as_xarray(n)[:, 0]).sd,
            (
                numpy("std(axis=0)", lambda: log(n).std(axis=0, ddof=1)[0], sd),
                xarray('std("time")', lambda: as_xarray(n).std("time", ddof=1)[0], sd),
            ),
        ),
        Question(
            f"mean of {n} values",
            Number(lambda: exact_moments(n)[0], "exact arithmetic"),
            lambda: describe(as_xarray(n)[:, 0]).mean,
            (
                numpy("mean(axis=0)", lambda: log(n).mean(axis=0)[0], mean),
                xarray('mean("time")', lambda: as_xarray(n).mean("time")[0], mean),
            ),
            digits=5,
        ),
    )


def _groups() -> dict[str, NDArray[np.float32]]:
    rng = np.random.default_rng(16)
    return {
        name: (rng.normal(middle, 2.0, 12) + 1e7).astype(np.float32)
        for name, middle in (("a", 0.0), ("b", 3.0), ("c", 5.0))
    }


GROUPS = _groups()
EXACT = {name: values.tolist() for name, values in GROUPS.items()}
FLOATS = list(GROUPS.values())


def _pingouin(function: str) -> float:
    return float(getattr(pingouin(), function)(frame(GROUPS), dv="y", between="group")["F"].iloc[0])


def _tukey_p() -> float:
    """Return p of a and b from the exact q; scipy's tail has ten digits there."""
    (n, mean_a, _), (_, mean_b, _) = moments(EXACT["a"]), moments(EXACT["b"])
    df = 3 * (n - 1)
    within = sum((squares for _, _, squares in map(moments, EXACT.values())), Fraction(0)) / df
    q = root((mean_a - mean_b) ** 2 / within * n)
    return float(scipy_stats().studentized_range.sf(q, 3, df))


CASES = (
    Weakness(
        "W14",
        "a long float32 log, reduced over time",
        "12.6 V with a standard deviation of 0.01 V, float32 of shape (n, 2), drawn at random",
        tuple(
            question
            for n, sd, mean in zip(LENGTHS, (0.0124, 0.085), (12.607, 12.684), strict=True)
            for question in _length(n, sd, mean)
        ),
    ),
    Weakness(
        "W15",
        "float32 groups at an offset of 1e7",
        "three groups of 12 with means 0, 3, 5 and standard deviation 2, plus 1e7, drawn at random for this table",
        (
            Question(
                "F",
                Number(lambda: one_way(EXACT)[0], "exact arithmetic"),
                lambda: one_way_anova(GROUPS).f,
                (
                    statsmodels("anova_oneway", lambda: sm_oneway(FLOATS, "equal").statistic, 5.89),
                    pg("anova", lambda: _pingouin("anova"), 14.97),
                ),
                digits=4,
            ),
            Question(
                "Welch's F",
                Number(lambda: welch_one_way(EXACT)[0], "mpmath"),
                lambda: welch_anova(GROUPS).f,
                (
                    scipy("f_oneway", lambda: scipy_stats().f_oneway(*FLOATS, equal_var=False).statistic, 6.75),
                    statsmodels("anova_oneway", lambda: sm_oneway(FLOATS).statistic, 5.22),
                    pg("welch_anova", lambda: _pingouin("welch_anova"), 11.56),
                ),
                digits=4,
            ),
            Question(
                "Tukey's p of a and b",
                Number(_tukey_p, "exact q, scipy's tail", rel=1e-9),
                lambda: compare_all_pairs(GROUPS).pairs[0].p,
                (scipy("tukey_hsd", lambda: scipy_stats().tukey_hsd(*FLOATS).pvalue[0, 1], 0.078),),
            ),
        ),
    ),
)
