"""Samples in numbers: mean and scatter of one, autocorrelation of a series, two by Student's and Welch's t-tests."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_values
from stats.results import Result
from stats.scatter import Group, Interval, Scale, Value, finite, group_of, mean_of, scale_of
from stats.tails import satterthwaite_df, t_quantile, t_two_sided

_NO_SCATTER = Undefined(Reason.NO_SCATTER)


@dataclass(frozen=True, slots=True)
class Summary(Result):
    """One sample in numbers, in the unit of its values."""

    n: int
    """Number of values."""
    mean: Value
    """Arithmetic mean, in the unit of the values."""
    sd: Value
    """Standard deviation with n - 1, in the unit of the values."""
    se: Value
    """Standard error of the mean, in the unit of the values."""
    ci_low: Value
    """Lower end of Student's interval for the mean, in the unit of the values."""
    ci_high: Value
    """Its upper end, in the unit of the values."""
    level: float
    """Level of the interval."""


def describe(values: ArrayLike, level: float = 0.95) -> Summary:
    """Describe one sample, shape (n,), of any unit; the interval is mean -/+ t(level, n - 1) * sd / sqrt(n).

    It is undefined where all values are equal: that they scatter by nothing is not what they show.
    Raises `InputRefused` for values that are missing, infinite or no numbers.

    >>> round(describe([42.1, 39.8, 44.0, 41.2]).mean, 3)
    41.775
    """
    values, level = as_values("the sample", values), as_level("level", level)
    n = values.size
    if n == 0:
        none = Undefined(Reason.NO_VALUE)
        return Summary(0, none, none, none, none, none, level)
    scale = scale_of(values)
    group = group_of("", scale.scaled(values))
    mean = mean_of(values)
    if n < 2:
        one = Undefined(Reason.SINGLE_NO_SCATTER)
        return Summary(1, mean, one, one, one, one, level)
    sd, se = scale.length(math.sqrt(group.variance), "the standard deviation"), math.sqrt(group.mean_variance)
    half = t_quantile(level, n - 1) * se
    low, high = (
        _NO_SCATTER if group.constant else finite(scale.place(group.mean + side * half), "an end of the interval")
        for side in (-1.0, 1.0)
    )
    return Summary(n, mean, sd, scale.length(se, "the standard error"), low, high, level)


def autocorrelation(values: ArrayLike) -> Value:
    """Return how alike neighbours of a series, shape (n,), are: -1 to 1, NIST's definition.

    It is the sum of products of their deviations from the one mean, over the sum of the squares. Raises `InputRefused`
    for values that are missing or infinite: a lag counts places.

    >>> autocorrelation([1, 2, 3, 4, 5])
    0.4
    """
    series = as_values("the series", values)
    if series.size < 2:
        return Undefined(Reason.TOO_SHORT_SERIES, n=series.size, lag=1, needed=2)
    if float(series.min()) == float(series.max()):
        return Undefined(Reason.SERIES_CONSTANT)
    away = scale_of(series).scaled(series)
    away = away - away.mean()
    return float(away[:-1] @ away[1:]) / float(away @ away)


Names = tuple[str, str]
AS_A_AND_B: Names = ("a", "b")
"""What two groups are called in reasons and sentences where their own names are not given."""


@dataclass(frozen=True, slots=True)
class TTest:
    """A two-sided t-test of a difference; the interval is in the unit of the values."""

    t: Value
    df: Value
    p: Value
    ci: Interval | Undefined
    se: Value
    """Standard error of the difference."""


def student(a: Group, b: Group, scale: Scale, level: float = 0.95) -> TTest:
    """Return Student's test of mean(a) - mean(b), with one variance pooled from both groups."""
    df = a.n + b.n - 2
    if df < 1:
        return _no_test(Undefined(Reason.TOO_FEW_POOLED, n_a=a.n, n_b=b.n))
    pooled = (a.squares + b.squares) / df
    return _t_test(a.mean - b.mean, pooled * (1.0 / a.n + 1.0 / b.n), float(df), scale, level)


def welch(a: Group, b: Group, scale: Scale, level: float = 0.95) -> TTest:
    """Return Welch's test of mean(a) - mean(b), with Welch and Satterthwaite's degrees of freedom."""
    for group in (a, b):
        if group.n < 2:
            return _no_test(Undefined(Reason.TOO_FEW_FOR_VARIANCE, group=f"group {group.name}", n=group.n))
    parts = [(group.mean_variance, group.n - 1.0) for group in (a, b)]
    return _t_test(a.mean - b.mean, a.mean_variance + b.mean_variance, satterthwaite_df(parts), scale, level)


def _t_test(difference: float, se_squared: float, df: float, scale: Scale, level: float) -> TTest:
    """Return the two-sided test of a scaled difference with this squared standard error and degrees of freedom."""
    if se_squared == 0.0:
        return _no_test(Undefined(Reason.GROUPS_WITHOUT_SCATTER))
    se = math.sqrt(se_squared)
    t, half = difference / se, t_quantile(level, df) * se
    interval = scale.interval(difference - half, difference + half)
    return TTest(t, df, t_two_sided(t, df), interval, scale.length(se, "the standard error"))


def _no_test(none: Undefined) -> TTest:
    return TTest(none, none, none, none, none)


def robust_z(values: Sequence[float], least: float = 0.0) -> list[float]:
    """Return how far each value lies from the median, in standard deviations that outliers do not move.

    The deviation is 1.4826 times the median distance from the median, in the unit of the values, and at least `least`;
    where it is 0, so are all. Source: Iglewicz and Hoaglin (1993), How to Detect and Handle Outliers.

    >>> robust_z([1.0, 2.0, 3.0, 4.0, 12.0])[-1] > 3.5
    True
    """
    if not values:
        return []
    middle = statistics.median(values)
    scale = max(1.4826 * statistics.median(abs(value - middle) for value in values), least)
    return [(value - middle) / scale if scale > 0.0 else 0.0 for value in values]
