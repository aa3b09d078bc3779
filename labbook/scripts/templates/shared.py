"""Errors that values share (docs/statistics.md, "The shared passive-drain error"): they do not average out."""

import math
from collections.abc import Sequence

from scipy import stats

from labbook.scripts.templates.runs import Number, Shared, Source

LEVEL = 0.95
"""Of the intervals."""
ENOUGH_DF = 4.0
"""Degrees of freedom of a fit from which its error counts as Welch and Satterthwaite have it."""


def quantile(level: float, df: float) -> float:
    """Return the half width of Student's two-sided interval in standard errors."""
    return float(stats.t.isf((1.0 - level) / 2.0, df))


def student(value: float, se: float, df: float) -> Number:
    """Return a value with its standard error and Student's interval."""
    half = quantile(LEVEL, df) * se
    return {"value": value, "se": se, "ci_low": value - half, "ci_high": value + half, "df": df}


def two_sided_p(t: float, df: float) -> float:
    """Return the chance of a t as far from 0 as this, to either side."""
    return 2.0 * float(stats.t.sf(abs(t), df))


def over_error(value: float, error: float) -> float:
    """Return t, a value over its standard error; infinite where there is none."""
    return value / error if error else math.copysign(math.inf, value)


def one_sided_tests(t_low: float, t_high: float, df: float) -> Number:
    """Return t and p of the tests against a lower and an upper bound, and the larger p; no bound rejects nothing."""
    p_low, p_high = float(stats.t.sf(t_low, df)), float(stats.t.cdf(t_high, df))
    return {"t_low": t_low, "p_low": p_low, "t_high": t_high, "p_high": p_high, "p": max(p_low, p_high)}


def satterthwaite_df(parts: Sequence[tuple[float, float]]) -> float:
    """Return the degrees of freedom of a sum of variances, each with its own (Welch 1938, Satterthwaite 1946)."""
    total = math.fsum(variance for variance, _df in parts)
    doubt = math.fsum((variance / total) ** 2 / df for variance, df in parts) if total > 0.0 else 0.0
    return 1.0 / doubt if doubt > 0.0 else math.inf


def weighted_sum(errors: Sequence[Shared], weights: Sequence[float]) -> Shared:
    """Return the shared errors of a weighted sum of values: the weighted sum of each source."""
    total: Shared = {}
    for error, weight in zip(errors, weights, strict=True):
        for source, size in error.items():
            total[source] = total.get(source, 0.0) + weight * size
    return total


def of_mean(errors: Sequence[Shared]) -> Shared:
    """Return the shared errors of a mean."""
    return weighted_sum(errors, [1.0 / len(errors)] * len(errors))


def shared_se(error: Shared) -> float:
    """Return the standard error of all sources together: they are independent."""
    return math.hypot(*error.values())


def shared_df(error: Shared) -> float:
    """Return the degrees of freedom of the fits behind an error, Satterthwaite's where they are several."""
    variances: dict[tuple[str, float], float] = {}
    for source, size in error.items():
        variances[source.fit, source.df] = variances.get((source.fit, source.df), 0.0) + size * size
    return satterthwaite_df([(variance, df) for (_fit, df), variance in variances.items()])


def weight_of(source: Source, level: float, df: float) -> float:
    """Return by how much a source counts beside a quantile of df: a fit of few degrees of freedom has its own."""
    return 1.0 if source.df >= ENOUGH_DF else (quantile(level, source.df) / quantile(level, df)) ** 2


def shared_covariance(one: Shared, other: Shared, level: float, df: float) -> float:
    """Return the covariance of two values by the errors that they share, as it counts beside a quantile of df."""
    return math.fsum(weight_of(source, level, df) * size * other.get(source, 0.0) for source, size in one.items())
