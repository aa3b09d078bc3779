"""Tail areas and quantiles of Student's t and Fisher's F, from scipy's special functions.

`scipy.special` loads in a tenth of the time of `scipy.stats`, and its tails keep their digits down to 1e-300. Its
quantile of t errs by up to 7e-13 (near 2 degrees of freedom) and is lost for the farthest tails and the fewest degrees
of freedom; Newton's steps on the tail of `stats.exact.tails` take it to the last digit or its neighbour. The p of a
regression are scipy's, to 12 digits or more: those of `exact.tails` would make a fit of 25 values take twice as long.

A sum of independent estimated variances has (sum of v_i)^2 / sum of (v_i^2 / df_i) degrees of freedom (Welch 1938,
Satterthwaite 1946): those of the chi-squared whose multiple has the sum's mean and variance. One
formula in three arithmetics. Doubles square shares of the sum, so that nothing overflows once the sum is a double, and
a share whose square is no double adds nothing.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache

import numpy as np
from scipy import special

from stats.exact.finite import Number, to_double
from stats.exact.quadrature import Floats
from stats.exact.tails import t_log_ratio

_MOST_STEPS = 100
_LONGEST = 20.0
"""Longest step, in the logarithm of t."""
_NEAR = 1e-9
"""A step of this share of the quantile leaves an error of its square."""
_USUAL_TAIL, _USUAL_DF = Fraction(1, 10**100), (0.5, 1e6)
"""Where scipy's quantile is a good start: beyond it is infinite, no number, or as good as any."""
_DIGITS_LOST = 1e-4
_LINEAR = Fraction(1, 2**64)
_FEW = 1e-8
"""Degrees of freedom from which the density is flat where the middle holds a chance of 2^-64."""
_MIDDLE = 1e-3
_POWER_LAW_TO = 3.0
_MANY = 1e5
"""Degrees of freedom from which the density at 0 is the normal's but for 1/df: the next term is below 1e-15."""


def t_two_sided_p(t: float, df: float) -> float:
    """Return P(|T| >= |t|) for Student's t with `df` degrees of freedom, which need not be whole."""
    return min(1.0, 2.0 * float(special.stdtr(df, -abs(t))))


def complement_level(alpha: float) -> Number:
    """Return 1 - alpha: as the double that is shown, or where that loses digits of alpha as a fraction."""
    return 1.0 - alpha if alpha > _DIGITS_LOST else 1 - Fraction(alpha)


def t_quantile(level: Number, df: float) -> float:
    """Return the half width of a two-sided interval of the given level in standard errors (df may be infinite).

    Infinite where it is too large for a double.
    """
    return t_upper_quantile((1 - Fraction(level)) / 2, df)


@lru_cache(maxsize=4096)
def t_upper_quantile(tail: Number, df: float) -> float:
    """Return the t that Student's t exceeds with chance `tail`, between 0 and 1 (df may be infinite).

    Infinite where it is too large for a double.
    """
    exact = Fraction(tail)
    if 2 * exact > 1:
        return -t_upper_quantile(1 - exact, df)
    both, middle = 2 * exact, 1 - 2 * exact
    if both == 0 or df == 0.0:
        return math.inf
    if middle == 0:
        return 0.0
    if middle < _LINEAR:
        if df < _FEW:
            return _exp(_start(both, df))
        # The density is flat there: twice it times t is the chance of the middle.
        return float(Fraction(t_upper_quantile((1 - _LINEAR) / 2, df)) * middle / _LINEAR)
    usual = exact >= _USUAL_TAIL and _USUAL_DF[0] <= df <= _USUAL_DF[1]
    t = -float(special.stdtrit(df, float(exact))) if usual else 0.0
    return _refined(t if 0.0 < t < math.inf else _exp(_start(both, df)), both, df)


def _refined(t: float, both: Fraction, df: float) -> float:
    """Return the t with these two tails by Newton's steps from near it.

    In logarithms of both t and its tails, which are powers of t far out: the tails are concave there, so that steps
    lead down to the quantile from above it, and from below it beyond it once.
    """
    low, high = 0.0, math.inf
    log_both = _log(both)
    for _ in range(_MOST_STEPS):
        t = min(max(t, sys.float_info.min), sys.float_info.max)
        ratio = t_log_ratio(t, df, both)
        if ratio > 0.0:
            low = t
            if t == sys.float_info.max:
                return math.inf
        else:
            high = t
        log_slope = math.log(2.0) + math.log(t) + _t_log_density(t, df) - log_both - ratio
        step = math.expm1(min(max(ratio * _exp(-log_slope), -_LONGEST), _LONGEST))
        if abs(step) <= _NEAR:
            return t + step * t
        t += step * t
        if not low < t < high:
            t = math.sqrt(low) * math.sqrt(high)
    return t


def _start(both: Fraction, df: float) -> float:
    """Return nearly the logarithm of the t with these two tails."""
    log_both, middle = _log(both), float(1 - both)
    if df < 1.0:  # t = sqrt(df) sinh(-log_both / df) for few degrees of freedom
        away = to_double(Fraction(-log_both) / Fraction(df))
        return 0.5 * math.log(df) + (away - math.log(2.0) if away > 20.0 else math.log(math.sinh(away)))
    if middle < _MIDDLE:
        return math.log(middle / 2.0) - _t_log_density(0.0, df)
    if df < _POWER_LAW_TO:
        log_beta = -_t_log_density(0.0, df) - 0.5 * math.log(df)
        return 0.5 * math.log(df) + (math.log(2.0 / df) - log_beta - log_both) / df
    z_squared = float(special.ndtri_exp(log_both - math.log(2.0))) ** 2
    if math.isinf(df):
        return 0.5 * math.log(z_squared)
    share = z_squared / (df - 0.5)  # Hill 1970, algorithm 396, the first of his terms
    return 0.5 * (math.log(df) + (share if share > 40.0 else math.log(math.expm1(share))))


def _t_log_density(t: float, df: float) -> float:
    if df > _MANY:
        at_middle = -0.5 * math.log(2.0 * math.pi) - 0.25 / df
    else:
        at_middle = math.lgamma((df + 1.0) / 2.0) - math.lgamma(df / 2.0) - 0.5 * math.log(math.pi * df)
    if math.isinf(df):
        return at_middle - 0.5 * t * t
    log_odds = 2.0 * math.log(t) - math.log(df) if t > 0.0 else -math.inf
    return at_middle - (df + 1.0) / 2.0 * (log_odds if log_odds > 40.0 else math.log1p(math.exp(log_odds)))


def _log(share: Fraction) -> float:
    """Return the logarithm of a number between 0 and 1, which may be nearer to either than doubles are."""
    if 2 * share > 1:
        return math.log1p(-float(1 - share))
    return math.log(share.numerator) - math.log(share.denominator)


def _exp(exponent: float) -> float:
    try:
        return math.exp(exponent)
    except OverflowError:
        return math.inf


def f_upper_p(f: float, df_between: float, df_within: float) -> float:
    """Return P(F >= f)."""
    return float(special.fdtrc(df_between, df_within, f))


def exact_df(parts: Sequence[tuple[Fraction, int]]) -> Fraction:
    """Return those of (variance, degrees of freedom) of any sizes, not all variances 0, without any rounding."""
    total = sum((variance for variance, _df in parts), Fraction(0))
    doubt = sum((variance**2 / df for variance, df in parts), Fraction(0))
    return total**2 / doubt


def df_of_doubles(parts: Sequence[tuple[float, float]]) -> float:
    """Return those of (variance, degrees of freedom); infinite where all is known exactly."""
    total = math.fsum(variance for variance, _df in parts)
    doubt = math.fsum((variance / total) ** 2 / df for variance, df in parts) if total > 0.0 else 0.0
    return 1.0 / doubt if doubt > 0.0 else math.inf


def df_of_arrays(part_a: Floats, part_b: Floats, df_a: float, df_b: float) -> Floats:
    """Return those of many pairs of variances at once, of the shape of the parts; no pair is 0 twice."""
    both = part_a + part_b
    return np.asarray(1.0 / ((part_a / both) ** 2 / df_a + (part_b / both) ** 2 / df_b))
