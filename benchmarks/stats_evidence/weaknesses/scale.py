"""W5 to W7 and W25: values that differ by their last bits, and units whose squares leave the range of doubles."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from benchmarks.stats_evidence.weaknesses.case import Number, Peer, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import (
    frame,
    module,
    numpy,
    pg,
    pingouin,
    scipy,
    scipy_stats,
    sklearn,
    statsmodels,
    weightstats,
)
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova
from stats.groups.residuals import rmse_over_iqr
from tests.helpers.exact_fit import root
from tests.helpers.exact_tests import one_way, t_test

BIT = math.ulp(1e8)
NEAR_A = [1e8] * 5 + [1e8 + BIT]
NEAR_B = [1e8 + BIT, 1e8 + BIT, 1e8 + 2 * BIT, 1e8 + BIT, 1e8 + BIT]
WHOLE_A, WHOLE_B = [1.0, 2.0, 3.0], [3.0, 4.0, 5.0]
SMALL = np.array([100, 200], dtype=np.int16)
HUGE = np.array([1e200, 2e200])


def in_unit(values: list[float], exponent: int) -> list[float]:
    """Return values in a unit of 2^-exponent."""
    return [math.ldexp(value, exponent) for value in values]


def _at(exponent: int) -> str:
    return f" at 2^{exponent}" if exponent else ""


def _welch(a: list[float], b: list[float], exponent: int, *others: Peer) -> Question:
    return Question(
        f"Welch's p{_at(exponent)}",
        Number(lambda: float(t_test(a, b, pooled=False).p), "exact arithmetic"),
        lambda: compare_two(in_unit(a, exponent), in_unit(b, exponent), route="welch").p,
        others,
    )


def _scipy(a: list[float], b: list[float], exponent: int, recorded: float, what: str = "pvalue") -> Peer:
    units = in_unit(a, exponent), in_unit(b, exponent)
    name = "ttest_ind" + ("" if what == "pvalue" else f", {what}")
    return scipy(name, lambda: getattr(scipy_stats().ttest_ind(*units, equal_var=False), what), recorded)


def _statsmodels(a: list[float], b: list[float], exponent: int, recorded: float | str) -> Peer:
    units = in_unit(a, exponent), in_unit(b, exponent)
    return statsmodels("ttest_ind", lambda: weightstats().ttest_ind(*units, usevar="unequal")[1], recorded)


def _pingouin(a: list[float], b: list[float], exponent: int, recorded: float) -> Peer:
    units = in_unit(a, exponent), in_unit(b, exponent)
    return pg("ttest", lambda: pingouin().ttest(*units, correction=True)["p_val"].iloc[0], recorded)


def _f(exponent: int) -> Question:
    groups = {"a": in_unit(WHOLE_A, exponent), "b": in_unit(WHOLE_B, exponent)}
    return Question(
        f"F of an analysis of variance{_at(exponent)}",
        Number(lambda: one_way({"a": WHOLE_A, "b": WHOLE_B})[0], "exact arithmetic"),
        lambda: one_way_anova(groups).f,
        (
            scipy("f_oneway", lambda: scipy_stats().f_oneway(*groups.values()).statistic, "nan"),
            pg("anova", lambda: pingouin().anova(frame(groups), dv="y", between="group")["F"].iloc[0], "KeyError"),
        ),
    )


def _rmse(residuals: np.ndarray[Any, Any], recorded: str, sklearn_too: bool) -> Question:
    squares = sum((Fraction(x) ** 2 for x in residuals.tolist()), Fraction(0))
    zeros = np.zeros_like(residuals)
    others: list[Peer] = [
        numpy("sqrt(mean(r**2))", lambda: np.sqrt(np.mean(residuals**2)), recorded),
        statsmodels("rmse", lambda: module("statsmodels.tools.eval_measures").rmse(residuals, zeros), recorded),
    ]
    if sklearn_too:
        others.append(
            sklearn(
                "root_mean_squared_error",
                lambda: module("sklearn.metrics").root_mean_squared_error(zeros, residuals),
                recorded,
            )
        )
    return Question(
        f"root mean square of {residuals.dtype} residuals",
        Number(lambda: root(squares / residuals.size), "exact arithmetic"),
        lambda: rmse_over_iqr(zeros, residuals).rmse,
        tuple(others),
    )


CASES = (
    Weakness(
        "W5",
        "groups that differ by the last bit at 1e8",
        "1e8 + 0, 0, 0, 0, 0, 1 bits and 1e8 + 1, 1, 2, 1, 1 bits; made for this table",
        (
            _welch(
                NEAR_A,
                NEAR_B,
                0,
                _scipy(NEAR_A, NEAR_B, 0, 0.0082),
                _statsmodels(NEAR_A, NEAR_B, 0, 0.0082),
                _pingouin(NEAR_A, NEAR_B, 0, 0.0082),
            ),
        ),
    ),
    Weakness(
        "W6",
        "values times 2^-300",
        "1, 2, 3 and 3, 4, 5 times 2^-300",
        (
            _welch(
                WHOLE_A,
                WHOLE_B,
                -300,
                _scipy(WHOLE_A, WHOLE_B, -300, 0.247),
                _pingouin(WHOLE_A, WHOLE_B, -300, 0.247),
            ),
            Question(
                "Welch's degrees of freedom",
                Number(lambda: t_test(WHOLE_A, WHOLE_B, pooled=False).df, "exact arithmetic"),
                lambda: compare_two(in_unit(WHOLE_A, -300), in_unit(WHOLE_B, -300), route="welch").df,
                (_scipy(WHOLE_A, WHOLE_B, -300, 1.0, "df"),),
            ),
        ),
    ),
    Weakness(
        "W7",
        "values times 2^-600 and 2^600",
        "1, 2, 3 and 3, 4, 5 times 2^-600 and times 2^600",
        tuple(
            question
            for exponent, p in ((-600, 0.0), (600, 1.0))
            for question in (
                _welch(
                    WHOLE_A,
                    WHOLE_B,
                    exponent,
                    _scipy(WHOLE_A, WHOLE_B, exponent, p),
                    _statsmodels(WHOLE_A, WHOLE_B, exponent, "nan"),
                    _pingouin(WHOLE_A, WHOLE_B, exponent, p),
                ),
                _f(exponent),
            )
        ),
    ),
    Weakness(
        "W25",
        "squares beyond the type",
        "residuals 100 and 200 as int16, 1e200 and 2e200 as float64",
        (_rmse(SMALL, "nan", sklearn_too=False), _rmse(HUGE, "inf", sklearn_too=True)),
    ),
)
