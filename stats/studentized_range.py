"""Upper tail of the studentized range, with digits where other programs have none.

For k standard normals with largest value z the range exceeds w with the chance

    k times the integral of phi(z) (Phi(z)^(k-1) - (Phi(z) - Phi(z - w))^(k-1)) dz,

whose integrand is positive and is computed without a difference of nearly equal numbers. For k = 2 the range is the
square root of 2 times |t|.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import special

from stats.critical_values import critical_values
from stats.error_free import exact_root
from stats.finite import Number
from stats.known_scale import Floats, KnownScale
from stats.over_scale import log_mean_over_scale, log_sum, log_upper_of_any
from stats.tails import Tail, t_two_sided

_REACH = 9.6
"""How far from the middle of the range its largest value counts."""
_LOG_ROOT_2PI = 0.5 * math.log(2.0 * math.pi)


@dataclass(frozen=True)
class RangeOfNormals(KnownScale):
    """The range of k standard normals, which is the studentized range where the standard deviation is known."""

    k: int
    fall: ClassVar[float] = 0.25

    def log_chance(self, w: Floats) -> Floats:
        """Return log g at each w of shape (m,), integrated over the largest value."""
        k, step = self.k, _step(self.k)
        around = np.arange(-math.ceil(_REACH / step), math.ceil(_REACH / step) + 1) * step
        z = w[:, None] / 2.0 + around
        log_a, log_b = special.log_ndtr(z), special.log_ndtr(z - w[:, None])
        ratio = np.minimum(log_b - log_a, 0.0)
        with np.errstate(divide="ignore"):
            share = np.log(-np.expm1((k - 1) * np.log1p(-np.exp(ratio))))
        # Where the ratio is too small for a double, the power's first term is all of it.
        share = np.where(ratio < -600.0, math.log(k - 1) + ratio, share)
        terms = (k - 1) * log_a - 0.5 * z * z + share
        return np.minimum(log_sum(terms) + math.log(k * step) - _LOG_ROOT_2PI, 0.0)

    def log_bound(self, w: Floats) -> Floats:
        """Return the logarithm of all pairs' chances together, at most 0."""
        one_pair = special.log_ndtr(-math.sqrt(0.5) * w) + math.log(2.0)
        return np.asarray(np.minimum(one_pair + self.slack, 0.0))

    @property
    def slack(self) -> float:
        """All pairs' tails together are at least the range's, one pair's at most."""
        return math.log(self.k * (self.k - 1) / 2.0)


def range_tail(q: Number, k: int, df: float) -> Tail:
    """Return P(Q > q) of the studentized range of k means with df degrees of freedom (df may be infinite)."""
    if q > 0 and k == 2 and math.isfinite(df):
        return t_two_sided(exact_root(Fraction(q) ** 2 / 2), df)
    log_p = log_upper_of_any(lambda near: range_log_upper(near, k, df), q, df)
    return Tail(math.exp(log_p), log_p / math.log(10.0))


def range_log_upper(q: float, k: int, df: float) -> float:
    """Return log P(Q > q) of the studentized range of k means with df degrees of freedom (df may be infinite)."""
    if q <= 0.0:
        return 0.0
    if k == 2 and math.isfinite(df):
        return math.log(10.0) * t_two_sided(math.sqrt(0.5) * q, df).log10_p
    return log_mean_over_scale(RangeOfNormals(k), df, q)


@lru_cache(maxsize=1024)
def range_critical(tail: float, k: int, df: float) -> float:
    """Return the q that the studentized range exceeds with chance `tail`."""

    def log_upper(_rows: NDArray[np.intp], q: Floats) -> Floats:
        return np.array([range_log_upper(float(q[0]), k, df)])

    return float(critical_values(log_upper, tail, np.array([3.5]))[0])


def _step(k: int) -> float:
    """Return the trapezoidal rule's step: the more normals, the steeper the rise of their largest one's distribution.

    It rises around the middle of the largest, about ndtri(1 - 1/k), over the inverse of that. At these steps the rule
    errs by less than 1e-14 of the chance for any k up to a million.
    """
    return min(0.2, 0.25 / max(-float(special.ndtri(1.0 / k)), 1.0))
