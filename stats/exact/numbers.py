"""Exact sums and moments, numbers beyond the range of doubles, sums that tie exactly, and roots of functions.

A mean is an exact fraction, squares are those of deviations from it: an offset costs no digit. The squares of a
constant sample are exactly 0, so that "no scatter" differs from "little scatter" (the cases W1 to W5 that give
other programs a p-value from 0/0). Tests of several samples take the exact fields and round once, at the end.

Doubles reach from 5e-324 to 1.8e308. Sums, squares and quotients of values from both ends of that range leave it: a
number of a result that no double is large enough for is `Undefined`, never infinite or NaN. That is asked of each where
it is rounded, and nowhere else.

An exact permutation test needs to know its ties: 0.1 + 0.7 and 0.3 + 0.5 are one sum of tenths and two sums of doubles;
a test that compares the doubles counts ties by the accident of their last digits (p = 0.0996 in place of 0.1082 for
values of one decimal above 1e6).

The root of a function is found by `root_between`, without `scipy.optimize`, which takes a tenth of a second to load, of
the three in which a report of a selection is made.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined

Floats = NDArray[np.float64]
Interval = tuple[float, float]
Number = float | Fraction
QUANTILE_BEYOND_DOUBLES = Undefined(Reason.QUANTILE_BEYOND_DOUBLES)

_ROOT_BITS = 120
_FEW = 50
"""Values up to which whole numbers of any length are quicker than arrays."""


def to_double(value: Number) -> float:
    """Return the nearest double; infinite where there is none that large."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def times_power(value: float, exponent: int) -> float:
    """Return value * 2**exponent; infinite where there is no double that large."""
    try:
        return math.ldexp(value, exponent)
    except OverflowError:
        return math.copysign(math.inf, value)


def finite(value: Number, what: str) -> float | Undefined:
    """Return a number as a double, or that it is too large for one."""
    number = to_double(value)
    return number if math.isfinite(number) else Undefined(Reason.BEYOND_DOUBLES, what=what)


def finite_pair(low: Number, high: Number) -> Interval | Undefined:
    """Return the ends of an interval as doubles, or that one is too large."""
    ends = to_double(low), to_double(high)
    return ends if all(map(math.isfinite, ends)) else Undefined(Reason.END_BEYOND_DOUBLES)


def interval_about(middle: Fraction, quantile: float, se: Fraction) -> Interval | Undefined:
    """Return middle -/+ quantile * se as doubles, or that the quantile or an end is too large."""
    if math.isinf(quantile):
        return QUANTILE_BEYOND_DOUBLES
    half = Fraction(quantile) * se
    return finite_pair(middle - half, middle + half)


def as_interval(low: float | Undefined, high: float | Undefined) -> Interval | Undefined:
    """Return two ends as an interval, or why one of them is undefined."""
    if isinstance(low, Undefined):
        return low
    return high if isinstance(high, Undefined) else (low, high)


def refuse_beyond(what: str, numbers: Iterable[Number]) -> None:
    """Raise `InputRefused` where a number has no double of its size: for results that are whole or nothing."""
    for number in numbers:
        double = to_double(number)
        if not math.isfinite(double):
            raise InputRefused(f"{what} exceeds 1.8e308: change units.")
        if double == 0.0 and number:
            raise InputRefused(f"{what} falls below 5e-324: change units.")


def exact_root(value: Fraction) -> Fraction:
    """Return the square root of a number of any size, to 120 bits."""
    if value <= 0:
        return Fraction(0)
    exponent = (value.numerator.bit_length() - value.denominator.bit_length()) // 2
    shift = 2 * (_ROOT_BITS - exponent)
    scaled = (value.numerator << shift) if shift >= 0 else value.numerator
    divisor = value.denominator if shift >= 0 else value.denominator << -shift
    return Fraction(math.isqrt(scaled // divisor)) / Fraction(2) ** (shift // 2)


def to_120_bits(value: Fraction) -> Fraction:
    """Return a number of any size to 120 bits, so that what follows need not carry thousands."""
    shift = _ROOT_BITS - (value.numerator.bit_length() - value.denominator.bit_length())
    if shift >= 0:
        return Fraction((value.numerator << shift) // value.denominator, 1 << shift)
    return Fraction((value.numerator // (value.denominator << -shift)) << -shift)


def greatest(values: Floats) -> float:
    """Return the largest magnitude; 0 of no value."""
    return max(float(values.max()), -float(values.min())) if values.size else 0.0


def out_of_range(values: Floats) -> int:
    """Return the power of two to take out of values whose differences could overflow, or lose bits as subnormals."""
    largest = greatest(values)
    if largest > 2.0**1000:
        return 64
    return -512 if 0.0 < largest < 2.0**-500 else 0


def common_shift(*samples: Floats) -> float:
    """Return a value near all samples, one of them: the lower median of all; 0 of no value."""
    pooled = np.concatenate(samples)
    if pooled.size == 0:
        return 0.0
    middle = (pooled.size - 1) // 2
    return float(np.partition(pooled, middle)[middle])


def exact_sum(values: Floats, rest: Floats | None = None) -> Fraction:
    """Return the sum of finite doubles, shape (n,), to 100 bits at least, whatever their order and however they cancel.

    `rest` is what the doubles leave of values that are no doubles (`stats.checks.Sample`).
    """
    numbers = values.tolist() if rest is None else [*values.tolist(), *rest.tolist()]
    try:
        high = math.fsum(numbers)
        return Fraction(high) + Fraction(math.fsum([*numbers, -high]))
    except OverflowError:
        return sum(map(Fraction, numbers), Fraction(0))


@dataclass(frozen=True, slots=True)
class Moments:
    """Size, mean and sum of squared deviations of one sample, as fractions of any size."""

    n: int
    exact_mean: Fraction
    """The mean to 100 bits; 0 of no value."""
    exact_sum_squares: Fraction
    """Sum of squared deviations from the mean to 15 digits; exactly 0 of constants, and only of these."""

    @property
    def mean(self) -> float:
        """The mean."""
        return float(self.exact_mean)

    @property
    def constant(self) -> bool:
        """Whether all values are equal."""
        return self.exact_sum_squares == 0

    @property
    def exact_variance(self) -> Fraction:
        """Sample variance, for n of at least 2."""
        return self.exact_sum_squares / (self.n - 1)

    @property
    def exact_mean_variance(self) -> Fraction:
        """Squared standard error of the mean, for n of at least 2."""
        return self.exact_sum_squares / (self.n * (self.n - 1))


def moments(values: Floats, rest: Floats | None = None) -> Moments:
    """Return the moments of finite `values`, shape (n,), and what doubles leave of them (`stats.checks.Sample`)."""
    n = values.size
    if n == 0:
        return Moments(0, Fraction(0), Fraction(0))
    if n <= _FEW:
        return _moments_of_few(values, rest)
    mean = exact_sum(values, rest) / n
    away, exponent = deviations(mean, values, rest)
    squares = Fraction(math.fsum((away * away).tolist())) - Fraction(math.fsum(away.tolist())) ** 2 / n
    return Moments(n, mean, squares * Fraction(4) ** exponent)


def _moments_of_few(values: Floats, rest: Floats | None) -> Moments:
    parts = [[x.as_integer_ratio() for x in array.tolist()] for array in (values, rest) if array is not None]
    unit = max(bottom for part in parts for _, bottom in part)  # all are powers of two
    counts = [sum(top * (unit // bottom) for top, bottom in pair) for pair in zip(*parts, strict=True)]
    n, total = len(counts), sum(counts)
    squares = n * sum(count * count for count in counts) - total * total
    return Moments(n, Fraction(total, n * unit), Fraction(squares, n * unit * unit))


def deviations(middle: Fraction, values: Floats, rest: Floats | None = None) -> tuple[Floats, int]:
    """Return how far values, shape (n,), lie from a middle, in units of a power of two, and that power.

    Each is rounded by its own last digit, not by that of what all have in common. The largest is about 1.
    """
    away = out_of_range(values)
    unit = Fraction(2) ** away
    near = float(middle / unit)
    left = np.ldexp(values, -away) - near
    left -= float(middle / unit - Fraction(near))
    if rest is not None:
        left += np.ldexp(rest, -away)
    exponent = math.frexp(greatest(left))[1]
    return np.ldexp(left, -exponent), away + exponent


Numbers = NDArray[np.number]

_MOST_DECIMALS = 15
_LARGEST_WHOLE = 2.0**53
"""Up to here doubles hold every whole number."""
MOST_BITS = 62
"""Differences of whole numbers below 2^62 are whole numbers below 2^63."""
_MOST_OF_ANY_LENGTH = 200
"""Values up to which sums of Python's own whole numbers take no time that anybody notices."""
_SPARE_BITS = 3
"""Bits that all values leave unused where they are whole numbers of a power of two; decimals leave none."""


def on_tied_scale(days: list[NDArray[np.float64]]) -> tuple[list[Numbers], float]:
    """Return each day's values minus their mean, on one scale, and the difference up to which two sums are equal.

    Values that doubles hold exactly (whole numbers in any unit that is a power of two) and values with few decimals
    become whole numbers, times the least common multiple of the days' sizes, with tolerance 0; all others stay doubles,
    with the rounding of their sums as tolerance. Where that tolerance would swallow the values' own differences, at an
    offset that leaves them few bits or beside values that cancel, doubles are taken for what they are, as whole numbers
    of any length if need be (up to `_MOST_OF_ANY_LENGTH` values: beyond, the tolerance stays).
    """
    held = [values for values in days if values.size]
    pooled = np.concatenate(held)
    size = pooled.size
    tolerance = 2.0 * size * float(np.finfo(np.float64).eps) * float(np.max(np.abs(pooled)))
    gaps = np.diff(np.unique(pooled))
    bits, grid = _binary_digits(pooled)
    swallowed = bool(gaps.size and tolerance > gaps.min() / 4.0)
    if bits <= 53 - _SPARE_BITS or swallowed:
        whole = _of_grid(held, grid) if bits < MOST_BITS else None
    else:
        whole = _decimals(held)
    common = math.lcm(*(values.size for values in days))
    if whole is not None:
        largest = max(int(np.max(np.abs(values))) for values in whole)
        if 4 * largest * common * size < 2**62:
            return [common * values - (common // values.size) * values.sum() for values in whole], 0
    if swallowed and size <= _MOST_OF_ANY_LENGTH:
        return [common * values - (common // values.size) * values.sum() for values in _of_any_length(held)], 0
    scores: list[Numbers] = []
    for values in days:
        shifted = values - values[0]
        scores.append(shifted - math.fsum(shifted) / shifted.size)
    return scores, tolerance


def _binary_digits(values: NDArray[np.float64]) -> tuple[int, int]:
    """Return how many bits the values need as whole numbers of one power of two, and that power."""
    fractions, exponents = np.frexp(values[values != 0.0])
    if not fractions.size:
        return 0, 0
    whole = np.ldexp(fractions, 53).astype(np.int64)
    lowest = np.frexp((whole & -whole).astype(np.float64))[1] - 1
    grid = int((exponents + lowest).min()) - 53
    return int(exponents.max()) - grid, grid


def _of_grid(days: list[NDArray[np.float64]], grid: int) -> list[NDArray[np.int64]]:
    """Return the values as whole numbers of 2**grid, from the first value."""
    counts = [np.ldexp(values, -grid).astype(np.int64) for values in days]
    return [each - int(counts[0][0]) for each in counts]


def _of_any_length(days: list[NDArray[np.float64]]) -> list[NDArray[Any]]:
    """Return the values as Python's whole numbers of the finest power of two that any of them needs."""
    ratios = [[value.as_integer_ratio() for value in values.tolist()] for values in days]
    unit = max(bottom for each in ratios for _, bottom in each)
    return [np.array([top * (unit // bottom) for top, bottom in each], dtype=object) for each in ratios]


def _decimals(days: list[NDArray[np.float64]]) -> list[NDArray[np.int64]] | None:
    """Return the values as whole numbers of the finest decimal they use, from the first value; None for others."""
    pooled = np.concatenate(days)
    largest = float(np.max(np.abs(pooled)))
    for decimals in range(1, _MOST_DECIMALS + 1):
        scale = 10.0**decimals
        # Beyond 15 digits every double is some decimal, and no longer one that somebody wrote.
        if largest * scale >= _LARGEST_WHOLE / 8.0:
            return None
        counts = np.rint(pooled * scale)
        if np.array_equal(counts / scale, pooled):
            origin = int(counts[0])
            return [np.rint(values * scale).astype(np.int64) - origin for values in days]
    return None


Point = tuple[float, float]
"""A place and the function's value there."""

_ENOUGH = 2.0 * float(np.finfo(np.float64).eps)


def root_between(function: Callable[[float], float], one: Point, other: Point, most_steps: int = 200) -> float:
    """Return where a function is 0 between two places at which it has other signs, to the last digits.

    By inverse quadratic interpolation where the three last places allow it, and by halves elsewhere: where a value is
    infinite, or the function has steps.

    Source: Chandrupatla (1997), Advances in Engineering Software 28, 145.
    """
    (a, f_a), (b, f_b), share = one, other, 0.5
    best = a
    for _ in range(most_steps):
        place = a + share * (b - a)
        value = function(place)
        if (value > 0.0) == (f_a > 0.0):
            c, f_c = a, f_a
        else:
            (c, f_c), (b, f_b) = (b, f_b), (a, f_a)
        a, f_a = place, value
        best = a if abs(f_a) < abs(f_b) else b
        if value == 0.0 or abs(b - a) <= 2.0 * _ENOUGH * abs(best):
            return best
        least = _ENOUGH * abs(best) / abs(b - a)
        share = min(max(_next_share(a, f_a, b, f_b, c, f_c), least), 1.0 - least)
    return best


def _next_share(a: float, f_a: float, b: float, f_b: float, c: float, f_c: float) -> float:
    """Return how far from a to b to look next: a half where the three values do not determine it."""
    try:
        xi, phi = (a - b) / (c - b), (f_a - f_b) / (f_c - f_b)
        alpha = (c - a) / (b - a)
        quadratic = f_a / (f_b - f_a) * f_c / (f_b - f_c) + alpha * f_a / (f_c - f_a) * f_b / (f_c - f_b)
    except (OverflowError, ZeroDivisionError):
        return 0.5
    allowed = phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi and math.isfinite(quadratic)
    return quadratic if allowed else 0.5
