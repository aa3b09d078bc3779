"""Intervals of standardised effects, by inverting the noncentral t and F distributions.

The effect of a t-test is its noncentrality over a known factor; the interval holds every noncentrality under which the
statistic found is not in a tail. The share of variance of an F-test is lambda / (lambda + n) with lambda the
noncentrality and n the number of values (Steiger 2004, "Beyond the F test", equations 10 and 21): eta squared and omega
squared estimate the same share in the population and so have the same interval. (The R package effectsize divides by
lambda + df_within instead, and moves the ends by omega's correction; neither has the stated coverage.)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy import special

from data_schema.vocabulary import Undefined
from stats.exact.finite import Interval, finite_pair
from stats.exact.noncentral import f_tails, t_tails

_STEPS = 200
_LEAST_OUTSIDE = 1e-14
"""Chance of both tails below which those of the noncentral distributions are lost."""
_LEVEL_TOO_HIGH = Undefined("the level is too near 1 for the tails of the noncentral distribution")
_FAR = 2.0**300
"""Statistics from which noncentralities grow in proportion to them."""


@lru_cache(maxsize=256)
def hedges_factor(df: float) -> float:
    """Return the exact factor that frees Cohen's d of its bias, for df of at least 2 (Hedges 1981)."""
    if df > 1e5:  # the series is right to the last digit here, the gamma functions are not
        return 1.0 - 3.0 / (4.0 * df) - 7.0 / (32.0 * df * df)
    from mpmath import mp

    with mp.workprec(120):
        half = mp.mpf(df) / 2
        return float(mp.exp(mp.loggamma(half) - mp.loggamma(half - 0.5)) / mp.sqrt(half))


@lru_cache(maxsize=256)
def noncentral_t_interval(t: float, df: float, level: float) -> Interval:
    """Return the noncentralities, low and high, between which `t` has no tail below (1 - level) / 2."""
    if abs(t) > _FAR:  # from there on the noncentrality is t times the scatter of the standard error
        near = math.copysign(_FAR, t)
        low, high = (end / near for end in noncentral_t_interval(near, df, level))
        return low * t, high * t
    tail = (1.0 - level) / 2.0
    width = 2.0 * math.sqrt(1.0 + t * t / (2.0 * df)) * float(-special.ndtri(tail)) + 1.0

    def upper(delta: float) -> float:
        return _log(t_tails(t, df, delta)[1] / tail)

    def lower(delta: float) -> float:
        return -_log(t_tails(t, df, delta)[0] / tail)

    return _root(upper, t, -width, None), _root(lower, t, width, None)


@lru_cache(maxsize=256)
def noncentral_f_interval(f: float, df_between: float, df_within: float, level: float) -> Interval:
    """Return the noncentralities, low and high, between which `f` has no tail below (1 - level) / 2; 0 at least."""
    tail = (1.0 - level) / 2.0
    start = f * df_between
    width = 4.0 * math.sqrt(2.0 * df_between + 4.0 * start + 2.0 * start * start / df_within) + 1.0

    def upper(noncentrality: float) -> float:
        return _log(f_tails(f, df_between, df_within, noncentrality)[1] / tail)

    def lower(noncentrality: float) -> float:
        return -_log(f_tails(f, df_between, df_within, noncentrality)[0] / tail)

    below, above = f_tails(f, df_between, df_within, 0.0)
    low = 0.0 if above >= tail else _root(upper, start, -width, 0.0)
    high = 0.0 if below <= tail else _root(lower, start, width, 0.0)
    return low, high


def hedges_g_ci(t: float, df: float, n_a: int, n_b: int, level: float = 0.95) -> Interval | Undefined:
    """Return the interval of Hedges's g from Student's t of two groups: signed, exact for normal values."""
    if 1.0 - level < _LEAST_OUTSIDE:
        return _LEVEL_TOO_HIGH
    low, high = noncentral_t_interval(t, df, level)
    factor = hedges_factor(df) * math.sqrt(1.0 / n_a + 1.0 / n_b)
    return finite_pair(low * factor, high * factor)


def eta_squared_ci(
    f: float | Undefined, df_between: float, df_within: float, level: float = 0.95
) -> Interval | Undefined:
    """Return the interval of the population's share of variance between groups, which omega squared estimates too."""
    if isinstance(f, Undefined):
        return f
    if 1.0 - level < _LEAST_OUTSIDE:
        return _LEVEL_TOO_HIGH
    low, high = noncentral_f_interval(min(f, _FAR), df_between, df_within, level)  # both shares are 1 from there on
    n = df_between + df_within + 1.0
    return low / (low + n), high / (high + n)


def _root(rising: Callable[[float], float], start: float, step: float, least: float | None) -> float:
    """Return where a rising function is 0, by steps away from `start` until it changes sign and then by halving.

    The Illinois form of regula falsi: it keeps the sign change and converges in some ten steps.
    """
    inside, outside = start, start
    value_inside = value_outside = rising(start)
    seek = step if (value_inside < 0.0) == (step > 0.0) else -step
    for _ in range(_STEPS):
        inside, value_inside = outside, value_outside
        outside = outside + seek if least is None else max(outside + seek, least)
        value_outside = rising(outside)
        if (value_outside > 0.0) != (value_inside > 0.0) or outside == least:
            break
        seek *= 2.0
    low, value_low, high, value_high = inside, value_inside, outside, value_outside
    for _ in range(_STEPS):
        middle = high - value_high * (high - low) / (value_high - value_low)
        if not min(low, high) < middle < max(low, high):
            middle = (low + high) / 2.0
        value = rising(middle)
        if value == 0.0 or abs(middle - high) <= 4.0 * np.finfo(np.float64).eps * abs(middle):
            return middle
        if (value > 0.0) != (value_high > 0.0):
            low, value_low = high, value_high
        else:
            value_low /= 2.0
        high, value_high = middle, value
    return high


def _log(ratio: float) -> float:
    return math.log(ratio) if ratio > 0.0 else -math.inf
