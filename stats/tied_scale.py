"""Values on a scale on which equal sums are equal: what an exact permutation test needs to know its ties.

0.1 + 0.7 and 0.3 + 0.5 are one sum of tenths and two sums of doubles; a test that compares the doubles counts ties by
the accident of their last digits (p = 0.0996 in place of 0.1082 for values of one decimal above 1e6).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.number]

MOST_DECIMALS = 15
LARGEST_WHOLE = 2.0**53
"""Up to here doubles tell whole numbers apart."""


def on_tied_scale(days: list[NDArray[np.float64]]) -> tuple[list[Numbers], float]:
    """Return each day's values minus their mean, on one scale, and the difference up to which two sums are equal.

    Values with few decimals become whole numbers, times the least common multiple of the days' sizes, with tolerance
    0; all others stay doubles, with the rounding of their sums as tolerance.
    """
    whole = _whole([values for values in days if values.size])
    common = math.lcm(*(values.size for values in days))
    if whole is not None:
        largest = max(int(np.max(np.abs(values))) for values in whole)
        if 4 * largest * common * sum(values.size for values in days) < 2**62:
            return [common * values - (common // values.size) * values.sum() for values in whole], 0.0
    size = sum(values.size for values in days)
    largest_value = max(float(np.max(np.abs(values))) for values in days)
    scores: list[Numbers] = []
    for values in days:
        shifted = values - values[0]
        scores.append(shifted - math.fsum(shifted) / shifted.size)
    return scores, 2.0 * size * float(np.finfo(np.float64).eps) * largest_value


def _whole(days: list[NDArray[np.float64]]) -> list[NDArray[np.int64]] | None:
    """Return the values as whole numbers of the finest decimal they use, from the first value; None for others."""
    pooled = np.concatenate(days)
    largest = float(np.max(np.abs(pooled)))
    for decimals in range(MOST_DECIMALS + 1):
        scale = 10.0**decimals
        # Beyond 15 digits every double is some decimal, and no longer one that somebody wrote.
        if largest * scale >= LARGEST_WHOLE / 8.0:
            return None
        counts = np.rint(pooled * scale)
        if np.array_equal(counts / scale, pooled):
            origin = int(counts[0])
            return [np.rint(values * scale).astype(np.int64) - origin for values in days]
    return None
