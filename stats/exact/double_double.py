"""Sums and products with twice the digits of a double, on whole arrays: a value is a pair `high + low`.

They rest on the transformations of `exact.error_free`, and on the same extraction for sums over an axis. Values must
stay between about 1e-140 and 1e140, or be 0: callers scale by powers of two.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stats.exact.error_free import two_product, two_sum

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
