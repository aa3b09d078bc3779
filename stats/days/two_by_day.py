"""Two groups whose values belong to days: what comparisons within days are made of.

The difference of means within days is weighted as least squares with day effects weights it, n_a n_b / (n_a + n_b) for
each day; without days it is the difference of means.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import Labels, Missing, Sample, as_labels, as_sample, complete_rows
from stats.exact.numbers import common_shift, exact_sum, finite, greatest, out_of_range, times_power
from stats.results import counted

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Stratum:
    """The values of both groups on one day, each in ascending order."""

    a: Floats
    b: Floats

    @property
    def weight(self) -> float:
        """Weight of the day's difference."""
        return self.a.size * self.b.size / (self.a.size + self.b.size)


@dataclass(frozen=True, slots=True)
class Cell:
    """The values of one group on one day about their mean."""

    values: Floats
    weight: float
    """Of their mean in the difference; negative for group b."""
    name: str
    """"a" or "b"."""


@dataclass(frozen=True, slots=True)
class TwoByDay:
    """Both groups by day, and what was given."""

    strata: tuple[Stratum, ...]
    """Days that hold both groups, in an order that their labels do not decide; in units of 2**exponent."""
    exponent: int
    """0 but where differences of the values could overflow or lose bits."""
    exact_difference: Fraction
    """a minus b within days, in the unit of the values; 0 where no day holds both groups."""
    n_a: int
    n_b: int
    n_days: int | Undefined
    missing: int
    """Values left out because they or their day were missing."""

    @property
    def unused_a(self) -> int:
        """Number of values of group a on days that hold no value of group b: they enter nothing."""
        return self.n_a - sum(each.a.size for each in self.strata)

    @property
    def unused_b(self) -> int:
        """Number of values of group b on days that hold no value of group a: they enter nothing."""
        return self.n_b - sum(each.b.size for each in self.strata)

    @property
    def difference(self) -> float | Undefined:
        """a minus b within days in the unit of the values, if doubles reach so far."""
        return finite(self.exact_difference, "the difference")

    def in_unit(self, scaled: float, what: str = "the difference") -> float | Undefined:
        """Return a difference in the unit of the values, if doubles reach so far."""
        return finite(times_power(scaled, self.exponent), what)

    def centred_cells(self) -> tuple[list[Cell], int]:
        """Return the values about the means of their day and group, and the power of two they are multiples of."""
        total = math.fsum(each.weight for each in self.strata)
        cells = []
        for each in self.strata:
            for name, values, sign in (("a", each.a, 1.0), ("b", each.b, -1.0)):
                shifted = values - values[0]
                exponent = math.frexp(greatest(shifted))[1]
                shifted = np.ldexp(shifted, -exponent)
                about = np.ldexp(shifted - math.fsum(shifted) / shifted.size, exponent)
                cells.append(Cell(about, sign * each.weight / total, name))
        exponent = math.frexp(max(greatest(cell.values) for cell in cells))[1]
        return [Cell(np.ldexp(cell.values, -exponent), cell.weight, cell.name) for cell in cells], exponent

    def nothing_shared(self) -> Undefined:
        """Return why there is no day to compare within."""
        if self.n_a == 0 or self.n_b == 0:
            return Undefined(Reason.GROUP_EMPTY, group=f"group {'a' if self.n_a == 0 else 'b'}")
        return Undefined(Reason.NO_SHARED_DAY)


def two_by_day(
    a: ArrayLike, b: ArrayLike, day_a: Labels | None, day_b: Labels | None, missing: Missing = "refuse"
) -> TwoByDay:
    """Return groups of shapes (n_a,) and (n_b,) by the labels of their days, one for each value, or all as one day.

    Raises `InputRefused` for infinite values, for labels of another length or of one group only, and, unless `missing`
    is "drop", for values or days that are missing.
    """
    if (day_a is None) != (day_b is None):
        raise InputRefused("days are given for one group only: give them for both or for none.")
    samples, days, left_out = [], [], 0
    for name, values, labels in (("a", a, day_a), ("b", b, day_b)):
        columns = [values] if labels is None else [values, as_labels(f"day_{name}", labels, missing)]
        (kept, *kept_days), fewer = complete_rows(columns, missing)
        sample = as_sample(f"group {name}", kept)
        words = [str(day) for day in kept_days[0]] if kept_days else [""] * sample.values.size
        if len(words) != sample.values.size:
            raise InputRefused(
                f"group {name} has {counted(sample.values.size, 'value')} and {counted(len(words), 'label')} of day: "
                "give one label for each value."
            )
        samples.append(sample)
        days.append(words)
        left_out += fewer
    difference = _difference(*(_exact_means(sample, words) for sample, words in zip(samples, days, strict=True)))
    first, second = _as_doubles(*samples)
    of_a, of_b = (_by_day(values, words) for values, words in zip((first, second), days, strict=True))
    strata = [Stratum(of_a[day], of_b[day]) for day in of_a.keys() & of_b.keys()]
    strata.sort(key=lambda each: (each.a.tolist(), each.b.tolist()))
    n_days: int | Undefined = Undefined(Reason.NO_DAYS_GIVEN) if day_a is None else len(strata)
    exponent = out_of_range(np.concatenate([first, second]))
    in_range = tuple(Stratum(np.ldexp(each.a, -exponent), np.ldexp(each.b, -exponent)) for each in strata)
    return TwoByDay(in_range, exponent, difference, first.size, second.size, n_days, left_out)


def _exact_means(sample: Sample, words: list[str]) -> dict[str, tuple[int, Fraction]]:
    """Return the number of values of each day and their mean without error: sums that cancel keep all digits."""
    values = _by_day(sample.values, words)
    rests = {} if sample.rest is None else _by_day(sample.rest, words)
    return {day: (each.size, exact_sum(each, rests.get(day)) / each.size) for day, each in values.items()}


def _difference(a: Mapping[str, tuple[int, Fraction]], b: Mapping[str, tuple[int, Fraction]]) -> Fraction:
    """Return the weighted difference of the means of the days that hold both groups."""
    total, weights = Fraction(0), Fraction(0)
    for day in a.keys() & b.keys():
        (n_a, mean_a), (n_b, mean_b) = a[day], b[day]
        weight = Fraction(n_a * n_b, n_a + n_b)
        total, weights = total + weight * (mean_a - mean_b), weights + weight
    return total / weights if weights else total


def _by_day(values: Floats, words: list[str]) -> dict[str, Floats]:
    """Return the values of each day in ascending order."""
    places = {word: place for place, word in enumerate(dict.fromkeys(words))}
    codes = np.array([places[word] for word in words], dtype=np.intp)
    ends = np.cumsum(np.bincount(codes, minlength=len(places)))
    parts = np.split(values[np.lexsort((values, codes))], ends)
    return dict(zip(places, parts, strict=False))  # the last part is what no day holds: nothing


def _as_doubles(a: Sample, b: Sample) -> tuple[Floats, Floats]:
    """Return both samples as doubles; what doubles leave of decimals is kept by taking off what all have in common."""
    if a.rest is None and b.rest is None:
        return a.values, b.values
    origin = Fraction(common_shift(a.values, b.values))
    first, second = (np.array([float(value - origin) for value in _exact(sample)]) for sample in (a, b))
    return first, second


def _exact(sample: Sample) -> list[Fraction]:
    rest = np.zeros(sample.values.size) if sample.rest is None else sample.rest
    return [Fraction(high) + Fraction(low) for high, low in zip(sample.values.tolist(), rest.tolist(), strict=True)]
