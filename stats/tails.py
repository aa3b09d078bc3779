"""Tail areas and quantiles of t and F, by `scipy.special`, which loads in a third of the time of `scipy.stats`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

from scipy import special


def t_two_sided(t: float, df: float) -> float:
    """Return P(|T| >= |t|) for Student's t with `df` degrees of freedom, which may be infinite."""
    return 2.0 * t_upper(abs(t), df)


def t_upper(t: float, df: float) -> float:
    """Return P(T >= t)."""
    return float(special.ndtr(-t) if math.isinf(df) else special.stdtr(df, -t))


def t_quantile(level: float, df: float) -> float:
    """Return the half width of a two-sided interval of the given level in standard errors (df may be infinite)."""
    return t_upper_quantile((1.0 - level) / 2.0, df)


@lru_cache(maxsize=1024)  # few levels and degrees of freedom are asked for again and again
def t_upper_quantile(tail: float, df: float) -> float:
    """Return the t that Student's t exceeds with chance `tail`."""
    return -float(special.ndtri(tail) if math.isinf(df) else special.stdtrit(df, tail))


def f_upper(f: float, df_numerator: float, df_denominator: float) -> float:
    """Return P(F >= f)."""
    return float(special.fdtrc(df_numerator, df_denominator, f))


def f_two_sided(f: float, df_numerator: float, df_denominator: float) -> float:
    """Return twice the smaller tail area of F, at most 1, as R's `var.test`; `f` is positive."""
    upper, lower = f_upper(f, df_numerator, df_denominator), f_upper(1.0 / f, df_denominator, df_numerator)
    return min(1.0, 2.0 * min(upper, lower))


def satterthwaite_df(parts: Sequence[tuple[float, float]]) -> float:
    """Return the degrees of freedom of a sum of independent (variance, degrees of freedom).

    Infinite where all is known exactly. Source: Welch (1938), Satterthwaite (1946).
    """
    total = math.fsum(variance for variance, _df in parts)
    doubt = math.fsum((variance / total) ** 2 / df for variance, df in parts) if total > 0.0 else 0.0
    return 1.0 / doubt if doubt > 0.0 else math.inf
