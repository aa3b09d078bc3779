"""Student's and Welch's t-test of two groups, from their moments.

Statistics are fractions until the end: t and p are each rounded once. So are the interval's ends, but for Student's
quantile in them, which is the nearest double or its neighbour (`stats.exact.distributions`).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.exact.distributions import exact_df, t_quantile
from stats.exact.error_free import exact_root, shortened
from stats.exact.finite import Number, finite, interval_about
from stats.exact.sums import Moments
from stats.exact.tails import t_two_sided

Interval = tuple[float, float]
Names = tuple[str, str]
AS_A_AND_B: Names = ("a", "b")
"""What two groups are called in reasons and sentences where their own names are not given."""


def two_names(names: Names) -> Names:
    """Return the names of two groups; raises `InputRefused` where they are not two texts."""
    if isinstance(names, str) or len(names) != 2 or not all(isinstance(name, str) for name in names):
        raise InputRefused(f"names is {names!r}: give the names of both groups, as ('control', 'treated').")
    return names[0], names[1]


@dataclass(frozen=True, slots=True)
class TTest:
    """A two-sided t-test of a difference; the interval is in the unit of the values."""

    t: float | Undefined
    df: float | Undefined
    p: float | Undefined
    log10_p: float | Undefined
    """Decimal logarithm of p, right where p itself is too small for a double."""
    ci: Interval | Undefined
    se: float | Undefined
    """Standard error of the difference."""


def student(a: Moments, b: Moments, level: Number = 0.95, names: Names = AS_A_AND_B) -> TTest:
    """Return Student's test of mean(a) - mean(b), with one variance pooled from both groups."""
    df = a.n + b.n - 2
    if a.n == 0 or b.n == 0:
        return _no_test(empty(a, names))
    if df < 1:
        return _no_test(f"there are {a.n} and {b.n} values and the pooled variance needs at least 3 in all")
    pooled = (a.exact_sum_squares + b.exact_sum_squares) / df
    return t_test(a.exact_mean - b.exact_mean, pooled * (Fraction(1, a.n) + Fraction(1, b.n)), Fraction(df), level)


def welch(a: Moments, b: Moments, level: Number = 0.95, names: Names = AS_A_AND_B) -> TTest:
    """Return Welch's test of mean(a) - mean(b), with Welch and Satterthwaite's degrees of freedom."""
    if a.n == 0 or b.n == 0:
        return _no_test(empty(a, names))
    small = too_small(a, b, names)
    if small is not None:
        return _no_test(small)
    part_a, part_b = a.exact_mean_variance, b.exact_mean_variance
    total = part_a + part_b
    if total == 0:
        return _no_test("neither group has any scatter")
    df = shortened(exact_df([(part_a, a.n - 1), (part_b, b.n - 1)]))
    return t_test(a.exact_mean - b.exact_mean, total, df, level)


def too_small(a: Moments, b: Moments, names: Names = AS_A_AND_B) -> str | None:
    """Return why a group has no variance, or None where both have one."""
    for name, group in zip(names, (a, b), strict=True):
        if group.n < 2:
            return f"group {name} has {group.n} value{'' if group.n == 1 else 's'} and its variance needs at least 2"
    return None


def t_test(difference: Fraction, se_squared: Fraction, df: Fraction, level: Number) -> TTest:
    """Return the two-sided test of a difference with this squared standard error and degrees of freedom."""
    if se_squared == 0:
        return _no_test("neither group has any scatter")
    se = exact_root(se_squared)
    t = shortened(difference / se)
    tail = t_two_sided(t, df)
    interval = interval_about(difference, t_quantile(level, float(df)), se)
    return TTest(finite(t, "t"), float(df), tail.p, tail.log10_p, interval, finite(se, "the standard error"))


def _no_test(reason: str) -> TTest:
    none = Undefined(reason)
    return TTest(none, none, none, none, none, none)


def empty(a: Moments, names: Names = AS_A_AND_B) -> str:
    """Return that the first group is empty, or else the second."""
    return f"group {names[0 if a.n == 0 else 1]} is empty"
