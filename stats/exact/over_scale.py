"""Tail areas of statistics divided by an estimated standard deviation, integrated over that estimate.

With s^2 = chi^2 / df the chance is the mean of g(s), g(s) being the chance for a known standard deviation s times too
small. Over u = log s the integrand is smooth and falls off on both sides faster than any power, where the trapezoidal
rule gains digits exponentially; logarithms keep tails of any size. Nothing is random: the same input gives the same
digits at every call.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from stats.exact.finite import Number
from stats.exact.known_scale import Floats, KnownScale

NEGLIGIBLE = 42.0
"""What lies e**42 below the largest value adds nothing to 16 digits."""
STARTS = 24
"""Intervals of the first rule; each further rule halves them."""
_EVEN = np.arange(STARTS + 1) / STARTS
FAR = 2.0**300
"""From here on a tail falls as statistic**-df: what else it does is its square's inverse, 1e-180."""
_ZOOMS = 4
_MOST = 20000
"""Points of the last rule."""
_AT_ONCE = 128
"""Statistics whose means are taken together."""
_Rows = NDArray[np.intp]
_LogFunctions = Callable[[_Rows, Floats], Floats]
"""Logarithms of those of m functions that are asked for, shape (p,), each at its own u, shape (p, points)."""


def log_mean_over_scale(known: KnownScale, df: float, statistic: float) -> float:
    """Return log of the mean of g(statistic s) over s, s^2 = chi^2(df) / df; df may be infinite."""
    return float(log_means_over_scale(known, np.array([df]), np.array([statistic]))[0])


def log_means_over_scale(known: KnownScale, df: Floats, statistic: Floats) -> Floats:
    """Return `log_mean_over_scale` of each df and statistic, all of shape (m,)."""
    found = np.empty(df.shape)
    sure = np.isinf(df)
    if np.any(sure):
        found[sure] = known.log_tail(statistic[sure])
    rows = np.flatnonzero(~sure)
    for start in range(0, rows.size, _AT_ONCE):
        some = rows[start : start + _AT_ONCE]
        found[some] = _log_means(known, df[some], statistic[some])
    return found


def log_upper_of_any(log_upper: Callable[[float], float], statistic: Number, df: float) -> float:
    """Return the logarithm of an upper tail at a statistic of any size, from the tail up to `FAR`."""
    if statistic <= FAR:
        return log_upper(float(max(statistic, -FAR)))
    excess = Fraction(statistic) / Fraction(FAR)
    return log_upper(FAR) - df * (math.log(excess.numerator) - math.log(excess.denominator))


def log_sum(logs: Floats) -> Floats:
    """Return log of the sum of exp over the last axis."""
    largest = np.max(logs, axis=-1, keepdims=True)
    largest = np.where(np.isfinite(largest), largest, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.sum(np.exp(logs - largest), axis=-1)) + largest[..., 0])


def _log_means(known: KnownScale, df: Floats, statistic: Floats) -> Floats:
    def log_density(rows: _Rows, u: Floats) -> Floats:
        return np.asarray(df[rows, None] * (u - np.expm1(2.0 * u) / 2.0))

    def log_product(rows: _Rows, u: Floats) -> Floats:
        return log_density(rows, u) + known.log_tail(statistic[rows, None] * np.exp(u))

    def log_bound(rows: _Rows, u: Floats) -> Floats:
        return log_density(rows, u) + known.log_bound(statistic[rows, None] * np.exp(u))

    left = -(NEGLIGIBLE / df + np.log(np.maximum(np.abs(statistic), 1.0)) + 3.0)
    least = NEGLIGIBLE + known.slack
    part = _log_integrals(log_product, *_where_it_counts(log_bound, left, least))
    return np.minimum(part - _log_integrals(log_density, *_where_it_counts(log_density, left, least)), 0.0)


def _where_it_counts(log_bound: _LogFunctions, left: Floats, least: float) -> tuple[Floats, Floats]:
    """Return between which u functions with one hump each, bounded like this, are within e**least of their largest."""
    right = np.full(left.shape, 2.5)
    rows = np.arange(left.size)
    for _ in range(_ZOOMS):
        u = left[:, None] + (right - left)[:, None] * _EVEN
        values = log_bound(rows, u)
        counts = values > np.max(values, axis=-1, keepdims=True) - least
        first = np.maximum(np.argmax(counts, axis=-1) - 1, 0)
        last = np.minimum(STARTS + 1 - np.argmax(counts[:, ::-1], axis=-1), STARTS)
        left, right = u[rows, first], u[rows, last]
    return left, right


def _log_integrals(log_f: _LogFunctions, left: Floats, right: Floats) -> Floats:
    """Return log of the integral of each of m functions from its own left to its own right, shape (m,).

    Steps are halved until digits stand: half the step squares the error, so that after a change of 1e-10 what is left
    is far below a double's digits.
    """
    rows = np.arange(left.size)
    steps = STARTS
    values = log_f(rows, left[:, None] + (right - left)[:, None] * _EVEN)
    found = log_sum(values) + np.log((right - left) / steps)
    while rows.size and steps < _MOST:
        width = ((right - left)[rows] / steps)[:, None]
        between = left[rows, None] + width * (np.arange(steps) + 0.5)
        steps *= 2
        finer = np.logaddexp(found[rows] - math.log(2.0), log_sum(log_f(rows, between)) + np.log(width[:, 0] / 2.0))
        moved = np.abs(finer - found[rows]) > 1e-10
        found[rows] = finer
        rows = rows[moved]
    return found
