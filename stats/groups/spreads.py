"""Distances of values from the middle of their group, for the tests of Levene and of Brown and Forsythe.

Each distance is taken to twice double accuracy: equal ones come out equal, whatever rounding makes of the middle.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from stats.checks import Sample
from stats.exact.error_free import exact_sum, ordered_two_sum, two_sum

_MANY = 1000


def from_mean(sample: Sample) -> Sample:
    """Return how far the values, at least 1, lie from their mean."""
    total = exact_sum(sample.values) + (Fraction(0) if sample.rest is None else exact_sum(sample.rest))
    return _distances(sample, total / sample.values.size)


def from_median(sample: Sample) -> Sample:
    """Return how far the values, at least 1, lie from their median."""
    return _distances(sample, exact_median(sample))


def exact_median(sample: Sample) -> Fraction:
    """Return the median of a sample of at least 1 value without rounding the mean of the middle two."""
    values, rest, n = sample.values, sample.rest, sample.values.size
    if rest is None:
        middle = np.partition(values, (n // 2,) if n % 2 else (n // 2 - 1, n // 2))[(n - 1) // 2 : n // 2 + 1]
        return sum((Fraction(float(value)) for value in middle), Fraction(0)) / middle.size
    order = np.lexsort((rest, values))[(n - 1) // 2 : n // 2 + 1]
    return sum((Fraction(float(values[i])) + Fraction(float(rest[i])) for i in order), Fraction(0)) / order.size


def _distances(sample: Sample, middle: Fraction) -> Sample:
    near = float(middle)
    high, low = two_sum(sample.values, -near)
    low = low - float(middle - Fraction(near))
    if sample.rest is not None:
        low = low + sample.rest
    high, low = ordered_two_sum(high, low)
    if high.size > _MANY:  # rounded, each is still right to its last digit, and equal ones stay equal
        return Sample(np.abs(high), None, 0)
    return Sample(np.abs(high), np.copysign(1.0, high) * low, 0)
