"""W10 to W13: what is no number, is not there, or does not scatter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from benchmarks.stats_evidence.weaknesses.case import NoNumber, Number, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import (
    frame,
    module,
    pg,
    pingouin,
    scipy,
    scipy_stats,
    sm_oneway,
    statsmodels,
)
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.dunnett import dunnett
from tests.helpers.exact_tests import t_test, welch_one_way

POLICY = "refused, or left out and counted"

Groups = dict[str, list[float]]

A, B = [42.1, 39.8, 44.0, 41.2, 40.5], [36.9, 38.2, 35.1, 37.7, 36.0]
C = [39.9, 42.8, 41.0, 42.2, 40.1]
WITH_NAN, WITH_INF = [*B, math.nan], [*B, math.inf]
CONSTANT: Groups = {"a": A, "b": B, "c": [38.0] * 4}
INFINITE: Groups = {"a": A, "b": WITH_INF, "c": C}
DATA = f"a: {A}, b: {B}, c: {C}".translate(str.maketrans("", "", "[]"))


def _welch_p(groups: Mapping[str, list[float]]) -> float:
    return float(pingouin().welch_anova(frame(groups), dv="y", between="group")["p_unc"].iloc[0])


def _long() -> Any:
    """Return a and b in the long format, whose column of groups knows of a third one."""
    data = frame({"a": A, "b": B})
    data["group"] = module("pandas").Categorical(data["group"], categories=["a", "b", "c"])
    return data


def _lm_f() -> float:
    model = module("statsmodels.formula.api").ols("y ~ group", frame({"a": A, "b": B, "c": []})).fit()
    return float(module("statsmodels.api").stats.anova_lm(model)["F"].iloc[0])


CASES = (
    Weakness(
        "W10",
        "NaN in a group",
        f"{DATA}; NaN in b; made for this table",
        (
            Question(
                "Student's p",
                NoNumber("group b holds 1 of 6 values that are NaN", POLICY),
                lambda: compare_two(A, WITH_NAN, route="student").p,
                (pg("ttest", lambda: pingouin().ttest(A, WITH_NAN)["p_val"].iloc[0], 8.7e-4),),
            ),
            Question(
                "Student's p, missing values left out",
                Number(lambda: float(t_test(A, B, pooled=True).p), "exact arithmetic"),
                lambda: compare_two(A, WITH_NAN, route="student", missing="drop").p,
                (),
            ),
            Question(
                "how many were left out",
                Number(lambda: 1.0, "definition"),
                lambda: compare_two(A, WITH_NAN, missing="drop").missing_b,
                (),
            ),
            Question(
                "Dunnett's p of b against a",
                NoNumber("group 'b' holds 1 of 6 values that are NaN", POLICY),
                lambda: dunnett(A, {"b": WITH_NAN, "c": C}).comparisons[0].p,
                (scipy("dunnett", lambda: scipy_stats().dunnett(WITH_NAN, C, control=A, rng=1).pvalue[0], 1.0),),
            ),
        ),
    ),
    Weakness(
        "W11",
        "an infinite value in a group",
        f"{DATA}; infinity in b; made for this table",
        (
            Question(
                "p of Welch's analysis of variance",
                NoNumber("infinite"),
                lambda: welch_anova(INFINITE).p,
                (pg("welch_anova", lambda: _welch_p(INFINITE), 0.94),),
            ),
            Question(
                "F of an analysis of variance",
                NoNumber("infinite"),
                lambda: one_way_anova(INFINITE).f,
                (
                    pg(
                        "anova",
                        lambda: pingouin().anova(frame(INFINITE), dv="y", between="group")["F"].iloc[0],
                        "KeyError",
                    ),
                ),
            ),
            Question(
                "Dunnett's p of b against a",
                NoNumber("infinite"),
                lambda: dunnett(A, {"b": WITH_INF, "c": C}).comparisons[0].p,
                (scipy("dunnett", lambda: scipy_stats().dunnett(WITH_INF, C, control=A, rng=1).pvalue[0], 1.0),),
            ),
        ),
    ),
    Weakness(
        "W12",
        "an empty group",
        f"{DATA}; c empty; made for this table",
        (
            Question(
                "F of an analysis of variance",
                NoNumber("group 'c' is empty"),
                lambda: one_way_anova({"a": A, "b": B, "c": []}).f,
                (
                    statsmodels("anova_lm", _lm_f, 26.6),
                    pg("anova", lambda: pingouin().anova(_long(), dv="y", between="group")["F"].iloc[0], 26.6),
                ),
            ),
            Question(
                "Student's t",
                NoNumber("group b is empty"),
                lambda: compare_two(A, []).t,
                (),
            ),
        ),
    ),
    Weakness(
        "W13",
        "Welch's analysis of variance with one constant group, where the limit exists",
        f"{DATA.split(', c:')[0]}, c: 38.0 four times; made for this table",
        (
            Question(
                "p",
                Number(lambda: float(welch_one_way(CONSTANT)[1]), "mpmath, 600 digits, variance of c 1e-200"),
                lambda: welch_anova(CONSTANT).p,
                (
                    scipy(
                        "f_oneway",
                        lambda: scipy_stats().f_oneway(*CONSTANT.values(), equal_var=False).pvalue,
                        "nan",
                    ),
                    statsmodels("anova_oneway", lambda: sm_oneway(list(CONSTANT.values())).pvalue, "nan"),
                    pg("welch_anova", lambda: _welch_p(CONSTANT), "ValueError"),
                ),
            ),
        ),
    ),
)
