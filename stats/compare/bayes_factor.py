"""Bayes factor of a t-test (Jeffreys, Zellner and Siow; Rouder et al. 2009), as its logarithm, which never overflows.

The effect size has a Cauchy prior of scale r under the alternative and is 0 under the null. With N = n (one sample) or
n_a n_b / (n_a + n_b) and nu degrees of freedom

    BF = integral over g of (1 + N g r^2)^(-1/2) (1 + t^2 / ((1 + N g r^2) nu))^(-(nu + 1) / 2) ig(g) dg
         / (1 + t^2 / nu)^(-(nu + 1) / 2),      ig(g) = (2 pi)^(-1/2) g^(-3/2) exp(-1 / (2 g))

is integrated over log g, where the integrand is smooth and dies out at both ends, by the trapezoidal rule: its error
falls exponentially with the step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import InputRefused
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from stats.checks import as_count, as_number
from stats.results import Result

CAUCHY_SCALE = math.sqrt(0.5)
"""Usual scale of the prior ("medium" of the R package BayesFactor)."""
STEP = 1.0 / 16.0
DEEP = 90.0
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
    """
    if np.ndim(t) > 0:
        raise InputRefused(f"t holds {np.size(t)} values: give Student's t, as compare_two(a, b).pooled_t.")
    t = as_number("t", t)
    n_a, n_b = as_count("n_a", n_a), as_count("n_b", n_b)
    r = as_number("the Cauchy scale", cauchy_scale, above=0.0)
    df = n_a + n_b - 2 if n_b else n_a - 1
    if df < 1 or n_a < 1:
        return BayesFactor(Undefined("there are too few values for a t statistic"), t, n_a, n_b, r)
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
    points = np.arange(peak - 2.0 * DEEP, peak + 2.0 * DEEP, STEP)
    logs = log_integrand(points)
    top = float(np.max(logs))
    return null + top + math.log(math.fsum(np.exp(np.maximum(logs - top, -700.0))) * STEP)
