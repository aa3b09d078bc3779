"""Welch's t-test before its data: means over all ratios that two estimated variances may have.

Given the share of group a in the two sums of squares (in units of their variances; a beta variable) the degrees of
freedom are known, and t is a multiple of a noncentral t.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
from scipy import special

from stats.exact.distributions import t_upper_quantile
from stats.exact.error_free import exact_root
from stats.exact.finite import Number, to_double
from stats.exact.quadrature import Floats
from stats.exact.welch_satterthwaite import df_of_arrays
from stats.planning.estimated_scatter import mean_over_share

_FAR_TAIL = 1e-15


def over_standard_error(difference: Number, sds: tuple[float, float], sizes: tuple[int, int]) -> float:
    """Return a difference in its standard errors; infinite where no double is as large."""
    squared = Fraction(sds[0]) ** 2 / sizes[0] + Fraction(sds[1]) ** 2 / sizes[1]
    return to_double(Fraction(difference) / exact_root(squared))


def mean_over_criticals(
    value: Callable[[Floats], Floats], sds: tuple[float, float], sizes: tuple[int, int], tail: Fraction
) -> float:
    """Return the mean of what `value` makes of critical values, over the share of group a in both sums of squares.

    A critical value is Welch's one-sided at `tail`, for a t that is divided by the true standard error times a
    chi / sqrt(df) with n_a + n_b - 2 degrees of freedom. Right to 1e-10 of itself where `value` is.
    """
    df_a, df_b = sizes[0] - 1.0, sizes[1] - 1.0
    df = df_a + df_b
    exponent = math.frexp(max(sds))[1]  # only the proportion of the variances counts
    true_a, true_b = (math.ldexp(sd, -exponent) ** 2 / size for sd, size in zip(sds, sizes, strict=True))

    def of_shares(share_a: Floats, share_b: Floats) -> Floats:
        part_a, part_b = share_a * true_a * df / df_a, share_b * true_b * df / df_b
        both = part_a + part_b
        quantiles = t_upper_quantiles(tail, df_of_arrays(part_a, part_b, df_a, df_b))
        return value(quantiles * np.sqrt(both / (true_a + true_b)))

    turn = math.sqrt(true_b / df_b) / math.sqrt(true_a / df_a) if true_a > 0.0 else math.inf
    return mean_over_share(of_shares, df_a, df_b, turn)


def t_upper_quantiles(tail: Fraction, df: Floats) -> Floats:
    """Return the values of Student's t with a chance of `tail` above them, for each number of degrees of freedom.

    scipy's quantile, taken to the last digits by one of Newton's steps.
    """
    chance = float(tail)
    if chance < _FAR_TAIL:
        return np.array([t_upper_quantile(tail, each) for each in df.ravel().tolist()]).reshape(df.shape)
    t = -special.stdtrit(df, chance)
    with np.errstate(over="ignore"):
        log_density = (
            special.gammaln((df + 1.0) / 2.0)
            - special.gammaln(df / 2.0)
            - 0.5 * np.log(math.pi * df)
            - (df + 1.0) / 2.0 * np.log1p(t * t / df)
        )
    return np.asarray(t + (special.stdtr(df, -t) - chance) / np.exp(log_density))
