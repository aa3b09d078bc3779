"""Means over what estimated variances may turn out: over their pooled scale, and over the share a group has in them.

The sums of squares of two groups, in units of their variances, are chi^2 with n - 1 degrees of freedom each. Their sum
and the share of one of them in it are independent: the sum is that of U^2 = chi^2_df / df with both groups' degrees of
freedom, the share is a beta variable.

So Welch's t-test before its data is a mean over all ratios that two estimated variances may have. Given the share of
group a in the two sums of squares (in units of their variances) the degrees of freedom are known, and t is a multiple
of a noncentral t. Over the share scipy's adaptive rule integrates, in its log odds.

Chances that t-tests of known critical values reject are those of two one-sided ones (Owen's Q), and of either side of
one. With U = sqrt(chi^2_nu / nu), a standard error estimated with nu degrees of freedom in units of the true one, they
are means of normal probabilities over U. Each is right to 1e-10 of itself, down to 1e-290.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
from scipy import special

from stats.exact.numbers import Floats, Number, exact_root, to_double
from stats.exact.quadrature import Rows, log_means_over_scale, stirling_rest
from stats.exact.tails import df_of_arrays, t_upper_quantiles

OfScale = Callable[[Floats, Rows], Floats]
"""From scales U (rows, points) and the row that each line of them belongs to, to values (rows, points) of 0 to 1."""

_UNDERFLOW = -740.0
"""Logarithm below which nothing is a double."""
_BESIDE = np.array([-5.0, 0.0, 5.0])
"""Edges of panels about a turn, in its widths."""
_TOLERANCE, _SUBDIVISIONS = 1e-10, 500
_WIDTHS, _REACH = 9.0, 80.0
"""What lies farther than both from the middle of a share adds nothing: in standard deviations, and times 1 / df."""


def mean_over_scale(value: OfScale, df: float, turns: Floats, widths: Floats, last: Floats | None = None) -> Floats:
    """Return the means (rows,) of a value that falls as U = sqrt(chi^2_df / df) grows and is log-concave in U.

    It turns at `turns` over `widths`, both (rows, turns), and comes to 0 at `last` (rows,).
    """

    def log_value(u: Floats, rows: Rows) -> Floats:
        with np.errstate(divide="ignore"):
            return np.log(value(np.exp(u), rows))

    count = turns.shape[0]
    edges = (turns[:, :, None] + widths[:, :, None] * _BESIDE).reshape(count, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        places = np.log(edges)
        end = None if last is None else np.log(last)
    lowest = np.full(count, _UNDERFLOW / df)
    return np.exp(log_means_over_scale(log_value, np.full(count, df), lowest, turns=places, last=end))


def mean_over_share(value: Callable[[Floats, Floats], Floats], df_a: float, df_b: float) -> float:
    """Return the mean of a value over the share of a in both sums of squares.

    `value` goes from the shares of a and of b, both (points,), to values of 0 to 1 (points,).
    """
    from scipy.integrate import cubature  # takes a fifth of a second to load

    middle, width = math.log(df_a / df_b), math.sqrt(2.0 / df_a + 2.0 / df_b)
    # About its middle the density falls as a normal's, and far from it as exp(df / 2) of each side.
    low, high = middle - _WIDTHS * width - _REACH / df_a, middle + _WIDTHS * width + _REACH / df_b

    def weighted(log_odds: Floats) -> Floats:
        odds = log_odds[:, 0]
        return np.exp(_log_odds_density(odds, df_a, df_b)) * value(special.expit(odds), special.expit(-odds))

    return float(
        cubature(weighted, [low], [high], rtol=_TOLERANCE, points=[[middle]], max_subdivisions=_SUBDIVISIONS).estimate
    )


def _log_odds_density(log_odds: Floats, df_a: float, df_b: float) -> Floats:
    """Return the logarithm of the density of the log odds of a's share."""
    if df_a > df_b:
        return _log_odds_density(-log_odds, df_b, df_a)
    a, b = df_a / 2.0, df_b / 2.0
    from_middle = log_odds - math.log(a / b)
    with np.errstate(over="ignore"):
        beside = a * from_middle - (a + b) * np.log1p(a / (a + b) * np.expm1(from_middle))
    at_middle = 0.5 * math.log(a * b / (a + b) / (2.0 * math.pi))
    return np.asarray(at_middle + stirling_rest(a + b) - stirling_rest(a) - stirling_rest(b) + beside)


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

    return mean_over_share(of_shares, df_a, df_b)


_FAR = 1e150
"""Standard errors that count as infinitely many."""
_NARROW = 0.5
_FEW_NODES, _FEW_WEIGHTS = (np.asarray(part) for part in np.polynomial.legendre.leggauss(6))


def within_both(low: float, high: float, critical: Floats, df: float) -> Floats:
    """Return P(low + critical U <= Z <= high - critical U), Owen's Q function, for each of some critical values."""
    low, high, critical = _doubles(low), _doubles(high), np.clip(critical, 1.0 / _FAR, _FAR)
    if not low < high:
        return np.zeros_like(critical)
    last = np.maximum((high - low) / 2.0 / critical, 1.0 / _FAR**2)
    turns = np.stack([-low / critical, high / critical], axis=1)

    def inside(u: Floats, rows: Rows) -> Floats:
        half = critical[rows, None] * u
        return normal_between(low + half, high - half)

    return mean_over_scale(inside, df, turns, 1.0 / critical[:, None], last)


def normal_between(low: Floats, high: Floats) -> Floats:
    """Return P(low <= Z <= high), right to the last digits of itself also far out and where the ends are close."""
    upper = low > 0.0  # the lower tail keeps its digits
    low, high = np.where(upper, -high, low), np.where(upper, -low, high)
    inside = np.maximum(special.ndtr(high) - special.ndtr(low), 0.0)
    half = (high - low) / 2.0
    middle = low + half
    narrow = (half > 0.0) & (half * (1.0 + np.abs(middle)) < _NARROW / 2.0)
    if narrow.any():
        half, middle = half[narrow], middle[narrow]
        at = middle[..., None] + half[..., None] * _FEW_NODES
        inside[narrow] = half * np.einsum("ij,j->i", np.exp(-at * at / 2.0), _FEW_WEIGHTS) / math.sqrt(2.0 * math.pi)
    return np.asarray(inside)


def beyond_either(distance: float, critical: Floats, df: float, sides: int) -> Floats:
    """Return P(Z + distance > critical U), and for two sides P(Z + distance < -critical U) with it, one each."""
    if sides == 2:
        distance = abs(distance)
    distance, critical = _doubles(distance), np.clip(critical, 1.0 / _FAR, _FAR)

    def beyond(u: Floats, rows: Rows) -> Floats:
        edge = critical[rows, None] * u
        upper = special.ndtr(distance - edge)
        return np.asarray(upper + special.ndtr(-distance - edge) if sides == 2 else upper)

    return mean_over_scale(beyond, df, (distance / critical)[:, None], 1.0 / critical[:, None])


def _doubles(distance: float) -> float:
    """Return a number of standard errors that can be calculated with."""
    return min(max(distance, -_FAR), _FAR)
