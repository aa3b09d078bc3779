"""Upper tail of the studentized range, with digits where other programs have none.

For k standard normals with largest value z the range exceeds w with the chance

    k times the integral of phi(z) (Phi(z)^(k-1) - (Phi(z) - Phi(z - w))^(k-1)) dz,

whose integrand is positive and is computed without a difference of nearly equal numbers. For k = 2 the range is the
square root of 2 times |t|.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from stats.error_free import exact_root
from stats.finite import Number
from stats.over_scale import critical_value, log_mean_over_scale, log_sum, log_upper_of_any
from stats.tails import Tail, t_two_sided

_Floats = NDArray[np.float64]

_STEP = 0.2
"""The trapezoidal rule errs by e**-90 here even for the largest of a hundred normals."""
_AROUND_MIDDLE = np.arange(-48, 49) * _STEP
"""Places of the largest value, from the middle of the range."""
_LOG_ROOT_2PI = 0.5 * math.log(2.0 * math.pi)


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
    return log_mean_over_scale(lambda s: _known_scale(q * s, k), df, q)


@lru_cache(maxsize=1024)
def range_critical(tail: float, k: int, df: float) -> float:
    """Return the q that the studentized range exceeds with chance `tail`."""
    return critical_value(lambda q: range_log_upper(q, k, df), tail, 3.5)


def _known_scale(w: _Floats, k: int) -> _Floats:
    """Return the logarithm of the chance that the range of k standard normals exceeds each w."""
    z = w[:, None] / 2.0 + _AROUND_MIDDLE
    log_a, log_b = special.log_ndtr(z), special.log_ndtr(z - w[:, None])
    ratio = np.minimum(log_b - log_a, 0.0)
    with np.errstate(divide="ignore"):
        share = np.log(-np.expm1((k - 1) * np.log1p(-np.exp(ratio))))
    # Where the ratio is too small for a double, the power's first term is all of it.
    share = np.where(ratio < -600.0, math.log(k - 1) + ratio, share)
    terms = (k - 1) * log_a - 0.5 * z * z + share
    return np.minimum(log_sum(terms) + math.log(k * _STEP) - _LOG_ROOT_2PI, 0.0)
