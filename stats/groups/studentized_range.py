"""Upper tail of the studentized range, with digits where other programs have none.

For k standard normals with largest value z the range exceeds w with the chance

    k times the integral of phi(z) (Phi(z)^(k-1) - (Phi(z) - Phi(z - w))^(k-1)) dz,

whose integrand is positive and is computed without a difference of nearly equal numbers. For k = 2 the range is the
square root of 2 times |t|.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import ClassVar

import numpy as np
from scipy import special

from stats.exact.critical_values import critical_values, criticals_over_df
from stats.exact.error_free import exact_root
from stats.exact.finite import Number
from stats.exact.known_scale import FAR, Floats, KnownScale, log_means_over_scale, log_sum, log_upper_of_any
from stats.exact.tails import Tail, t_two_sided

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
    return range_tails((q,), k, (df,))[0]


def range_tails(qs: Sequence[Number], k: int, dfs: Sequence[float]) -> tuple[Tail, ...]:
    """Return `range_tail` of many q, each with its own df, integrated together."""
    near = _log_uppers(np.array([float(min(q, FAR)) for q in qs]), k, np.array(dfs, dtype=np.float64)).tolist()
    return tuple(_tail(q, k, df, log_near) for q, df, log_near in zip(qs, dfs, near, strict=True))


def range_critical(tail: float, k: int, df: float) -> float:
    """Return the q that the studentized range exceeds with chance `tail`."""
    return range_criticals(tail, k, (df,))[0]


@lru_cache(maxsize=256)
def range_criticals(tail: float, k: int, dfs: tuple[float, ...]) -> tuple[float, ...]:
    """Return `range_critical` of each of many degrees of freedom, searched together."""

    def search(df: Floats) -> Floats:
        return critical_values(lambda rows, q: _log_uppers(q, k, df[rows]), tail, np.full(df.shape, 3.5))

    return tuple(criticals_over_df(search, np.array(dfs, dtype=np.float64)).tolist())


def _tail(q: Number, k: int, df: float, log_near: float) -> Tail:
    """Return the tail at q, `log_near` being its logarithm at q or, before that, at `FAR`."""
    if q > 0 and k == 2 and math.isfinite(df):
        return t_two_sided(exact_root(Fraction(q) ** 2 / 2), df)
    log_p = log_upper_of_any(lambda _near: log_near, q, df)
    return Tail(math.exp(log_p), log_p / math.log(10.0))


def _log_uppers(q: Floats, k: int, df: Floats) -> Floats:
    """Return log P(Q > q) of each q with its own df, both of shape (m,)."""
    found = np.zeros(q.shape)
    exact = np.isfinite(df) & (k == 2)
    for row in np.flatnonzero((q > 0.0) & exact):
        found[row] = math.log(10.0) * t_two_sided(math.sqrt(0.5) * float(q[row]), float(df[row])).log10_p
    rest = (q > 0.0) & ~exact
    found[rest] = log_means_over_scale(RangeOfNormals(k), df[rest], q[rest])
    return found


def _step(k: int) -> float:
    """Return the trapezoidal rule's step: the more normals, the steeper the rise of their largest one's distribution.

    It rises around the middle of the largest, about ndtri(1 - 1/k), over the inverse of that. At these steps the rule
    errs by less than 1e-14 of the chance for any k up to a million.
    """
    return min(0.2, 0.25 / max(-float(special.ndtri(1.0 / k)), 1.0))
