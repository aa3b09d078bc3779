"""Moments that neither constants nor offsets nor units can spoil: exact mean, squares to twice double accuracy.

The mean is an exact fraction. Deviations from it are pairs of doubles, scaled by a power of two before they are
squared (so that 2^-600 or 2^600 as a unit changes nothing), and their squares are added without error. The squares of
a constant sample are exactly 0, so that "no scatter" can be told from "little scatter" (the cases W1 to W5 that give
other programs a p-value from 0/0). Tests of several samples take the exact fields and round once, at the end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from stats.exact.error_free import Doubles, exact_sum, greatest, ordered_two_sum, scaled, two_product, two_sum
from stats.exact.finite import to_double

_FEW = 50


@dataclass(frozen=True, slots=True)
class ExactMoments:
    """Size, mean and sum of squared deviations of one sample, as fractions of any size."""

    n: int
    exact_mean: Fraction
    """The mean without error."""
    exact_sum_squares: Fraction
    """Sum of squared deviations from the mean to 30 digits; exactly 0 of constants, and only of these."""

    @property
    def constant(self) -> bool:
        """Whether all values are equal."""
        return self.exact_sum_squares == 0

    @property
    def exact_variance(self) -> Fraction:
        """Sample variance to 30 digits, for n of at least 2."""
        return self.exact_sum_squares / (self.n - 1)

    @property
    def exact_mean_variance(self) -> Fraction:
        """Squared standard error of the mean to 30 digits, for n of at least 2."""
        return self.exact_sum_squares / (self.n * (self.n - 1))


@dataclass(frozen=True, slots=True)
class Moments(ExactMoments):
    """Those of values in their own unit, beside the doubles next to them."""

    mean: float
    """Mean; of an empty sample the shift itself, which no caller uses."""
    offset: float
    """Mean minus the shift."""
    sum_squares: float
    """Sum of squared deviations from the mean; 0 or infinite where no double is as small or large."""

    @property
    def variance(self) -> float:
        """Sample variance, for n of at least 2."""
        return self.sum_squares / (self.n - 1)


@dataclass(frozen=True, slots=True)
class Deviations:
    """Deviations from the mean, each the sum of two doubles, divided by 2^exponent so that the largest is about 1."""

    high: Doubles
    low: Doubles
    exponent: int
    mean: Fraction
    """Mean of the values themselves."""


def deviations(values: Doubles, rest: Doubles | None = None) -> Deviations:
    """Return how far values, shape (n,) with n of at least 1, lie from their mean.

    `rest` is what the doubles leave of values that are no doubles (`stats.checks.Sample`).
    """
    total = exact_sum(values) if rest is None else exact_sum(values) + exact_sum(rest)
    return _deviations_from(total / values.size, values, rest)


def _deviations_from(mean: Fraction, values: Doubles, rest: Doubles | None) -> Deviations:
    away = out_of_range(values)
    if away:
        within = _deviations_from(
            mean / Fraction(2) ** away, scaled(values, -away), None if rest is None else scaled(rest, -away)
        )
        return Deviations(within.high, within.low, within.exponent + away, mean)
    middle = float(mean)
    high, low = two_sum(values, -middle)
    low = low - float(mean - Fraction(middle))
    if rest is not None:
        low = low + rest
    high, low = ordered_two_sum(high, low)
    if high[0] == high[-1] and high.min() == high.max() and low.min() == low.max():
        return Deviations(np.zeros(values.size), np.zeros(values.size), 0, mean)
    exponent = math.frexp(greatest(high))[1]
    return Deviations(scaled(high, -exponent), scaled(low, -exponent), exponent, mean)


def out_of_range(values: Doubles) -> int:
    """Return the power of two to take out of values whose differences could overflow, or lose bits as subnormals."""
    largest = greatest(values)
    if largest > 2.0**1000:
        return 64
    return -512 if 0.0 < largest < 2.0**-500 else 0


def sum_of_products(a: tuple[Doubles, Doubles], b: tuple[Doubles, Doubles]) -> Fraction:
    """Return the sum of products of two arrays of pairs (high, low), of magnitude at most 1, to 30 digits."""
    product, error = two_product(a[0], b[0])
    error += 2.0 * (a[0] * a[1]) if a is b else a[0] * b[1] + a[1] * b[0]
    # Rounded to one grid n products add up without error, and their remainders on a finer grid too.
    room = (product.size + 2).bit_length()
    grid, total = math.ldexp(1.0, room), Fraction(0)
    for _ in range(2):
        part = (grid + product) - grid
        total += Fraction(float(part.sum()))
        product -= part
        grid = math.ldexp(grid, room - 53)
    error += product
    return total + Fraction(float(error.sum()))


def moments(values: Doubles, shift: float = 0.0, rest: Doubles | None = None) -> Moments:
    """Return the moments of finite `values`, shape (n,), and the mean's distance from `shift`.

    `rest` is what the doubles leave of values that are no doubles (`stats.checks.Sample`).
    """
    n = values.size
    if n == 0:
        return Moments(0, Fraction(shift), Fraction(0), mean=shift, offset=0.0, sum_squares=0.0)
    if n <= _FEW:
        mean, squares = _moments_of_few(values, rest)
    else:
        about = deviations(values, rest)
        pair = (about.high, about.low)
        mean, squares = about.mean, sum_of_products(pair, pair) * Fraction(2) ** (2 * about.exponent)
    return Moments(
        n, mean, squares, mean=float(mean), offset=to_double(mean - Fraction(shift)), sum_squares=to_double(squares)
    )


def _moments_of_few(values: Doubles, rest: Doubles | None) -> tuple[Fraction, Fraction]:
    """Return mean and sum of squares in whole numbers of one unit: quicker than arrays where there are few values."""
    parts = [[x.as_integer_ratio() for x in array.tolist()] for array in (values, rest) if array is not None]
    unit = max(bottom for part in parts for _, bottom in part)  # all are powers of two
    counts = [sum(top * (unit // bottom) for top, bottom in pair) for pair in zip(*parts, strict=True)]
    total = sum(counts)
    squares = len(counts) * sum(count * count for count in counts) - total * total
    return Fraction(total, len(counts) * unit), Fraction(squares, len(counts) * unit * unit)


def common_shift(*samples: Doubles) -> float:
    """Return a value near all samples, one of them: the lower median of all; 0 of no value."""
    pooled = np.concatenate(samples)
    if pooled.size == 0:
        return 0.0
    middle = (pooled.size - 1) // 2
    return float(np.partition(pooled, middle)[middle])
