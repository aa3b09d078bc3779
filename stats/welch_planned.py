"""Welch's t-test before its data: critical values over all ratios that two estimated variances may have.

Given the share of group a in the two sums of squares (in units of their variances; a beta variable) the degrees of
freedom are known, and t is a multiple of a noncentral t.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from scipy import special

from stats.distributions import t_upper_quantile
from stats.error_free import exact_root
from stats.finite import Number, to_double
from stats.owens_q import NODES, TINY, WEIGHTS

_FAR_TAIL = 1e-15


def over_standard_error(difference: Number, sds: tuple[float, float], sizes: tuple[int, int]) -> float:
    """Return a difference in its standard errors; infinite where no double is as large."""
    squared = Fraction(sds[0]) ** 2 / sizes[0] + Fraction(sds[1]) ** 2 / sizes[1]
    return to_double(Fraction(difference) / exact_root(squared))


def welch_criticals(sds: tuple[float, float], sizes: tuple[int, int], tail: Fraction) -> Iterator[tuple[float, float]]:
    """Yield pairs of critical value and weight, over the share of group a in both sums of squares.

    The critical value is Welch's one-sided at `tail`, for a t that is divided by the true standard error times a
    chi / sqrt(df) with n_a + n_b - 2 degrees of freedom.
    """
    df_a, df_b = sizes[0] - 1.0, sizes[1] - 1.0
    df = df_a + df_b
    exponent = math.frexp(max(sds))[1]  # only the proportion of the variances counts
    true_a, true_b = (math.ldexp(sd, -exponent) ** 2 / size for sd, size in zip(sds, sizes, strict=True))
    for share, weight in zip(*_share_nodes(df_a, df_b), strict=True):
        part_a, part_b = share * true_a * df / df_a, (1.0 - share) * true_b * df / df_b
        both = part_a + part_b
        welch_df = 1.0 / ((part_a / both) ** 2 / df_a + (part_b / both) ** 2 / df_b)
        # Of many nodes, which keep 13 digits: scipy's quantile is enough, where it is one.
        far = tail < _FAR_TAIL
        quantile = t_upper_quantile(tail, welch_df) if far else -float(special.stdtrit(welch_df, float(tail)))
        yield quantile * math.sqrt(both / (true_a + true_b)), weight


def _share_nodes(df_a: float, df_b: float) -> tuple[list[float], list[float]]:
    """Return nodes and weights of the beta distribution of chi^2_a / (chi^2_a + chi^2_b), as squares of sines."""
    a, b = df_a / 2.0, df_b / 2.0
    low = math.asin(math.sqrt(float(special.betaincinv(a, b, TINY))))
    high = math.acos(math.sqrt(float(special.betaincinv(b, a, TINY))))
    half = (high - low) / 2.0
    angle = (low + high) / 2.0 + half * NODES
    log_density = (
        math.log(2.0)
        - float(special.betaln(a, b))
        + (df_a - 1.0) * np.log(np.sin(angle))
        + (df_b - 1.0) * np.log(np.cos(angle))
    )
    weights = half * WEIGHTS * np.exp(log_density)
    return [float(x) for x in np.sin(angle) ** 2], [float(x) for x in weights]
