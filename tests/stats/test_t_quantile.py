"""Student's quantile against 50 digits: 12 of them, as is promised."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from stats.exact.tails import t_quantile, t_upper_quantile, t_upper_quantiles

LEVELS = [0.5, 0.6, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 0.9999]


def distance(found: float, df: float, tail: Fraction) -> float:
    """Relative distance from the quantile of the upper tail: one step of Newton's from there, in logarithms."""
    with mpmath.workdps(50):
        t, wanted = mpmath.mpf(found), mpmath.mpf(tail.numerator) / tail.denominator
        if df > 1e40:  # the normal's but for t^4 / (4 df)
            upper, density = mpmath.erfc(t / mpmath.sqrt(2)) / 2, mpmath.npdf(t)
        elif df > 1e6:
            upper, density = by_quadrature(t, mpmath.mpf(df))
        else:
            df = mpmath.mpf(df)
            upper = mpmath.betainc(df / 2, 0.5, 0, df / (df + t * t), regularized=True) / 2
            density = (1 + t * t / df) ** (-(df + 1) / 2) / (mpmath.sqrt(df) * mpmath.beta(df / 2, 0.5))
        if 4 * wanted > 1:  # what is left to the middle has the digits there
            return abs(float((upper - wanted) / density / t))
        return abs(float(mpmath.log(upper / wanted) * upper / density / t))


def by_quadrature(t: mpmath.mpf, df: mpmath.mpf) -> tuple[mpmath.mpf, mpmath.mpf]:
    """The upper tail and the density of t, with 50 digits left where the gamma functions cancel."""
    with mpmath.workdps(100):
        at_middle = mpmath.exp(mpmath.loggamma((df + 1) / 2) - mpmath.loggamma(df / 2)) / mpmath.sqrt(mpmath.pi * df)

    def density(x: mpmath.mpf) -> mpmath.mpf:
        return at_middle * mpmath.exp(-(df + 1) / 2 * mpmath.log1p(x * x / df))

    if t < 1:
        return 0.5 - mpmath.quad(density, [0, t]), density(t)
    at_t = density(t)  # the quadrature ends at an absolute error
    area = mpmath.quad(lambda step: density(t + step / t) / at_t, [0, 2, 5, 10, 20, 40, 80, 130])
    return area * at_t / t, at_t


@pytest.mark.parametrize("level", LEVELS)
def test_usual_levels(level):
    rng = np.random.default_rng(round(1e4 * level))
    dfs = [0.5, 0.7, 1.0, 1.999999, 2.0, 2.0000001, 2.01, 3.0, 6.0, 30.0, 1e3, 1e6, math.inf]
    for df in [*dfs, *np.exp(rng.uniform(math.log(0.5), math.log(1e6), 25)).tolist()]:
        assert distance(t_quantile(level, df), df, (1 - Fraction(level)) / 2) < 1e-12, df


@pytest.mark.parametrize("tail", [1e-100, 1e-20, 0.05, 0.3])
@pytest.mark.parametrize("df", [1.5, 8.0, 40.5, math.inf])
def test_tails_of_one_side(tail, df):
    found = t_upper_quantile(tail, df)
    assert distance(found, df, Fraction(tail)) < 1e-12
    assert t_upper_quantile(1 - Fraction(tail), df) == -found


def test_the_middle():
    assert t_upper_quantile(0.5, 7.0) == 0.0
    assert distance(t_quantile(1e-9, 7.0), 7.0, (1 - Fraction(1e-9)) / 2) < 1e-12
    assert t_upper_quantile(0.0, 7.0) == math.inf == t_quantile(1, math.inf)


@pytest.mark.soak
def test_any_degrees_of_freedom_and_any_tail():
    rng = np.random.default_rng(20)
    below = np.exp(rng.uniform(math.log(0.02), math.log(1e6), 60)).tolist()
    above = np.exp(rng.uniform(math.log(1e6), math.log(1e300), 40)).tolist()
    found = []
    for df in [*below, *above, 1e15, 1.0000001e15, 1e17, 1e20, 1e100, 1e300, math.inf]:
        for exponent in rng.uniform(-300.0, math.log10(0.5), 4).tolist():
            tail = 10.0**exponent
            t = t_upper_quantile(tail, df)
            if t == math.inf:  # beyond the largest double
                assert power_law(tail, df) > 1.79e308, (df, tail)
                continue
            found.append(t)
            assert distance(t, df, Fraction(tail)) < 1e-12, (df, tail)
    assert len(found) > 300


def power_law(tail: float, df: float) -> mpmath.mpf:
    """The quantile of far tails, which is above any other."""
    df = mpmath.mpf(df)
    return mpmath.sqrt(df) * (1 / (df * mpmath.beta(df / 2, 0.5) * tail)) ** (1 / df)


@pytest.mark.parametrize("df", [0.02, 0.9, 1.0, 7.5, 1e5, 1e12, 1e16, 1e250, math.inf])
@pytest.mark.parametrize("level", [1e-15, 1e-6, 1e-3, 0.3])
def test_levels_near_0(level, df):
    assert distance(t_quantile(level, df), df, (1 - Fraction(level)) / 2) < 1e-12
    assert t_quantile(level * 2.0**-900, df) == pytest.approx(t_quantile(level * 2.0**-100, df) * 2.0**-800, rel=1e-12)


@pytest.mark.parametrize(
    ("tail", "df"),
    [(7.7e-266, 3.0), (3.3e-273, 1.5), (1e-15, 0.05), (1e-90, 0.3), (5e-324, 2.0), (5e-324, 40.0), (5e-324, math.inf)],
)
def test_where_scipys_quantile_is_lost(tail, df):
    assert distance(t_upper_quantile(tail, df), df, Fraction(tail)) < 1e-12


@pytest.mark.parametrize(("tail", "df"), [(1e-300, 0.05), (1e-300, 0.3), (5e-324, 1.0), (0.05, 1e-300), (0.4, 1e-5)])
def test_beyond_the_largest_double_it_is_infinite(tail, df):
    assert t_upper_quantile(tail, df) == math.inf
    assert t_upper_quantile(1 - Fraction(tail), df) == -math.inf


def test_so_few_degrees_of_freedom_that_t_is_a_hyperbolic_sine():
    for df in (1e-30, 0.9e-16, 1.1e-16):
        for times in (1e-3, 1.0, 300.0):
            both = 1 - Fraction(times) * Fraction(df)
            log_both = -times * df * (1.0 + times * df / 2.0)
            wanted = mpmath.sqrt(df) * mpmath.sinh(-log_both / mpmath.mpf(df))
            assert t_upper_quantile(both / 2, df) == pytest.approx(float(wanted), rel=1e-12)


def test_where_the_square_of_t_overflows():
    assert distance(t_upper_quantile(Fraction(1, 10**80), 0.5), 0.5, Fraction(1, 10**80)) < 1e-12


def test_many_quantiles_at_once_where_scipys_is_lost():
    df = np.array([[1e-3, 0.4, 2.0], [1e300, 1e16, math.inf]])
    for tail in (Fraction(1, 40), Fraction(1, 10**20)):
        one_by_one = [[t_upper_quantile(tail, each) for each in row] for row in df.tolist()]
        assert t_upper_quantiles(tail, df) == pytest.approx(np.array(one_by_one), rel=1e-13)
