"""Several groups made ready for comparison: exact moments, scaled by one power of two.

Means and sums of squares stay fractions until a statistic is asked for, which is rounded once. All are in units of
2**exponent, which changes no digit and no ratio and keeps the fractions short.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from numpy.typing import ArrayLike

from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_groups, as_sample
from stats.exact.finite import Interval, Number, finite, finite_pair, to_double
from stats.exact.sums import ExactMoments, Moments, moments


@dataclass(frozen=True, slots=True)
class Group(ExactMoments):
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
        return Undefined("it lies outside the range of doubles") if lost else found


def read_groups(samples: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse") -> Groups:
    """Check and summarise samples of shape (n_i,) in one unit; raises `InputRefused` naming the group."""
    checked = {name: as_sample(f"group {name!r}", values, missing) for name, values in as_groups(samples).items()}
    found = {name: moments(sample.values, rest=sample.rest) for name, sample in checked.items() if sample.values.size}
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
