"""Sums and products with twice the digits of a double, on whole arrays: a value is a pair `high + low`.

Error-free transformations: Knuth's sum, Dekker's product with Veltkamp's split, and Rump, Ogita and Oishi's extraction
for sums over an axis. Values must stay between about 1e-140 and 1e140, or be 0: callers scale by powers of two.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pair = tuple[Floats, Floats]
"""High and low part of the same shape; `low` is at most half a unit in the last place of `high`."""

FRACTION_BITS = 320
"""Bits after the point of `fixed_point`."""

_SPLITTER = 134217729.0  # 2**27 + 1


def two_sum(a: Floats, b: Floats | float) -> Pair:
    """Return a + b exactly, as a pair; `a` is an array at least as large as `b`."""
    total = np.asarray(a + b)
    part = np.asarray(total - a)
    rest = np.asarray(total - part)
    # In place from here on: memory is what large arrays wait for.
    np.subtract(a, rest, out=rest)
    np.subtract(b, part, out=part)
    rest += part
    return total, rest


def split(a: Floats) -> Pair:
    """Return two halves of at most 26 bits that add up to `a`: products of halves are exact."""
    high = np.asarray(_SPLITTER * a)
    low = np.asarray(high - a)
    high -= low
    np.subtract(a, high, out=low)
    return high, low


def two_product(a: Floats, halves_a: Pair, b: Floats, halves_b: Pair) -> Pair:
    """Return a * b exactly, as a pair; the halves come from `split`."""
    product = np.asarray(a * b)
    high_a, low_a = halves_a
    high_b, low_b = halves_b
    error = np.asarray(high_a * high_b)
    error -= product
    part = np.asarray(low_a * high_b)
    error += part
    np.multiply(high_a, low_b, out=part)
    error += part
    np.multiply(low_a, low_b, out=part)
    error += part
    return product, error


def multiply(a: Pair, b: Pair) -> Pair:
    """Return the product of two pairs, to about 31 digits."""
    product, error = two_product(a[0], split(a[0]), b[0], split(b[0]))
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


def times_power_of_two(values: Floats, exponent: int) -> Floats:
    """Return values * 2**exponent; a product, where it can be one, is much faster than `ldexp`."""
    scaled: Floats = values * math.ldexp(1.0, exponent) if abs(exponent) < 1000 else np.ldexp(values, exponent)
    return scaled


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
