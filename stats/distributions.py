"""Tail areas and quantiles of Student's t and Fisher's F, from scipy's special functions.

`scipy.special` loads in a tenth of the time of `scipy.stats`, and its tails keep their digits down to 1e-300.
"""

from __future__ import annotations

from scipy import special


def t_two_sided_p(t: float, df: float) -> float:
    """Return P(|T| >= |t|) for Student's t with `df` degrees of freedom, which need not be whole."""
    return min(1.0, 2.0 * float(special.stdtr(df, -abs(t))))


def t_quantile(level: float, df: float) -> float:
    """Return the half width of a two-sided interval of the given level in standard errors (df may be infinite)."""
    tail = (1.0 - level) / 2.0
    if df == float("inf"):
        return -float(special.ndtri(tail))
    return -float(special.stdtrit(df, tail))


def f_upper_p(f: float, df_between: float, df_within: float) -> float:
    """Return P(F >= f)."""
    return float(special.fdtrc(df_between, df_within, f))


def f_two_sided_p(f: float, df_numerator: float, df_denominator: float) -> float:
    """Return twice the smaller tail area of F, at most 1 (as R's `var.test`)."""
    upper = float(special.fdtrc(df_numerator, df_denominator, f))
    lower = float(special.fdtr(df_numerator, df_denominator, f))
    return min(1.0, 2.0 * min(upper, lower))
