"""How samples scatter, in floats: centred about their grand mean and scaled first, so that neither an offset of 1e9 nor
values of 1e300 or 1e-300 cost digits, and a group whose values are all equal has a scatter of exactly 0.

Tests divide by a scatter; one of 0 makes p from 0/0 in other programs, and is `Undefined` here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import Missing, Samples, as_groups, as_sample

Floats = NDArray[np.float64]
Interval = tuple[float, float]
Value: TypeAlias = float | Undefined
"""A number, or the reason why there is none."""


def finite(value: float, what: str) -> Value:
    """Return a number, or that it is beyond the doubles; `what` names it."""
    return float(value) if math.isfinite(value) else Undefined(Reason.BEYOND_DOUBLES, what=what)


def as_interval(low: Value, high: Value) -> Interval | Undefined:
    """Return two ends as an interval, or why one of them is undefined."""
    if isinstance(low, Undefined):
        return low
    return high if isinstance(high, Undefined) else (low, high)


def times_power(value: float, exponent: int) -> float:
    """Return value * 2**exponent; infinite where there is no double that large."""
    try:
        return math.ldexp(value, exponent)
    except OverflowError:
        return math.copysign(math.inf, value)


@dataclass(frozen=True, slots=True)
class Scale:
    """Values less a middle of theirs, in units of a power of two of about their largest distance from it."""

    middle: float
    exponent: int

    def scaled(self, values: Floats) -> Floats:
        """Return values in this scale: at most about 1 away from 0."""
        if self.exponent <= _LARGEST_EXPONENT:
            return np.asarray(np.ldexp(values - self.middle, -self.exponent))
        shift = self.exponent - _LARGEST_EXPONENT  # or the difference of two huge values would overflow
        difference = np.ldexp(values, -shift) - math.ldexp(self.middle, -shift)
        return np.asarray(np.ldexp(difference, shift - self.exponent))

    @property
    def offset(self) -> float:
        """The middle in this scale; infinite where values differ by nothing that doubles tell from 0 beside it."""
        return times_power(self.middle, -self.exponent)

    def place(self, scaled: float) -> float:
        """Return a mean in the unit of the values."""
        if self.exponent <= _LARGEST_EXPONENT:
            return self.middle + times_power(scaled, self.exponent)
        return times_power(self.offset + scaled, self.exponent)

    def length(self, scaled: float, what: str = "the difference") -> Value:
        """Return a difference or a standard deviation in the unit of the values, where doubles reach so far."""
        return finite(times_power(scaled, self.exponent), what)

    def interval(self, low: float, high: float) -> Interval | Undefined:
        """Return an interval of a difference in the unit of the values, where doubles reach so far."""
        low, high = times_power(low, self.exponent), times_power(high, self.exponent)
        return (low, high) if math.isfinite(low + high) else Undefined(Reason.END_BEYOND_DOUBLES)


_LARGEST_EXPONENT = 1000


def scale_of(*samples: Floats) -> Scale:
    """Return the scale of finite samples in one unit, shapes (n_i,): about their grand mean."""
    values = np.concatenate(samples) if samples else np.empty(0)
    if not values.size:
        return Scale(0.0, 0)
    largest = math.frexp(float(np.abs(values).max()))[1]
    middle = times_power(float(np.ldexp(values, -largest).sum()) / values.size, largest)
    away = float(np.abs(np.ldexp(values, -1) - middle / 2.0).max())
    return Scale(middle, math.frexp(away)[1] + 1 if away else 0)


def mean_of(values: Floats) -> float:
    """Return the mean of finite values, shape (n,), n at least 1, rounded once."""
    try:
        return math.fsum(values.tolist()) / values.size
    except OverflowError:
        return 4.0 * (math.fsum(np.ldexp(values, -2).tolist()) / values.size)


@dataclass(frozen=True, slots=True)
class Group:
    """One sample in a scale: its mean, and the sum of squares about it, exactly 0 where all values are equal."""

    name: str
    n: int
    mean: float
    squares: float

    @property
    def constant(self) -> bool:
        """Whether all values are equal."""
        return self.squares == 0.0

    @property
    def variance(self) -> float:
        """Sample variance, for n of at least 2."""
        return self.squares / (self.n - 1)

    @property
    def mean_variance(self) -> float:
        """Squared standard error of the mean, for n of at least 2."""
        return self.squares / (self.n - 1) / self.n


def group_of(name: str, scaled: Floats) -> Group:
    """Return the mean and the squares about it of values in a scale, shape (n,), n at least 1."""
    if float(scaled.min()) == float(scaled.max()):  # the rounded mean of equal values may be another number
        return Group(name, scaled.size, float(scaled[0]), 0.0)
    mean = float(scaled.sum()) / scaled.size
    away = scaled - mean
    squares = float(away @ away) - float(away.sum()) ** 2 / scaled.size
    return Group(name, scaled.size, mean, squares)


@dataclass(frozen=True, slots=True)
class Groups:
    """All groups in one scale; empty ones stand apart."""

    filled: tuple[Group, ...]
    empty: tuple[str, ...]
    """Names of groups without a value."""
    means: tuple[float, ...]
    """Means of the filled groups in the unit of the values."""
    scale: Scale
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
    def df_within(self) -> int:
        """Degrees of freedom of the scatter within all groups."""
        return sum(self.sizes) - len(self.filled)

    @property
    def squares_within(self) -> float:
        """Sum of squares within all groups, in the scale."""
        return math.fsum(group.squares for group in self.filled)

    @property
    def squares_between(self) -> float:
        """Sum of squares between the groups, in the scale."""
        grand = math.fsum(group.n * group.mean for group in self.filled) / sum(self.sizes)
        return math.fsum(group.n * (group.mean - grand) ** 2 for group in self.filled)

    def in_squared_unit(self, scaled: float) -> Value:
        """Return a sum of squares in the values' unit squared, where doubles reach so far."""
        found = times_power(scaled, 2 * self.scale.exponent)
        lost = math.isinf(found) or (found == 0.0 and scaled != 0.0)
        return Undefined(Reason.OUTSIDE_DOUBLES) if lost else found


def read_groups(samples: Samples, missing: Missing = "refuse") -> Groups:
    """Check samples of shape (n_i,) in one unit and put them into one scale.

    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop".
    """
    checked = {name: as_sample(f"group {name!r}", values, missing) for name, values in as_groups(samples).items()}
    filled = {name: sample.values for name, sample in checked.items() if sample.values.size}
    scale = scale_of(*filled.values())
    return Groups(
        filled=tuple(group_of(name, scale.scaled(values)) for name, values in filled.items()),
        empty=tuple(name for name in checked if name not in filled),
        means=tuple(map(mean_of, filled.values())),
        scale=scale,
        missing=sum(sample.missing for sample in checked.values()),
    )
