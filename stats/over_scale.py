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
from scipy import optimize

from stats.finite import Number

_Floats = NDArray[np.float64]
LogTail = Callable[[_Floats], _Floats]
"""log g at each s of shape (m,); falls with s."""

NEGLIGIBLE = 42.0
"""What lies e**42 below the largest value adds nothing to 16 digits."""
STARTS = 48
"""Intervals of the first rule; each further rule halves them."""
FAR = 2.0**300
"""From here on a tail falls as statistic**-df: what else it does is its square's inverse, 1e-180."""


def log_mean_over_scale(log_tail: LogTail, df: float, statistic: float) -> float:
    """Return log of the mean of exp(log_tail(s)) over s, s^2 = chi^2(df) / df; `statistic` is what s multiplies."""
    if math.isinf(df):
        return float(log_tail(np.ones(1))[0])

    def log_density(u: _Floats) -> _Floats:
        return np.asarray(df * (u - np.expm1(2.0 * u) / 2.0))

    def log_product(u: _Floats) -> _Floats:
        return log_density(u) + log_tail(np.exp(u))

    left = -(NEGLIGIBLE / df + math.log(max(abs(statistic), 1.0)) + 3.0)
    return min(_log_integral(log_product, left, 2.5) - _log_integral(log_density, left, 2.5), 0.0)


def log_upper_of_any(log_upper: Callable[[float], float], statistic: Number, df: float) -> float:
    """Return the logarithm of an upper tail at a statistic of any size, from the tail up to `FAR`."""
    if statistic <= FAR:
        return log_upper(float(max(statistic, -FAR)))
    excess = Fraction(statistic) / Fraction(FAR)
    return log_upper(FAR) - df * (math.log(excess.numerator) - math.log(excess.denominator))


def critical_value(log_upper: Callable[[float], float], tail: float, guess: float) -> float:
    """Return the statistic whose upper tail, exp(log_upper(x)) falling with x, is `tail`."""
    wanted = math.log(min(tail, 1.0 - 2.0**-53))  # 1 is all that is left of a level near 0
    low, high = guess, guess
    while log_upper(low) < wanted:
        low -= max(abs(low), 1.0) * 0.5
    while log_upper(high) > wanted:
        high += max(abs(high), 1.0) * 0.5
    if low == high:
        return guess
    return float(optimize.brentq(lambda x: log_upper(x) - wanted, low, high, xtol=1e-13, rtol=1e-13))


def log_sum(logs: _Floats) -> _Floats:
    """Return log of the sum of exp over the last axis."""
    largest = np.max(logs, axis=-1, keepdims=True)
    largest = np.where(np.isfinite(largest), largest, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.sum(np.exp(logs - largest), axis=-1)) + largest[..., 0])


def _log_integral(log_f: Callable[[_Floats], _Floats], left: float, right: float) -> float:
    """Return log of the integral of a function with one hump: find where it counts, halve steps until digits stand."""
    for _ in range(4):
        grid = np.linspace(left, right, STARTS + 1)
        values = log_f(grid)
        counts = np.flatnonzero(values > np.max(values) - NEGLIGIBLE)
        first, last = max(counts[0] - 1, 0), min(counts[-1] + 1, STARTS)
        if last - first > STARTS // 2:
            break
        left, right = float(grid[first]), float(grid[last])
    step = (right - left) / STARTS
    before = math.inf
    found = float(log_sum(values)) + math.log(step)
    # Half the step squares the error: after a change of 1e-10 what is left is far below a double's digits.
    while abs(found - before) > 1e-10 and grid.size < 20000:
        between = grid[:-1] + step / 2.0
        grid = np.linspace(left, right, 2 * (grid.size - 1) + 1)
        before, step = found, step / 2.0
        found = float(np.logaddexp(before - math.log(2.0), float(log_sum(log_f(between))) + math.log(step)))
    return found
