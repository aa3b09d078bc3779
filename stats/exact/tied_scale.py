"""Values on a scale on which equal sums are equal: what an exact permutation test needs to know its ties.

0.1 + 0.7 and 0.3 + 0.5 are one sum of tenths and two sums of doubles; a test that compares the doubles counts ties by
the accident of their last digits (p = 0.0996 in place of 0.1082 for values of one decimal above 1e6).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.number]

MOST_DECIMALS = 15
LARGEST_WHOLE = 2.0**53
"""Up to here doubles tell whole numbers apart."""
MOST_BITS = 62
"""Differences of whole numbers below 2^62 are whole numbers below 2^63."""
MOST_OF_ANY_LENGTH = 200
"""Values up to which sums of Python's own whole numbers take no time that anybody notices."""
SPARE_BITS = 3
"""Bits that all values leave unused where they are whole numbers of a power of two; decimals leave none."""


def on_tied_scale(days: list[NDArray[np.float64]]) -> tuple[list[Numbers], float]:
    """Return each day's values minus their mean, on one scale, and the difference up to which two sums are equal.

    Values that doubles hold exactly (whole numbers in any unit that is a power of two) and values with few decimals
    become whole numbers, times the least common multiple of the days' sizes, with tolerance 0; all others stay doubles,
    with the rounding of their sums as tolerance. Where that tolerance would swallow the values' own differences, at an
    offset that leaves them few bits or beside values that cancel, doubles are taken for what they are, as whole numbers
    of any length if need be (up to `MOST_OF_ANY_LENGTH` values: beyond, the tolerance stays).
    """
    held = [values for values in days if values.size]
    pooled = np.concatenate(held)
    size = pooled.size
    tolerance = 2.0 * size * float(np.finfo(np.float64).eps) * float(np.max(np.abs(pooled)))
    gaps = np.diff(np.unique(pooled))
    bits, grid = _binary_digits(pooled)
    swallowed = bool(gaps.size and tolerance > gaps.min() / 4.0)
    if bits <= 53 - SPARE_BITS or swallowed:
        whole = _of_grid(held, grid) if bits < MOST_BITS else None
    else:
        whole = _decimals(held)
    common = math.lcm(*(values.size for values in days))
    if whole is not None:
        largest = max(int(np.max(np.abs(values))) for values in whole)
        if 4 * largest * common * size < 2**62:
            return [common * values - (common // values.size) * values.sum() for values in whole], 0
    if swallowed and size <= MOST_OF_ANY_LENGTH:
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
    for decimals in range(1, MOST_DECIMALS + 1):
        scale = 10.0**decimals
        # Beyond 15 digits every double is some decimal, and no longer one that somebody wrote.
        if largest * scale >= LARGEST_WHOLE / 8.0:
            return None
        counts = np.rint(pooled * scale)
        if np.array_equal(counts / scale, pooled):
            origin = int(counts[0])
            return [np.rint(values * scale).astype(np.int64) - origin for values in days]
    return None
