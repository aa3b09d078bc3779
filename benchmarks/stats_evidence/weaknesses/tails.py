"""W8, W9 and W26: probabilities far out, and one that is drawn by lot."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import mpmath

from benchmarks.stats_evidence.weaknesses.case import Number, Peer, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import (
    frame,
    module,
    pg,
    pingouin,
    scipy,
    scipy_stats,
    sm_oneway,
    statsmodels,
    weightstats,
)
from stats.compare.effect_size import CAUCHY_SCALE, bayes_factor
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova
from stats.groups.dunnett import dunnett
from stats.groups.tukey import range_tail
from tests.helpers import nist
from tests.helpers.exact_tests import log10_bayes_factor, t_test

FAR_A = [-1.0, 1.0] * 200
FAR_B = [102.65, 104.65] * 200
CONTROL = (42.1, 39.8, 44.0, 41.2)
TREATED = {"50": (36.9, 38.2, 35.1, 37.7), "100": (37.0, 39.5), "150": (41.0, 42.2, 40.1, 39.9, 42.8)}
DUNNETT_P = 0.04986334635429616
"""Of "100" against the control: `tests.helpers.exact_tests.dunnett_tail` with a step of 0.2."""
T, N = 1464.0, 400
"""Of which the Bayes factor is taken."""


@cache
def _smls() -> dict[str, list[float]]:
    return {name: [float(value) for value in values] for name, values in nist.groups("SmLs03").items()}


def log10(value: Any) -> float:
    """Return the decimal logarithm of an mpf as a double."""
    return float(mpmath.log10(value))


def logarithm(p: float) -> float:
    """Return log10 of what a program gives as p: minus infinity of 0."""
    return math.log10(p) if p > 0.0 else -math.inf


def _range(q: float, df: int, recorded: float, digits: int = 3) -> Question:
    def truth() -> float:
        with mpmath.workdps(40):
            return float(
                mpmath.betainc(mpmath.mpf(df) / 2, 0.5, 0, df / (df + mpmath.mpf(q) ** 2 / 2), regularized=True)
            )

    return Question(
        f"P(Q > {q:g}), k = 2, df = {df}",
        Number(truth, "mpmath, by t"),
        lambda: range_tail(q, 2, df).p,
        (
            scipy("studentized_range.sf", lambda: scipy_stats().studentized_range.sf(q, 2, df), recorded),
            statsmodels(
                "psturng",
                lambda: module("statsmodels.stats.libqsturng").psturng(q, 2, df),
                0.001,
            ),
        ),
        digits,
    )


def _log_f() -> float:
    stats, groups = scipy_stats(), _smls()
    found = stats.f_oneway(*groups.values())
    return float(stats.f.logsf(found.statistic, len(groups) - 1, sum(map(len, groups.values())) - len(groups)))


def _drawn(seed: int, recorded: float) -> Peer:
    def p() -> float:
        return float(scipy_stats().dunnett(*TREATED.values(), control=CONTROL, rng=seed).pvalue[1])

    return scipy(f"dunnett, rng={seed}", p, recorded)


CASES = (
    Weakness(
        "W8",
        "p below the smallest double",
        "NIST's SmLs03; -1 and 1 by turns, 400 values, against the same plus 103.65; t = 1464 with n = 400 and 400",
        (
            Question(
                "log10 of p, one-way analysis of variance",
                Number(lambda: log10(nist.exact("SmLs03", "anova", "p")), "exact arithmetic, mpmath"),
                lambda: one_way_anova(_smls()).log10_p,
                (
                    scipy("f.logsf", _log_f, -math.inf),
                    statsmodels(
                        "anova_oneway, log10",
                        lambda: logarithm(sm_oneway(list(_smls().values()), "equal").pvalue),
                        -math.inf,
                    ),
                    pg(
                        "anova, log10",
                        lambda: logarithm(pingouin().anova(frame(_smls()), dv="y", between="group")["p_unc"].iloc[0]),
                        -math.inf,
                    ),
                ),
                digits=7,
            ),
            Question(
                "log10 of Student's p",
                Number(lambda: log10(t_test(FAR_A, FAR_B, pooled=True).p), "exact arithmetic, mpmath"),
                lambda: compare_two(FAR_A, FAR_B, route="student").log10_p,
                (
                    scipy(
                        "ttest_ind, log10", lambda: logarithm(scipy_stats().ttest_ind(FAR_A, FAR_B).pvalue), -math.inf
                    ),
                    statsmodels(
                        "ttest_ind, log10", lambda: logarithm(weightstats().ttest_ind(FAR_A, FAR_B)[1]), -math.inf
                    ),
                    pg(
                        "ttest, log10",
                        lambda: logarithm(pingouin().ttest(FAR_A, FAR_B)["p_val"].iloc[0]),
                        -math.inf,
                    ),
                ),
                digits=7,
            ),
            Question(
                "log10 of the Bayes factor",
                Number(lambda: log10_bayes_factor(T, N, N, CAUCHY_SCALE), "mpmath"),
                lambda: bayes_factor(T, N, N).log10_bf,
                (
                    pg(
                        "bayesfactor_ttest, log10",
                        lambda: logarithm(pingouin().bayesfactor_ttest(T, N, N)),
                        "ZeroDivisionError",
                    ),
                ),
                digits=7,
            ),
        ),
    ),
    Weakness(
        "W9",
        "tail of Tukey's studentized range",
        "as named",
        (_range(20.0, 30, 3.66e-15), _range(15.0, 20, 1.1647303e-9, digits=7), _range(40.0, 60, 3.55e-15)),
    ),
    Weakness(
        "W26",
        "Dunnett's p, which scipy draws by lot",
        "42.1, 39.8, 44.0, 41.2 (control); 36.9, 38.2, 35.1, 37.7; 37.0, 39.5; 41.0, 42.2, 40.1, 39.9, 42.8",
        (
            Question(
                "p of the second treatment",
                Number(lambda: DUNNETT_P, "mpmath"),
                lambda: dunnett(CONTROL, TREATED).comparisons[1].p,
                (_drawn(1, 0.049858), _drawn(2, 0.049900)),
                digits=5,
            ),
        ),
    ),
)
