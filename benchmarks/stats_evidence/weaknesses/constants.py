"""W1 to W4: groups without scatter, from which rounding makes p-values of 0/0."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from benchmarks.stats_evidence.weaknesses.case import NoNumber, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import (
    frame,
    pg,
    pingouin,
    scipy,
    scipy_stats,
    sm_oneway,
    statsmodels,
    weightstats,
)
from stats.compare.effect_size import bayes_factor
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.dunnett import dunnett
from stats.groups.tukey import compare_all_pairs
from stats.groups.variances import bartlett

NO_SCATTER = NoNumber("neither group has any scatter")
NO_SCATTER_AT_ALL = NoNumber("no group has any scatter")

Wrong = tuple[float, float]
"""Student's p and Welch's p as recorded."""


def _p_values(a: list[float], b: list[float], of_scipy: Wrong, of_statsmodels: Wrong) -> tuple[Question, ...]:
    def one(equal: bool, ours: Callable[[], Any]) -> Question:
        name, place = ("Student", 0) if equal else ("Welch", 1)
        use_var = "pooled" if equal else "unequal"
        return Question(
            f"{name}'s p",
            NO_SCATTER,
            ours,
            (
                scipy("ttest_ind", lambda: scipy_stats().ttest_ind(a, b, equal_var=equal).pvalue, of_scipy[place]),
                statsmodels(
                    "ttest_ind", lambda: weightstats().ttest_ind(a, b, usevar=use_var)[1], of_statsmodels[place]
                ),
                pg("ttest", lambda: pingouin().ttest(a, b, correction=not equal)["p_val"].iloc[0], of_scipy[place]),
            ),
        )

    return (
        one(True, lambda: compare_two(a, b, route="student").p),
        one(False, lambda: compare_two(a, b, route="welch").p),
    )


TENTHS = {"a": [0.1] * 3, "b": [0.1] * 7, "c": [0.1] * 5}
LOW, HIGH = [0.3] * 10, [0.6] * 10

CASES = (
    Weakness(
        "W1",
        "constant groups of one value",
        "0.04 ten times and thirty times",
        _p_values([0.04] * 10, [0.04] * 30, (4.6e-6, 9.9e-5), (7.5e-5, 1.3e-6)),
    ),
    Weakness(
        "W2",
        "constant groups, few values",
        "0.1 three times and seven times",
        _p_values([0.1] * 3, [0.1] * 7, (0.032, 0.081), (0.032, 0.081)),
    ),
    Weakness(
        "W3",
        "analysis of variance of one constant",
        "0.1 three, seven and five times",
        (
            Question(
                "F",
                NO_SCATTER_AT_ALL,
                lambda: one_way_anova(TENTHS).f,
                (pg("anova", lambda: pingouin().anova(frame(TENTHS), dv="y", between="group")["F"].iloc[0], 51.6),),
            ),
            Question(
                "p",
                NO_SCATTER_AT_ALL,
                lambda: one_way_anova(TENTHS).p,
                (
                    statsmodels("anova_oneway", lambda: sm_oneway(list(TENTHS.values()), "equal").pvalue, 0.016),
                    pg(
                        "anova",
                        lambda: pingouin().anova(frame(TENTHS), dv="y", between="group")["p_unc"].iloc[0],
                        1.3e-6,
                    ),
                ),
            ),
            Question(
                "Welch's p",
                NO_SCATTER_AT_ALL,
                lambda: welch_anova(TENTHS).p,
                (
                    pg(
                        "welch_anova",
                        lambda: pingouin().welch_anova(frame(TENTHS), dv="y", between="group")["p_unc"].iloc[0],
                        "ValueError",
                    ),
                ),
            ),
            Question(
                "Tukey's p of a and b",
                NO_SCATTER_AT_ALL,
                lambda: compare_all_pairs(TENTHS).pairs[0].p,
                (scipy("tukey_hsd", lambda: scipy_stats().tukey_hsd(*TENTHS.values()).pvalue[0, 1], 0.020),),
            ),
            Question(
                "Dunnett's p of b against a",
                NO_SCATTER_AT_ALL,
                lambda: dunnett(TENTHS["a"], {name: TENTHS[name] for name in "bc"}).comparisons[0].p,
                (
                    scipy(
                        "dunnett",
                        lambda: scipy_stats().dunnett(TENTHS["b"], TENTHS["c"], control=TENTHS["a"], rng=1).pvalue[0],
                        0.014,
                    ),
                ),
            ),
            Question(
                "Bartlett's p",
                NoNumber("group 'a' is constant"),
                lambda: bartlett(TENTHS).p,
                (scipy("bartlett", lambda: scipy_stats().bartlett(*TENTHS.values()).pvalue, 0.0),),
            ),
        ),
    ),
    Weakness(
        "W4",
        "two constants that differ",
        "0.3 ten times and 0.6 ten times",
        (
            Question(
                "t",
                NO_SCATTER,
                lambda: compare_two(LOW, HIGH).t,
                (
                    scipy("ttest_ind", lambda: scipy_stats().ttest_ind(LOW, HIGH).statistic, -7.25e15),
                    statsmodels("ttest_ind", lambda: weightstats().ttest_ind(LOW, HIGH)[0], -7.25e15),
                    pg("ttest", lambda: pingouin().ttest(LOW, HIGH)["T"].iloc[0], -7.25e15),
                ),
            ),
            Question(
                "effect size",
                NO_SCATTER,
                lambda: compare_two(LOW, HIGH).hedges_g,
                (pg("ttest", lambda: pingouin().ttest(LOW, HIGH)["cohen_d"].iloc[0], 3.24e15),),
            ),
            Question(
                "Bayes factor",
                NO_SCATTER,
                lambda: bayes_factor_of(LOW, HIGH),
                (pg("ttest", lambda: pingouin().ttest(LOW, HIGH)["BF10"].iloc[0], 2.01e26),),
            ),
        ),
    ),
)


def bayes_factor_of(a: list[float], b: list[float]) -> Any:
    """Return log10 of the Bayes factor of two groups, or why they have no t."""
    t = compare_two(a, b).pooled_t
    return bayes_factor(t, len(a), len(b)).log10_bf if isinstance(t, float) else t
