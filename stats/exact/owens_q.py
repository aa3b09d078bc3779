"""Chances that t-tests of known critical values reject: two one-sided ones (Owen's Q), and either side of one.

With U = sqrt(chi^2_nu / nu), a standard error estimated with nu degrees of freedom in units of the true one, they are
means of normal probabilities over U. Each is right to 1e-10 of itself, down to 1e-290.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import special

from stats.exact.quadrature import Floats, Rows
from stats.planning.estimated_scatter import mean_over_scale

_FAR = 1e150
"""Standard errors that count as infinitely many."""
_NARROW = 0.5
_NODES, _WEIGHTS = (np.asarray(part) for part in np.polynomial.legendre.leggauss(6))


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
        at = middle[..., None] + half[..., None] * _NODES
        inside[narrow] = half * np.einsum("ij,j->i", np.exp(-at * at / 2.0), _WEIGHTS) / math.sqrt(2.0 * math.pi)
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
