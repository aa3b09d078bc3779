"""Degrees of freedom of a sum of independent estimated variances (Welch 1938, Satterthwaite 1946).

(sum of v_i)^2 / sum of (v_i^2 / df_i): those of the chi-squared whose multiple has the sum's mean and variance. One
formula in three arithmetics. Doubles square shares of the sum, so that nothing overflows once the sum is a double, and
a share whose square is no double adds nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from stats.exact.quadrature import Floats


def exact_df(parts: Sequence[tuple[Fraction, int]]) -> Fraction:
    """Return those of (variance, degrees of freedom) of any sizes, not all variances 0, without any rounding."""
    total = sum((variance for variance, _df in parts), Fraction(0))
    doubt = sum((variance**2 / df for variance, df in parts), Fraction(0))
    return total**2 / doubt


def df_of_doubles(parts: Sequence[tuple[float, float]]) -> float:
    """Return those of (variance, degrees of freedom); infinite where all is known exactly."""
    total = math.fsum(variance for variance, _df in parts)
    doubt = math.fsum((variance / total) ** 2 / df for variance, df in parts) if total > 0.0 else 0.0
    return 1.0 / doubt if doubt > 0.0 else math.inf


def df_of_arrays(part_a: Floats, part_b: Floats, df_a: float, df_b: float) -> Floats:
    """Return those of many pairs of variances at once, of the shape of the parts; no pair is 0 twice."""
    both = part_a + part_b
    return np.asarray(1.0 / ((part_a / both) ** 2 / df_a + (part_b / both) ** 2 / df_b))
