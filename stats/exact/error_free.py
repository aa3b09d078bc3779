"""Sums and products of doubles without error: what an operation rounds away is kept as a second double.

`exact_sum` takes whole arrays apart into parts whose sums are exact in any order (the extraction of Rump, Ogita and
Oishi, "Accurate floating-point summation", 2008), so that a sum depends neither on the order of the values nor on
their offset, and costs a few passes of numpy.

Sums and products with twice the digits of a double are of pairs `high + low`, on whole arrays. Their values must
stay between about 1e-140 and 1e140, or be 0: callers scale by powers of two.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Doubles = NDArray[np.float64]

_SPLITTER = 134217729.0  # 2^27 + 1: cuts a double into two halves whose products are exact
_ROOT_BITS = 120


def two_sum(a: Doubles, b: Doubles | float) -> tuple[Doubles, Doubles]:
    """Return a + b as the rounded sum and its exact error; `a` is an array at least as large as `b`."""
    total = np.asarray(a + b)
    part = np.asarray(total - a)
    rest = np.asarray(total - part)
    # In place from here on: memory is what large arrays wait for.
    np.subtract(a, rest, out=rest)
    np.subtract(b, part, out=part)
    rest += part
    return total, rest


def ordered_two_sum(a: Doubles, b: Doubles) -> tuple[Doubles, Doubles]:
    """Return a + b as the rounded sum and its exact error, where |a| is at least |b| or a is 0."""
    total = a + b
    return total, b - (total - a)


def two_product(a: Doubles, b: Doubles) -> tuple[Doubles, Doubles]:
    """Return a * b as the rounded product and its exact error, for factors of at most 2^500 that do not underflow."""
    halves_a = split(a)
    return product_of_halves(a, halves_a, b, halves_a if a is b else split(b))


def split(a: Doubles) -> tuple[Doubles, Doubles]:
    """Return two halves of at most 26 bits that add up to `a`: products of halves are exact."""
    high = np.asarray(_SPLITTER * a)
    low = np.asarray(high - a)
    high -= low
    np.subtract(a, high, out=low)
    return high, low


def product_of_halves(
    a: Doubles, halves_a: tuple[Doubles, Doubles], b: Doubles, halves_b: tuple[Doubles, Doubles]
) -> tuple[Doubles, Doubles]:
    """Return a * b as `two_product`, for factors that come again and are split already."""
    product = np.asarray(a * b)
    (high_a, low_a), (high_b, low_b) = halves_a, halves_b
    error = np.asarray(high_a * high_b)
    error -= product
    for one, other in ((low_a, high_b), (high_a, low_b), (low_a, low_b)):
        error += one * other
    return product, error


def greatest(values: Doubles) -> float:
    """Return the largest magnitude; 0 of no value."""
    return max(float(values.max()), -float(values.min())) if values.size else 0.0


def exact_sum(values: Doubles) -> Fraction:
    """Return the sum of finite doubles, shape (n,), without any error."""
    total, left = Fraction(0), values
    while True:
        largest = greatest(left)
        if largest == 0.0:
            return total
        top = math.frexp(largest)[1] + left.size.bit_length() + 1
        if top > 1023:
            large = np.abs(left) > 2.0**900
            return total + 2**128 * exact_sum(left[large] * 2.0**-128) + exact_sum(left[~large])
        # Rounded to a multiple of the last bit of 2^top, n values add up without leaving 53 bits.
        big = math.ldexp(1.0, top)
        part = (big + left) - big
        total += Fraction(float(part.sum()))
        left = left - part


def exact_root(value: Fraction) -> Fraction:
    """Return the square root of a number of any size, to 120 bits."""
    if value <= 0:
        return Fraction(0)
    exponent = (value.numerator.bit_length() - value.denominator.bit_length()) // 2
    shift = 2 * (_ROOT_BITS - exponent)
    scaled = (value.numerator << shift) if shift >= 0 else value.numerator
    divisor = value.denominator if shift >= 0 else value.denominator << -shift
    return Fraction(math.isqrt(scaled // divisor)) / Fraction(2) ** (shift // 2)


def dyadic_sum(ratios: list[tuple[int, int]], unit: Fraction) -> Fraction:
    """Return the sum of ratios over powers of two, in a unit: in whole numbers, for fractions take thrice as long."""
    finest = max(bottom for _top, bottom in ratios)
    total = sum(top * (finest // bottom) for top, bottom in ratios)
    return Fraction(total * unit.numerator, finest * unit.denominator)


def scaled(values: Doubles, exponent: int) -> Doubles:
    """Return values * 2^exponent; in two steps, as the power itself may be no double."""
    if -1000 < exponent < 1000:
        return values * math.ldexp(1.0, exponent)
    half = exponent // 2
    return values * math.ldexp(1.0, half) * math.ldexp(1.0, exponent - half)


def shortened(value: Fraction) -> Fraction:
    """Return a number of any size to 120 bits, so that what follows need not carry thousands."""
    excess = value.numerator.bit_length() - value.denominator.bit_length()
    shift = _ROOT_BITS - excess
    if shift >= 0:
        return Fraction((value.numerator << shift) // value.denominator, 1 << shift)
    return Fraction((value.numerator // (value.denominator << -shift)) << -shift)


Floats = NDArray[np.float64]
Pair = tuple[Floats, Floats]
"""High and low part of the same shape; `low` is at most half a unit in the last place of `high`."""

FRACTION_BITS = 320
"""Bits after the point of `fixed_point`."""


def multiply(a: Pair, b: Pair) -> Pair:
    """Return the product of two pairs, to about 31 digits."""
    product, error = two_product(a[0], b[0])
    return two_sum(product, error + (a[0] * b[1] + a[1] * b[0]))


def sum_pairs(high: Floats, low: Floats) -> Pair:
    """Return the sum of pairs over the last axis; its error is about 1e-32 of the largest term.

    A large constant rounds all terms to one grid on which they add exactly, and leaves remainders to the next pass.
    """
    count = high.shape[-1]
    room = (count + 2).bit_length()
    exponent = np.frexp(np.abs(high).max(axis=-1, keepdims=True, initial=0.0))[1]
    grid = np.ldexp(1.0, exponent + room)
    first = (grid + high) - grid
    rest = high - first
    grid = grid * math.ldexp(1.0, room - 53)
    second = (grid + rest) - grid
    total, error = two_sum(first.sum(axis=-1), second.sum(axis=-1))
    return two_sum(total, error + ((rest - second) + low).sum(axis=-1))


def fixed_point(high: float, low: float = 0.0) -> int:
    """Return high + low as a whole number of 2**-320: exact for what is read from data scaled to about 1."""
    total = 0
    for part in (high, low):
        numerator, denominator = part.as_integer_ratio()
        total += (numerator << FRACTION_BITS) // denominator
    return total


def nearest_double(fixed: int, exponent: int = 0) -> float:
    """Return a `fixed_point` number times 2**exponent, correctly rounded; infinite where doubles end."""
    try:
        return math.ldexp(fixed / (1 << FRACTION_BITS), exponent)
    except OverflowError:
        return math.copysign(math.inf, fixed)
