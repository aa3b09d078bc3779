"""Tail areas and quantiles of Student's t and Fisher's F, from scipy's special functions.

`scipy.special` loads in a tenth of the time of `scipy.stats`, and its tails keep their digits down to 1e-300. Its
quantile of t errs by up to 7e-13 (near 2 degrees of freedom); Newton's steps on the tail of `stats.tails` take it to
the last digit or its neighbour.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

from scipy import special

from stats.finite import Number
from stats.tails import t_excess

_MOST_STEPS = 4
_NEAR = 1e-9
"""A step of this share of the quantile leaves an error of its square."""


def t_two_sided_p(t: float, df: float) -> float:
    """Return P(|T| >= |t|) for Student's t with `df` degrees of freedom, which need not be whole."""
    return min(1.0, 2.0 * float(special.stdtr(df, -abs(t))))


def t_quantile(level: float, df: float) -> float:
    """Return the half width of a two-sided interval of the given level in standard errors (df may be infinite)."""
    return t_upper_quantile((1 - Fraction(level)) / 2, df)


@lru_cache(maxsize=4096)
def t_upper_quantile(tail: Number, df: float) -> float:
    """Return the t that Student's t exceeds with chance `tail`, between 0 and 1 (df may be infinite)."""
    if tail > 0.5:
        return -t_upper_quantile(1 - Fraction(tail), df)
    near, both = float(tail), 2 * Fraction(tail)
    t = -float(special.ndtri(near) if math.isinf(df) else special.stdtrit(df, near))
    for _ in range(_MOST_STEPS):
        slope = 2.0 * t * _t_density(t, df) if 0.0 < t < math.inf else 0.0
        if slope == 0.0:
            return t
        # In logarithms of both, as tails are powers of t far out.
        excess = t_excess(t, df, both)
        step = math.expm1(math.log1p(excess / float(both)) * (float(both) + excess) / slope)
        t += step * t
        if abs(step) <= _NEAR:
            return t
    return t


def _t_density(t: float, df: float) -> float:
    if math.isinf(df):
        return math.exp(-t * t / 2.0) / math.sqrt(2.0 * math.pi)
    at_middle = math.exp(math.lgamma((df + 1.0) / 2.0) - math.lgamma(df / 2.0)) / math.sqrt(math.pi * df)
    return at_middle * math.exp(-(df + 1.0) / 2.0 * math.log1p(t * t / df))


def f_upper_p(f: float, df_between: float, df_within: float) -> float:
    """Return P(F >= f)."""
    return float(special.fdtrc(df_between, df_within, f))


def f_two_sided_p(f: float, df_numerator: float, df_denominator: float) -> float:
    """Return twice the smaller tail area of F, at most 1 (as R's `var.test`)."""
    upper = float(special.fdtrc(df_numerator, df_denominator, f))
    lower = float(special.fdtr(df_numerator, df_denominator, f))
    return min(1.0, 2.0 * min(upper, lower))
