"""Gauss's rule of 20 nodes on fixed panels, and with it means over an estimated scale, and critical values.

With s^2 = chi^2 / df the chance of a test whose standard deviation is estimated is the mean over s of its chance g(s)
for a known one. Over u = log s the integrand is smooth, has one hump and falls off fast: it is looked for where it lies
within e**-42 of its largest value, and the rule is taken there. Logarithms keep tails of any size. Nothing is random
and nothing adapts: the same input gives the same digits at every call.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from stats.exact.numbers import Floats, Number
from stats.exact.tails import t_upper_quantile

Rows = NDArray[np.intp]
LogOfScale = Callable[[Floats, Rows], Floats]
"""From u = log s, shape (rows, points), and the rows they belong to, to logarithms of a chance, (rows, points)."""
LogUpper = Callable[[Floats, Rows], Floats]
"""Logarithms of the upper tails of those of m distributions that are asked for, at a statistic each, shape (rows,)."""

NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)
FAR = 2.0**300
"""From here on a tail falls as statistic**-df: what else it does is its square's inverse, 1e-180."""
_NEGLIGIBLE = 42.0
"""What lies e**42 below the largest value adds nothing to 16 digits."""
_MOST_SCANS, _SCANNED, _ENOUGH = 12, 25, 6
"""Scans for where an integrand counts, places of each, and how many of them must count: each shortens a range of
hundreds twelvefold, so that three or four do.
"""
_WIDEST, _LONGEST = 5.0, 1.5
"""Length of a panel at most, in standard deviations of u and in u."""
_ROUNDING = 1e-15
"""By how much a logarithm that the rule gives is rounded; roots are searched as closely."""
_TOLD_FROM_1 = 1e-12
"""Tails nearer to 1 have no critical value in doubles: any between the bounds is as good."""
_ROWS_AT_ONCE = 64
"""Rows whose nodes are in memory together."""
_MANY_DF, _NEAR, _TERMS = 1000.0, 0.03, 9
"""Degrees of freedom from which on exp(x) - 1 - x is taken by a series, for which x, and of how many terms."""
_STIRLING_FROM = 16.0


def gauss_nodes(edges: Floats) -> tuple[Floats, Floats]:
    """Return nodes and weights of the rule on each panel between neighbours of `edges`, shape (..., edges), rising.

    Both have shape (..., 20 (edges - 1)); a panel of no length has weights of 0.
    """
    half = np.diff(edges, axis=-1)[..., None] / 2.0
    places = edges[..., :-1, None] + half * (1.0 + NODES)
    shape = (*edges.shape[:-1], -1)
    return places.reshape(shape), (half * WEIGHTS).reshape(shape)


def log_sum(logs: Floats) -> Floats:
    """Return log of the sum of exp over the last axis."""
    largest = np.max(logs, axis=-1, keepdims=True)
    largest = np.where(np.isfinite(largest), largest, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.sum(np.exp(logs - largest), axis=-1)) + largest[..., 0])


def log_means_over_scale(
    log_chance: LogOfScale,
    df: Floats,
    lowest: Floats,
    *,
    steepness: float = 1.0,
    turns: Floats | None = None,
    last: Floats | None = None,
) -> Floats:
    """Return log of the mean over s of a chance, shape (rows,), that is log-concave in u; `df` is finite.

    Parameters
    ----------
    log_chance : logarithms of the chance, by u and row
    df : degrees of freedom of s, shape (rows,)
    lowest : below these u the chance is all but constant, shape (rows,)
    steepness : how many times faster than a normal's tail it falls
    turns : places u at which it turns sharply, shape (rows, turns), NaN for none
    last : beyond these u it is 0, shape (rows,)
    """
    found = np.empty(df.shape)
    ends = np.full(df.shape, math.inf) if last is None else last
    places = np.empty((df.size, 0)) if turns is None else turns
    for start in range(0, df.size, _ROWS_AT_ONCE):
        rows = np.arange(start, min(start + _ROWS_AT_ONCE, df.size))
        found[rows] = _log_means(log_chance, df[rows], lowest[rows], steepness, places[rows], ends[rows], rows)
    return np.where(found > -_ROUNDING, 0.0, found)


def _log_means(
    log_chance: LogOfScale, df: Floats, lowest: Floats, steepness: float, turns: Floats, last: Floats, rows: Rows
) -> Floats:
    def log_integrand(u: Floats) -> Floats:
        return log_scale_density(u, df) + log_chance(u, rows)

    high = np.minimum(_highest(df), last)
    low = np.minimum(np.minimum(lowest, -np.sqrt(_NEGLIGIBLE / df)), high) - _NEGLIGIBLE / df
    low, high = _where_it_counts(log_integrand, low, high)
    longest = np.minimum(_WIDEST / np.sqrt(2.0 * df), _LONGEST) / steepness
    edges = np.linspace(low, high, 1 + math.ceil(float(np.max((high - low) / longest))), axis=1)
    inside = np.where(np.isnan(turns), low[:, None], np.clip(turns, low[:, None], high[:, None]))
    u, weights = gauss_nodes(np.sort(np.concatenate([edges, inside], axis=1), axis=1))
    with np.errstate(divide="ignore"):
        return log_sum(log_integrand(u) + np.log(weights))


def _where_it_counts(log_integrand: Callable[[Floats], Floats], low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return between which u functions with one hump each count."""
    rows = np.arange(low.size)
    for _ in range(_MOST_SCANS):
        u = np.linspace(low, high, _SCANNED, axis=1)
        values = log_integrand(u)
        counts = values >= np.max(values, axis=1, keepdims=True) - _NEGLIGIBLE
        first, last = counts.argmax(axis=1), _SCANNED - 1 - counts[:, ::-1].argmax(axis=1)
        low, high = u[rows, np.maximum(first - 1, 0)], u[rows, np.minimum(last + 1, _SCANNED - 1)]
        if (last - first >= _ENOUGH).all():
            break
    return low, high


def _highest(df: Floats) -> Floats:
    """Return a u where the density of u is `_NEGLIGIBLE` below its middle's, in logarithms, or a little more."""
    far = 2.0 * _NEGLIGIBLE / df
    # exp(x) - 1 - x is at least x^2 / 2, and beyond 2 at least exp(x) / 2.
    return np.asarray(np.minimum(np.sqrt(2.0 * far), np.maximum(2.0, np.log(2.0 * far))) / 2.0)


def log_scale_density(u: Floats, df: Floats) -> Floats:
    """Return the log density of u = log s, s^2 = chi^2(df) / df; u has shape (rows, points), df (rows,)."""
    twice = 2.0 * u
    beyond = np.expm1(twice) - twice
    near = (np.abs(twice) < _NEAR) & (df[:, None] > _MANY_DF)  # with fewer what is lost does not count
    if near.any():
        small, series = twice[near], np.zeros(np.count_nonzero(near))
        for k in range(_TERMS, 1, -1):  # exp(x) - 1 - x = x^2 / 2 (1 + x / 3 (1 + x / 4 (1 + ...)))
            series = small / k * (1.0 + series) if k > 2 else small * small / 2.0 * (1.0 + series)
        beyond[near] = series
    at_middle = 0.5 * np.log(df / math.pi) - np.array([stirling_rest(each / 2.0) for each in df.tolist()])
    return np.asarray(at_middle[:, None] - df[:, None] / 2.0 * beyond)


@lru_cache(maxsize=4096)
def stirling_rest(x: float) -> float:
    """Return ln Gamma(x) - (x - 1/2) ln x + x - ln(2 pi) / 2 of a positive x."""
    below = 0.0
    while x < _STIRLING_FROM:
        below += (x + 0.5) * math.log1p(1.0 / x) - 1.0
        x += 1.0
    square = x * x
    series = (
        1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - (1.0 / 1680.0 - 1.0 / 1188.0 / square) / square) / square) / square
    )
    return below + series / x


def log_upper_of_any(log_upper: Callable[[float], float], statistic: Number, df: float) -> float:
    """Return the logarithm of an upper tail at a statistic of any size, from the tail up to `FAR`."""
    if statistic <= FAR:
        return log_upper(float(max(statistic, -FAR)))
    excess = Fraction(statistic) / Fraction(FAR)
    return log_upper(FAR) - df * (math.log(excess.numerator) - math.log(excess.denominator))


def critical_values(log_upper: LogUpper, tail: float, df: Floats, comparisons: int, *, two_sided: bool) -> Floats:
    """Return the t that the largest of so many t-statistics exceeds with chance `tail`, for each df, shape (rows,).

    It lies between the critical value of one comparison and that of all by Bonferroni's inequality.
    """
    from scipy.optimize.elementwise import find_root  # takes a tenth of a second to load

    tail = min(tail, 1.0 - 2.0**-53)  # 1 is all that is left of a level near 0
    one = Fraction(tail) / (2 if two_sided else 1)
    low, high = (np.array([t_upper_quantile(part, each) for each in df.tolist()]) for part in (one, one / comparisons))
    if comparisons == 1:
        return low
    margin = 2.0**-30  # where both are as near as that, rounding decides on which side the root is
    bracket = low - margin * (1.0 + np.abs(low)), high + margin * (1.0 + np.abs(high))
    rows = np.arange(df.size)
    near = {"fatol": _ROUNDING, "xrtol": _ROUNDING}
    found = find_root(lambda t, row: log_upper(t, row) - math.log(tail), bracket, args=(rows,), tolerances=near)
    if tail < 1.0 - _TOLD_FROM_1 and np.isfinite(high[~found.success]).any():
        raise ArithmeticError(f"no critical value of {comparisons} comparisons has the tail {tail!r}")
    return np.clip(np.where(found.success, found.x, low), low, high)


def steepness_of_largest(count: int) -> float:
    """Return how many times steeper the distribution of the largest of `count` normals rises than that of one."""
    return max(-float(special.ndtri(1.0 / count)), 1.0)
