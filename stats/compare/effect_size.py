"""Intervals of standardised effects, by inverting the noncentral t and F distributions.

The effect of a t-test is its noncentrality over a known factor; the interval holds every noncentrality under which the
statistic found is not in a tail. The share of variance of an F-test is lambda / (lambda + n) with lambda the
noncentrality and n the number of values (Steiger 2004, "Beyond the F test", equations 10 and 21): eta squared and omega
squared estimate the same share in the population and so have the same interval. (The R package effectsize divides by
lambda + df_within instead, and moves the ends by omega's correction; neither has the stated coverage.)

The Bayes factor of a t-test (Jeffreys, Zellner and Siow; Rouder et al. 2009) is taken as its logarithm, which never
overflows. The effect size has a Cauchy prior of scale r under the alternative and is 0 under the null. With N = n (one
sample) or n_a n_b / (n_a + n_b) and nu degrees of freedom

    BF = integral over g of (1 + N g r^2)^(-1/2) (1 + t^2 / ((1 + N g r^2) nu))^(-(nu + 1) / 2) ig(g) dg
         / (1 + t^2 / nu)^(-(nu + 1) / 2),      ig(g) = (2 pi)^(-1/2) g^(-3/2) exp(-1 / (2 g))

is integrated over log g, where the integrand is smooth and dies out at both ends, by the trapezoidal rule: its error
falls exponentially with the step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from stats.checks import as_count, as_number
from stats.exact.numbers import Interval, finite_pair, root_between
from stats.exact.tails import f_tails, t_tails
from stats.results import Result

_STEPS = 200
_LEAST_OUTSIDE = 1e-14
"""Chance of both tails below which those of the noncentral distributions are lost."""
_LEVEL_TOO_HIGH = Undefined(Reason.LEVEL_TOO_HIGH)
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
    """Return where a rising function is 0, by steps away from `start` until it changes sign."""
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
    return root_between(rising, (inside, value_inside), (outside, value_outside))


def _log(ratio: float) -> float:
    return math.log(ratio) if ratio > 0.0 else -math.inf


CAUCHY_SCALE = math.sqrt(0.5)
"""Usual scale of the prior ("medium" of the R package BayesFactor)."""
STEP = 1.0 / 16.0
_DEEP = 90.0
"""Natural logarithm below the peak at which the integrand counts no more."""


@dataclass(frozen=True, slots=True)
class BayesFactor(Result):
    """How much better the data are predicted by some effect than by none."""

    log10_bf: float | Undefined
    """Decimal logarithm of the Bayes factor of the alternative; negative values speak for no effect."""
    t: float
    """Student's t, as given; dimensionless."""
    n_a: int
    """Number of values of the first group."""
    n_b: int
    """Number of values of the second group; 0 for one sample."""
    cauchy_scale: float
    """Scale of the prior of the effect in standard deviations."""

    def sentence(self) -> str:
        """Return the Bayes factor in words, as a power of ten where it is large."""
        n = f"n = {self.n_a} and {self.n_b}" if self.n_b else f"n = {self.n_a}"
        if isinstance(self.log10_bf, Undefined):
            return f"No Bayes factor ({n}): {self.log10_bf.reason}."
        side = "an effect as under none" if self.log10_bf >= 0.0 else "no effect as under one"
        times = _times_text(abs(self.log10_bf))
        return (
            f"The data are {times} times as likely under {side} (JZS Bayes factor, scale {self.cauchy_scale:.3g}; {n})."
        )


def bayes_factor(t: float, n_a: int, n_b: int = 0, cauchy_scale: float = CAUCHY_SCALE) -> BayesFactor:
    """Return the Bayes factor of Student's t of two groups, or of one sample or paired differences (n_b = 0).

    Raises `InputRefused` for a t that is not one finite number, sizes below 0 or a scale that is not positive.

    >>> round(bayes_factor(2.5, 10, 10).log10_bf, 3)
    0.467
    """
    if np.ndim(t) > 0:
        raise InputRefused(f"t holds {np.size(t)} values: give Student's t, as compare_two(a, b).pooled_t.")
    t = as_number("t", t)
    n_a, n_b = as_count("n_a", n_a), as_count("n_b", n_b)
    r = as_number("the Cauchy scale", cauchy_scale, above=0.0)
    df = n_a + n_b - 2 if n_b else n_a - 1
    if df < 1 or n_a < 1:
        return BayesFactor(Undefined(Reason.TOO_FEW_FOR_T), t, n_a, n_b, r)
    size = n_a * (n_b / (n_a + n_b)) if n_b else float(n_a)
    log_t = 2.0 * math.log(abs(t)) - math.log(df) if t else -math.inf
    return BayesFactor(_log_ratio(log_t, size, float(df), r) / math.log(10.0), t, n_a, n_b, r)


def _times_text(log10: float) -> str:
    """Return a number of at least 1 by its decimal logarithm, "3.6e1364" where it is large."""
    if log10 < 6.0:
        return number_text(10.0**log10, 3)
    mantissa, power = f"{10.0 ** (log10 % 1.0):.2g}", math.floor(log10)
    return f"1e{power + 1}" if mantissa == "10" else f"{mantissa}e{power}"


def _log_ratio(log_t: float, size: float, df: float, r: float) -> float:
    """Return the natural logarithm of the Bayes factor, `log_t` being log(t^2 / df)."""
    half = (df + 1.0) / 2.0
    spread = math.log(size) + 2.0 * math.log(r)
    null = half * float(np.logaddexp(0.0, log_t))

    def log_integrand(u: NDArray[np.float64]) -> NDArray[np.float64]:
        widened = np.logaddexp(0.0, u + spread)
        with np.errstate(over="ignore", under="ignore"):
            prior = -0.5 * u - 0.5 * np.exp(-u) - 0.5 * math.log(2.0 * math.pi)
        return np.asarray(prior - 0.5 * widened - half * np.logaddexp(0.0, log_t - widened))

    # The peak lies between the prior's own and where N g r^2 reaches t^2 / nu; tails fall as exp(-u) at the slowest.
    low, high = -6.0 - math.log(half), max(log_t, 0.0) + abs(spread) + 10.0
    coarse = np.linspace(low, high, 4001)
    peak = float(coarse[int(np.argmax(log_integrand(coarse)))])
    points = np.arange(peak - 2.0 * _DEEP, peak + 2.0 * _DEEP, STEP)
    logs = log_integrand(points)
    top = float(np.max(logs))
    return null + top + math.log(math.fsum(np.exp(np.maximum(logs - top, -700.0))) * STEP)
