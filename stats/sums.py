"""Sums that constants and large offsets cannot spoil: shift by a median, add exactly, correct the second pass.

The squares of a constant sample add up to exactly 0, so that "no scatter" can be told from "little scatter"
(the cases W1 to W4 that give other programs a p-value from 0/0).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Moments:
    """Size, mean and sum of squared deviations of one sample."""

    n: int
    mean: float
    """Mean; of an empty sample the shift itself, which no caller uses."""
    offset: float
    """Mean minus the shift: differences between samples with one shift are taken here, without cancellation."""
    sum_squares: float
    """Sum of squared deviations from the mean."""

    @property
    def variance(self) -> float:
        """Sample variance, for n of at least 2."""
        return self.sum_squares / (self.n - 1)


def moments(values: NDArray[np.float64], shift: float) -> Moments:
    """Return the moments of `values`, shape (n,), taken about `shift` (a median of all samples compared)."""
    n = values.size
    if n == 0:
        return Moments(0, shift, 0.0, 0.0)
    shifted = values - shift
    offset = math.fsum(shifted) / n
    deviations = shifted - offset
    left_over = math.fsum(deviations)
    squares = math.fsum(deviations * deviations) - left_over * left_over / n
    return Moments(n, shift + offset, offset, max(squares, 0.0))


def common_shift(*samples: NDArray[np.float64]) -> float:
    """Return the value that the samples are shifted by: the lower median of all of them, itself one of them."""
    pooled = np.concatenate(samples)
    if pooled.size == 0:
        return 0.0
    middle = (pooled.size - 1) // 2
    return float(np.partition(pooled, middle)[middle])
