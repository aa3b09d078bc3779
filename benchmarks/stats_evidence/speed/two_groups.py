"""One and two samples: description, t, variances, equivalence, effect size, power, resampling."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pingouin
import scipy.optimize
import scipy.stats
import statsmodels.api as sm
from statsmodels.stats.power import TTestIndPower
from statsmodels.stats.weightstats import CompareMeans, DescrStatsW

from benchmarks.stats_evidence.speed.case import BARE, PINGOUIN, SCIPY, STATSMODELS, Call, Case, Inputs, Peer
from stats.compare.effect_size import bayes_factor, hedges_g_ci
from stats.compare.equivalence import equivalence
from stats.compare.resampling import bootstrap_difference, permutation_test
from stats.compare.savings import percent_savings
from stats.compare.summary import autocorrelation, describe
from stats.compare.two_sample import compare_two
from stats.groups.residuals import rmse_over_iqr
from stats.groups.variances import f_test
from stats.planning.power import power_t

RESAMPLES = 999
BOUND = 0.5
T = 2.5


def _described(it: Inputs) -> object:
    x = it.a
    se = scipy.stats.sem(x)
    return x.mean(), x.std(ddof=1), se, scipy.stats.t.interval(0.95, x.size - 1, x.mean(), se)


def _f_test(it: Inputs) -> object:
    df = it.n - 1
    f = it.a.var(ddof=1) / it.b.var(ddof=1)
    p = 2.0 * min(scipy.stats.f.sf(f, df, df), scipy.stats.f.cdf(f, df, df))
    return f, p, f / scipy.stats.f.ppf([0.975, 0.025], df, df)


def _compared(it: Inputs) -> object:
    student, welch = (scipy.stats.ttest_ind(it.a, it.b, equal_var=equal) for equal in (True, False))
    df = it.n - 1
    f = it.a.var(ddof=1) / it.b.var(ddof=1)
    f_p = 2.0 * min(scipy.stats.f.sf(f, df, df), scipy.stats.f.cdf(f, df, df))
    spreads = scipy.stats.levene(it.a, it.b)
    return student.confidence_interval(), welch.confidence_interval(), f, f_p, spreads


def _compared_by_statsmodels(it: Inputs) -> object:
    both = CompareMeans(DescrStatsW(it.a), DescrStatsW(it.b))
    return [
        (both.ttest_ind(usevar=variances), both.tconfint_diff(usevar=variances)) for variances in ("pooled", "unequal")
    ]


def _equivalent(it: Inputs) -> object:
    found = []
    for equal in (True, False):
        above = scipy.stats.ttest_ind(it.a + BOUND, it.b, equal_var=equal, alternative="greater")
        below = scipy.stats.ttest_ind(it.a - BOUND, it.b, equal_var=equal, alternative="less")
        found.append((above, below, scipy.stats.ttest_ind(it.a, it.b, equal_var=equal).confidence_interval(0.9)))
    return found


def _equivalent_by_statsmodels(it: Inputs) -> object:
    both = CompareMeans(DescrStatsW(it.a), DescrStatsW(it.b))
    return [
        (both.ttost_ind(-BOUND, BOUND, usevar=variances), both.tconfint_diff(alpha=0.1, usevar=variances))
        for variances in ("pooled", "unequal")
    ]


def _g_interval(it: Inputs) -> Call:
    """A new t at each call: labbook keeps the intervals that it has computed."""
    ts = (T + 1e-6 * number for number in itertools.count())
    return lambda: hedges_g_ci(next(ts), 2 * it.n - 2, it.n, it.n)


def _g_interval_by_scipy(it: Inputs) -> object:
    df = 2 * it.n - 2
    return [
        scipy.optimize.brentq(lambda delta, tail=tail: scipy.stats.nct.cdf(T, df, delta) - tail, T - 6.0, T + 6.0)
        for tail in (0.975, 0.025)
    ]


def _power(it: Inputs) -> object:
    df, ncp = 2 * it.n - 2, 0.5 / math.sqrt(2.0 / it.n)
    critical = scipy.stats.t.ppf(0.975, df)
    return scipy.stats.nct.sf(critical, df, ncp) + scipy.stats.nct.cdf(-critical, df, ncp)


def _difference_of_means(a: np.ndarray, b: np.ndarray, axis: int) -> object:
    return np.mean(a, axis=axis) - np.mean(b, axis=axis)


CASES = (
    Case(
        "describe",
        lambda it: lambda: describe(it.a),
        (Peer(SCIPY, "mean, std, sem, t.interval", lambda it: lambda: _described(it)),),
    ),
    Case(
        "compare_two",
        lambda it: lambda: compare_two(it.a, it.b),
        (
            Peer(
                SCIPY, "ttest_ind twice with intervals, var and f.sf, f.cdf, levene", lambda it: lambda: _compared(it)
            ),
            Peer(
                STATSMODELS,
                "CompareMeans: both t-tests with intervals",
                lambda it: lambda: _compared_by_statsmodels(it),
            ),
            Peer(PINGOUIN, "ttest (one t-test)", lambda it: lambda: pingouin.ttest(it.a, it.b)),
            Peer(BARE, "ttest_ind", lambda it: lambda: scipy.stats.ttest_ind(it.a, it.b)),
        ),
    ),
    Case(
        "f_test",
        lambda it: lambda: f_test(it.a, it.b),
        (Peer(SCIPY, "var twice, f.sf, f.cdf, f.ppf", lambda it: lambda: _f_test(it)),),
    ),
    Case(
        "equivalence",
        lambda it: lambda: equivalence(it.a, it.b, low=-BOUND, high=BOUND),
        (
            Peer(
                SCIPY, "ttest_ind three times, by Student and by Welch, intervals", lambda it: lambda: _equivalent(it)
            ),
            Peer(
                STATSMODELS, "ttost_ind and tconfint_diff, both ways", lambda it: lambda: _equivalent_by_statsmodels(it)
            ),
            Peer(PINGOUIN, "tost (one way, no interval)", lambda it: lambda: pingouin.tost(it.a, it.b, BOUND)),
        ),
    ),
    Case("percent_savings", lambda it: lambda: percent_savings(it.a + 20.0, it.b + 18.0)),
    Case(
        "hedges_g_ci",
        _g_interval,
        (
            Peer(SCIPY, "brentq over nct.cdf", lambda it: lambda: _g_interval_by_scipy(it)),
            Peer(
                PINGOUIN,
                "compute_esci (normal approximation)",
                lambda it: lambda: pingouin.compute_esci(0.5, it.n, it.n),
            ),
        ),
    ),
    Case(
        "bayes_factor",
        lambda it: lambda: bayes_factor(T, it.n, it.n),
        (Peer(PINGOUIN, "bayesfactor_ttest", lambda it: lambda: pingouin.bayesfactor_ttest(T, it.n, it.n)),),
    ),
    Case(
        "power_t",
        lambda it: lambda: power_t(0.5, 1.0, it.n, it.n),
        (
            Peer(SCIPY, "t.ppf, nct.sf, nct.cdf", lambda it: lambda: _power(it)),
            Peer(STATSMODELS, "TTestIndPower", lambda it: lambda: TTestIndPower().power(0.5, it.n, 0.05)),
            Peer(PINGOUIN, "power_ttest2n", lambda it: lambda: pingouin.power_ttest2n(it.n, it.n, 0.5)),
        ),
    ),
    Case(
        f"permutation_test, {RESAMPLES} draws",
        lambda it: lambda: permutation_test(it.a, it.b, resamples=RESAMPLES),
        (
            Peer(
                SCIPY,
                "permutation_test, vectorized",
                lambda it: (
                    lambda: scipy.stats.permutation_test(
                        (it.a, it.b), _difference_of_means, n_resamples=RESAMPLES, vectorized=True, rng=1
                    )
                ),
            ),
        ),
    ),
    Case(
        f"bootstrap_difference, {RESAMPLES} draws",
        lambda it: lambda: bootstrap_difference(it.a, it.b, resamples=RESAMPLES),
        (
            Peer(
                SCIPY,
                "bootstrap, BCa, vectorized",
                lambda it: (
                    lambda: scipy.stats.bootstrap(
                        (it.a, it.b), _difference_of_means, n_resamples=RESAMPLES, vectorized=True, rng=1, batch=100
                    )
                ),
            ),
        ),
    ),
    Case(
        "rmse_over_iqr",
        lambda it: lambda: rmse_over_iqr(it.a, it.b),
        (Peer(SCIPY, "mean, iqr", lambda it: lambda: np.sqrt(np.mean((it.b - it.a) ** 2)) / scipy.stats.iqr(it.a)),),
    ),
    Case(
        "autocorrelation",
        lambda it: lambda: autocorrelation(it.a),
        (Peer(STATSMODELS, "acf", lambda it: lambda: sm.tsa.acf(it.a, nlags=1)),),
    ),
)
