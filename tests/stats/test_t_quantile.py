"""Student's quantile against 50 digits: the nearest double or one of its neighbours."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from scipy import special

from stats.distributions import t_quantile, t_upper_quantile

LEVELS = [0.5, 0.6, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 0.9999]


def distance(found: float, df: float, tail: Fraction) -> float:
    """Relative distance from the quantile of the upper tail: one step of Newton's from there."""
    with mpmath.workdps(50):
        t, wanted = mpmath.mpf(found), mpmath.mpf(tail.numerator) / tail.denominator
        if math.isinf(df):
            upper, density = mpmath.erfc(t / mpmath.sqrt(2)) / 2, mpmath.npdf(t)
        else:
            df = mpmath.mpf(df)
            upper = mpmath.betainc(df / 2, 0.5, 0, df / (df + t * t), regularized=True) / 2
            density = (1 + t * t / df) ** (-(df + 1) / 2) / (mpmath.sqrt(df) * mpmath.beta(df / 2, 0.5))
        return abs(float((upper - wanted) / density / t))


@pytest.mark.parametrize("level", LEVELS)
def test_the_last_digit_is_right_or_next_to_it(level):
    rng = np.random.default_rng(round(1e4 * level))
    dfs = [0.5, 0.7, 1.0, 1.999999, 2.0, 2.0000001, 2.01, 3.0, 6.0, 30.0, 1e3, 1e6, math.inf]
    for df in [*dfs, *np.exp(rng.uniform(math.log(0.5), math.log(1e6), 25)).tolist()]:
        assert distance(t_quantile(level, df), df, (1 - Fraction(level)) / 2) < 3.4e-16, df


def test_where_scipys_quantile_is_13_digits_right():
    level, df = 0.5450456642594668, 2.0092342114836432
    tail = (1 - Fraction(level)) / 2
    assert distance(-float(special.stdtrit(df, float(tail))), df, tail) > 1e-14
    assert distance(t_quantile(level, df), df, tail) < 3.4e-16


@pytest.mark.parametrize("tail", [1e-100, 1e-20, 0.05, 0.3])
@pytest.mark.parametrize("df", [1.5, 8.0, 40.5, math.inf])
def test_tails_of_one_side(tail, df):
    found = t_upper_quantile(tail, df)
    assert distance(found, df, Fraction(tail)) < 3.4e-16
    assert t_upper_quantile(1 - Fraction(tail), df) == -found


def test_the_middle():
    assert t_upper_quantile(0.5, 7.0) == 0.0
    assert distance(t_quantile(1e-9, 7.0), 7.0, (1 - Fraction(1e-9)) / 2) < 3.4e-16
