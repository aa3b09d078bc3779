"""Samples in numbers: one, two by Student's and Welch's t-tests, several ready for comparison.

Statistics are fractions until the end: each number of a result is rounded once. Several groups are scaled by one power
of two, which changes no digit and no ratio and keeps the fractions short.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import error_of, interval_text, number_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_count, as_groups, as_level, as_sample, complete_rows
from stats.exact.numbers import (
    Interval,
    Moments,
    Number,
    as_interval,
    deviations,
    exact_root,
    exact_sum,
    finite,
    finite_pair,
    interval_about,
    moments,
    to_120_bits,
    to_double,
)
from stats.exact.tails import exact_df, t_quantile, t_two_sided
from stats.results import Result, missing_text, with_unit

_NO_SCATTER = Undefined(Reason.NO_SCATTER)


@dataclass(frozen=True, slots=True)
class Summary(Result):
    """One sample in numbers, in the unit of its values."""

    n: int
    """Number of values."""
    mean: float | Undefined
    """Arithmetic mean, in the unit of the values."""
    sd: float | Undefined
    """Standard deviation with n - 1, in the unit of the values."""
    se: float | Undefined
    """Standard error of the mean, in the unit of the values."""
    ci_low: float | Undefined
    """Lower end of Student's interval for the mean, in the unit of the values."""
    ci_high: float | Undefined
    """Its upper end, in the unit of the values."""
    level: float
    """Level of the interval."""
    missing: int = 0
    """Values left out because they were NaN."""

    def sentence(self, name: str = "mean", unit: str = "") -> str:
        """Return the summary in words: mean, SD, interval, n."""
        if isinstance(self.mean, Undefined):
            return f"{name}: undefined, {self.mean.reason} (n = {self.n}{missing_text(self.missing)})."
        interval = as_interval(self.ci_low, self.ci_high)
        mean = number_text(self.mean, error=error_of(interval))
        return (
            f"{name} {mean}{with_unit(unit)} (SD {number_text(self.sd)}, "
            f"{interval_text(interval, self.level)}, n = {self.n}{missing_text(self.missing)})."
        )


def describe(values: ArrayLike, level: float = 0.95, missing: Missing = "refuse") -> Summary:
    """Describe one sample, shape (n,), of any unit; the interval is mean -/+ t(level, n - 1) * sd / sqrt(n).

    It is undefined where all values are equal: that they scatter by nothing is not what they show.
    Raises `InputRefused` for infinite or non-numeric values, and for NaN unless `missing` is "drop".

    >>> describe([42.1, 39.8, 44.0, 41.2]).sentence("joules", "J")
    'joules 41.8 J (SD 1.76, 95 % CI 39.0 to 44.6, n = 4).'
    """
    sample = as_sample("the sample", values, missing)
    level = as_level("level", level)
    n = sample.values.size
    if n == 0:
        none = Undefined(Reason.NO_VALUE)
        return Summary(0, none, none, none, none, none, level, sample.missing)
    about = moments(sample.values, sample.rest)
    if n < 2:
        one = Undefined(Reason.SINGLE_NO_SCATTER)
        return Summary(1, about.mean, one, one, one, one, level, sample.missing)
    sd, se = exact_root(about.exact_variance), exact_root(about.exact_variance / n)
    half = Fraction(t_quantile(level, n - 1)) * se
    ends = about.exact_mean - half, about.exact_mean + half
    low, high = (finite(end, "an end of the interval") if se else _NO_SCATTER for end in ends)
    return Summary(
        n,
        about.mean,
        finite(sd, "the standard deviation"),
        finite(se, "the standard error"),
        low,
        high,
        level,
        sample.missing,
    )


@dataclass(frozen=True, slots=True)
class Autocorrelation(Result):
    """How alike values are that lie so many places apart."""

    r: float | Undefined
    """Sum of products of deviations from the one mean, over the sum of their squares (NIST's definition); -1 to 1."""
    lag: int
    """How many places apart."""
    n: int
    """Number of values."""

    def sentence(self) -> str:
        """Return the autocorrelation in words."""
        if isinstance(self.r, Undefined):
            return f"No autocorrelation at lag {self.lag} (n = {self.n}): {self.r.reason}."
        return f"The autocorrelation at lag {self.lag} is {number_text(self.r)} (n = {self.n})."


def autocorrelation(values: ArrayLike, lag: int = 1) -> Autocorrelation:
    """Return the autocorrelation of a series, shape (n,), at a lag in samples.

    A value that is missing would be a gap in the series: NaN is refused, as infinite values are, and a lag that is no
    whole number of at least 0 (`InputRefused`).

    >>> autocorrelation([1, 2, 3, 4, 5]).r
    0.4
    """
    lag = as_count("the lag", lag)
    _without, gaps = complete_rows([values], "drop")
    if gaps:
        raise InputRefused(
            f"the series has gaps at {gaps} of {np.size(values)} places, and a lag counts places: give a stretch "
            "without gaps."
        )
    series = as_sample("the series", values)
    n = series.values.size
    if n <= lag:
        few = Undefined(Reason.TOO_SHORT_SERIES, n=n, lag=lag, needed=lag + 1)
        return Autocorrelation(few, lag, n)
    away, _exponent = deviations(exact_sum(series.values, series.rest) / n, series.values, series.rest)
    squares = math.fsum((away * away).tolist())
    if squares == 0.0:
        return Autocorrelation(Undefined(Reason.SERIES_CONSTANT), lag, n)
    return Autocorrelation(math.fsum((away[: n - lag] * away[lag:]).tolist()) / squares, lag, n)


Names = tuple[str, str]
AS_A_AND_B: Names = ("a", "b")
"""What two groups are called in reasons and sentences where their own names are not given."""


def pair_of_names(names: Names) -> Names:
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
        return _no_test(Undefined(Reason.TOO_FEW_POOLED, n_a=a.n, n_b=b.n))
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
        return _no_test(Undefined(Reason.GROUPS_WITHOUT_SCATTER))
    df = to_120_bits(exact_df([(part_a, a.n - 1), (part_b, b.n - 1)]))
    return t_test(a.exact_mean - b.exact_mean, total, df, level)


def too_small(a: Moments, b: Moments, names: Names = AS_A_AND_B) -> Undefined | None:
    """Return why a group has no variance, or None where both have one."""
    for name, group in zip(names, (a, b), strict=True):
        if group.n < 2:
            return Undefined(Reason.TOO_FEW_FOR_VARIANCE, group=f"group {name}", n=group.n)
    return None


def t_test(difference: Fraction, se_squared: Fraction, df: Fraction, level: Number) -> TTest:
    """Return the two-sided test of a difference with this squared standard error and degrees of freedom."""
    if se_squared == 0:
        return _no_test(Undefined(Reason.GROUPS_WITHOUT_SCATTER))
    se = exact_root(se_squared)
    t = to_120_bits(difference / se)
    tail = t_two_sided(t, df)
    interval = interval_about(difference, t_quantile(level, float(df)), se)
    return TTest(finite(t, "t"), float(df), tail.p, tail.log10_p, interval, finite(se, "the standard error"))


def _no_test(none: Undefined) -> TTest:
    return TTest(none, none, none, none, none, none)


def empty(a: Moments, names: Names = AS_A_AND_B) -> Undefined:
    """Return that the first group is empty, or else the second."""
    return Undefined(Reason.GROUP_EMPTY, group=f"group {names[0 if a.n == 0 else 1]}")


@dataclass(frozen=True, slots=True)
class Group(Moments):
    """One group in scaled units."""

    name: str


@dataclass(frozen=True, slots=True)
class Groups:
    """All groups that hold values, and what leads back to their unit."""

    filled: tuple[Group, ...]
    empty: tuple[str, ...]
    """Names of groups without a value."""
    exponent: int
    """Scaled numbers times 2**exponent are in the values' unit."""
    missing: int
    """How many values were left out as NaN."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the groups that hold values."""
        return tuple(group.name for group in self.filled)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Their numbers of values."""
        return tuple(group.n for group in self.filled)

    @property
    def means(self) -> tuple[float, ...]:
        """Their means in the values' unit."""
        return tuple(float(group.exact_mean * Fraction(2) ** self.exponent) for group in self.filled)

    @property
    def df_within(self) -> int:
        """Degrees of freedom of the scatter within all groups."""
        return sum(self.sizes) - len(self.filled)

    @property
    def squares_within(self) -> Fraction:
        """Sum of squares within all groups, in scaled units."""
        return sum((group.exact_sum_squares for group in self.filled), Fraction(0))

    def in_unit(self, scaled: Number, what: str = "the difference") -> float | Undefined:
        """Return a mean, a difference or a standard deviation in the values' unit, if doubles reach so far."""
        return finite(Fraction(scaled) * Fraction(2) ** self.exponent, what)

    def pair_in_unit(self, low: Fraction, high: Fraction) -> Interval | Undefined:
        """Return the ends of an interval in the values' unit, if doubles reach so far."""
        unit = Fraction(2) ** self.exponent
        return finite_pair(low * unit, high * unit)

    def in_squared_unit(self, scaled: Fraction) -> float | Undefined:
        """Return a sum of squares in the values' unit squared, if doubles reach so far."""
        found = to_double(scaled * Fraction(4) ** self.exponent)
        lost = math.isinf(found) or (found == 0.0 and scaled != 0)
        return Undefined(Reason.OUTSIDE_DOUBLES) if lost else found


def read_groups(samples: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse") -> Groups:
    """Check and summarise samples of shape (n_i,) in one unit; raises `InputRefused` naming the group."""
    checked = {name: as_sample(f"group {name!r}", values, missing) for name, values in as_groups(samples).items()}
    found = {name: moments(sample.values, sample.rest) for name, sample in checked.items() if sample.values.size}
    exponent = _exponent(list(found.values()))
    unit = Fraction(2) ** exponent
    return Groups(
        filled=tuple(_group(name, one, unit) for name, one in found.items()),
        empty=tuple(name for name in checked if name not in found),
        exponent=exponent,
        missing=sum(sample.missing for sample in checked.values()),
    )


def _exponent(found: list[Moments]) -> int:
    """Return e so that neither a scatter nor a distance between means is above 2**e by much; 0 where there are none."""
    squares = [one.exact_sum_squares for one in found]
    squares += [(one.exact_mean - found[0].exact_mean) ** 2 for one in found[1:]]
    largest = max(squares, default=Fraction(0))
    return (largest.numerator.bit_length() - largest.denominator.bit_length()) // 2 if largest else 0


def _group(name: str, one: Moments, unit: Fraction) -> Group:
    return Group(one.n, one.exact_mean / unit, one.exact_sum_squares / unit**2, name=name)
