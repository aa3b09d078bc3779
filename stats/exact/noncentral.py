"""Tails of the noncentral t and F distributions, both sides, each to some 13 digits of itself.

t: (Z + delta) / S <= t just where Z <= t S - delta, with S = sqrt(chi2(df) / df); so the lower tail is the mean of
Phi(t S - delta). In u = ln S the integrand is analytic and falls off fast, where equal steps converge geometrically.
F: the mean of central tails over a Poisson number of mean lambda / 2; all terms are positive.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

_REACH = 40.0  # logarithm below which a weight does not count
_NORMAL_REACH = 13.0
_MANY, _MOST = 1e6, 1e12
"""Noncentralities, per degree of freedom and at all, from which their mean is all that counts of their scatter."""


def t_tails(t: float, df: float, delta: float) -> tuple[float, float]:
    """Return P(T <= t) and P(T >= t) for noncentrality `delta`."""
    if t * t > 400.0 * df:
        return _steep_t_tails(t, df, delta)
    u, weights = _log_scale(df, abs(t))
    argument = t * np.exp(u) - delta
    return float(weights @ special.ndtr(argument)), float(weights @ special.ndtr(-argument))


def _log_scale(df: float, t: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return nodes in ln S and their weights, close enough for the normal's edge to be smooth between them."""
    low = -max(9.0 * math.sqrt(2.0 / df), (_REACH + df / 2.0) / df if df < 60.0 else 0.0)
    high = min(9.0 / math.sqrt(2.0 * df), 0.5 * math.log(1.0 + 2.0 * _REACH / df) + 1.0)
    steepness = math.sqrt(2.0 * df + (t * math.exp(high / 3.0)) ** 2)
    u = np.linspace(low, high, int((high - low) * max(steepness / 0.5, 9.0)) + 60)
    log_density = df * (u - np.expm1(2.0 * u) / 2.0)
    weights = np.exp(log_density - log_density.max())
    return u, weights / weights.sum()


def _steep_t_tails(t: float, df: float, delta: float) -> tuple[float, float]:
    """Return the tails where t is so large that S, not Z, decides: the mean over Z of the tails of S.

    Below Z = -delta (for positive t) the ratio is negative whatever S is; Gauss's nodes begin there.
    """
    if t < 0.0:
        lower, upper = _steep_t_tails(-t, df, -delta)
        return upper, lower
    start = min(max(-_NORMAL_REACH, -delta), _NORMAL_REACH)
    nodes, widths = _gauss_nodes()
    half = (_NORMAL_REACH - start) / 2.0
    z = start + half * (nodes + 1.0)
    weights = half * widths * np.exp(-z * z / 2.0) / math.sqrt(2.0 * math.pi)
    with np.errstate(over="ignore"):
        argument = df / 2.0 * (np.maximum(z + delta, 0.0) / t) ** 2
    lower = float(weights @ special.gammaincc(df / 2.0, argument)) + float(special.ndtr(start))
    return lower, float(weights @ special.gammainc(df / 2.0, argument))


@lru_cache(maxsize=1)
def _gauss_nodes() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    nodes, widths = np.polynomial.legendre.leggauss(200)
    return nodes, widths


def f_tails(f: float, df_between: float, df_within: float, noncentrality: float) -> tuple[float, float]:
    """Return P(F <= f) and P(F >= f)."""
    if noncentrality > _MANY * df_within and (noncentrality > _MOST or df_between * f > _MANY * df_within):
        return _f_tails_of_many(f, df_between, df_within, noncentrality)
    a, b = df_between / 2.0, df_within / 2.0
    x, y = df_between * f / (df_between * f + df_within), df_within / (df_between * f + df_within)
    mean = noncentrality / 2.0
    spread = 12.0 * math.sqrt(mean) + 40.0
    first, last = max(0.0, float(np.floor(mean - spread))), float(np.ceil(mean + spread))
    step = max(1.0, float(np.floor(math.sqrt(mean) / 20.0)))
    counts = np.arange(first, last + 1.0, step)
    log_weight = special.xlogy(counts, mean) - mean - special.gammaln(counts + 1.0)
    weights = np.exp(log_weight - log_weight.max())
    weights /= weights.sum()
    return float(weights @ special.betainc(a + counts, b, x)), float(weights @ special.betainc(b, a + counts, y))


def _f_tails_of_many(f: float, df_between: float, df_within: float, noncentrality: float) -> tuple[float, float]:
    """Return the tails where chi^2(df_between, noncentrality) is its mean but for what its inverse is to first order.

    Sums over Poisson's numbers lose more digits there than they have.
    """
    scale = noncentrality / df_between / f if f > 0.0 else math.inf
    x = scale * df_within
    if x > _MOST:
        return 0.0, 1.0
    half = df_within / 2.0
    log_density = special.xlogy(half - 1.0, x / 2.0) - x / 2.0 - math.lgamma(half) - math.log(2.0)
    moved = x * math.exp(log_density) * (df_between + df_within - 2.0 - x) / noncentrality
    lower, upper = float(special.gammaincc(half, x / 2.0)) - moved, float(special.gammainc(half, x / 2.0)) + moved
    return min(max(lower, 0.0), 1.0), min(max(upper, 0.0), 1.0)
