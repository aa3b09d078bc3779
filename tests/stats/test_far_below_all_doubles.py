"""p-values near 1e-10000: 0 as doubles, right as logarithms, in words as powers of ten."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from stats.days.blocked import blocked_by_day

from stats.compare.equivalence import equivalence
from stats.compare.shared_error import SharedError, difference_with_shared
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.dunnett import dunnett
from stats.groups.multiple import holm
from stats.groups.tukey import compare_all_pairs
from stats.groups.variances import bartlett, brown_forsythe, f_test
from stats.lines.regression import fit_linear, fit_polynomial

N = 1700
RNG = np.random.default_rng(11)
A, B = RNG.normal(size=N), RNG.normal(size=N) + 3400.0
WIDE = 1e7 * RNG.normal(size=N)
GROUPS = {"a": A, "b": B}
DAYS = np.tile(np.arange(10), N // 10)


def of_t(t: float, df: float) -> mpmath.mpf:
    with mpmath.workdps(60):
        x = mpmath.mpf(df) / (mpmath.mpf(df) + mpmath.mpf(t) ** 2)
        return mpmath.log10(mpmath.betainc(mpmath.mpf(df) / 2, mpmath.mpf(1) / 2, 0, x, regularized=True))


def of_f(f: float, above: float, below: float) -> mpmath.mpf:
    with mpmath.workdps(60):
        x = mpmath.mpf(below) / (below + mpmath.mpf(above) * f)
        return mpmath.log10(mpmath.betainc(mpmath.mpf(below) / 2, mpmath.mpf(above) / 2, 0, x, regularized=True))


def days() -> Any:
    return blocked_by_day(np.concatenate([A, B]), ["a"] * N + ["b"] * N, np.concatenate([DAYS, DAYS]))


LOGS: dict[str, Callable[[], tuple[Any, float, mpmath.mpf]]] = {
    "compare_two": lambda: (r := compare_two(A, B), r.log10_p, of_t(r.t, r.df)),
    "welch": lambda: (r := compare_two(A, B, route="welch"), r.welch_log10_p, of_t(r.welch_t, r.welch_df)),
    "one_way_anova": lambda: (r := one_way_anova(GROUPS), r.log10_p, of_f(r.f, r.df_between, r.df_within)),
    "welch_anova": lambda: (r := welch_anova(GROUPS), r.log10_p, of_f(r.f, r.df_between, r.df_within)),
    "fit_linear": lambda: (r := fit_linear(B, {"x": B + 1e-3 * A}), r.log10_p[1], of_t(r.t[1], r.df)),
    "f of fit_linear": lambda: (r := fit_linear(B, {"x": B + 1e-3 * A}), r.f_log10_p, of_f(r.f, r.df_model, r.df)),
    "fit_polynomial": lambda: (r := fit_polynomial(WIDE, 3.0 * WIDE + A, 2), r.log10_p[1], of_t(r.t[1], r.df)),
    "blocked_by_day": lambda: (r := days(), r.log10_p, of_f(r.f, r.df_between, r.df_within)),
    "lmertest": lambda: (r := days(), (m := r.mixed).lmertest_log10_p, of_f(m.f, m.df_between, m.lmertest_df_within)),
    "contrast": lambda: (r := days(), r.contrasts[0].log10_p, of_t(r.contrasts[0].t, r.contrasts[0].df)),
    "exact": lambda: (r := days(), r.exact.log10_p, of_f(r.exact.f, r.exact.df_between, r.exact.df_within)),
    "f_test": lambda: (r := f_test(WIDE, A), r.log10_p, of_f(r.statistic, *r.df) + mpmath.log10(2)),
    "two of tukey": lambda: (
        r := compare_all_pairs(GROUPS),
        r.pairs[0].log10_p,
        of_t(r.pairs[0].q / 2**0.5, r.pairs[0].df),
    ),
    "two of games and howell": lambda: (
        r := compare_all_pairs(GROUPS, variances="unequal"),
        r.pairs[0].log10_p,
        of_t(r.pairs[0].q / 2**0.5, r.pairs[0].df),
    ),
    "dunnett": lambda: (r := dunnett(A, {"b": B}), r.comparisons[0].log10_p, of_t(r.comparisons[0].t, r.df)),
    "equivalence": lambda: (
        r := equivalence(A, B, low=-7000.0, high=None),
        r.log10_p,
        of_t(r.welch.t_low, r.welch.df_low) - mpmath.log10(2),
    ),
    "holm": lambda: (
        r := holm({"one": 0.0, "two": 0.0}, "of two", log10_p={"one": -12000.5, "two": -9000.0}),
        r.adjusted_log10_p[0],
        -12000.5 + mpmath.log10(2),
    ),
    "shared": lambda: (
        r := difference_with_shared(2e6, 3000.0, 0.0, (1.0 - 1e-6, 1.0 + 1e-6), SharedError()),
        r.log10_p,
        of_t(2e6, 3000.0),
    ),
}


@pytest.mark.parametrize("name", LOGS)
def test_logarithms_go_on_where_doubles_end(name):
    result, found, right = LOGS[name]()
    assert -25_000.0 < found < -5000.0
    assert found == pytest.approx(float(right), rel=1e-12)
    assert "p < .001" in result.sentence()


def test_bartlett_and_spreads_go_on_too():
    """Their statistics are sums; the tails are those of `stats.exact.tails`."""
    found = bartlett({"a": A, "b": 1e7 * A})
    with mpmath.workdps(60):
        right = mpmath.log10(mpmath.gammainc(0.5, mpmath.mpf(found.statistic) / 2, mpmath.inf, regularized=True))
    assert found.log10_p == pytest.approx(float(right), rel=1e-12)
    assert found.log10_p < -5000.0
    assert found.p == 0.0
    # However unlike the groups, F of their spreads has a bound: distances scatter as the values do.
    assert -1000.0 < brown_forsythe({"a": A, "b": WIDE}).log10_p < -300.0
