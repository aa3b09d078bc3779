"""Upper tail of the largest of several t-statistics that share a control and a standard deviation (Dunnett).

With the control's mean known (y, a standard normal) and the standard deviation known (s) the comparisons are
independent. With lambda_i = sqrt(n_i / (n_i + n_control)) and r_i^2 = 1 - lambda_i^2 the largest |T| exceeds c with the
chance 1 - product over i of (1 - t_i), t_i = Phi(-(c s - lambda_i y) / r_i) + Phi(-(c s + lambda_i y) / r_i); for the
largest T the first term alone. Where a treatment is much larger than the control t_i is nearly a step, r_i wide: y is
cut into stretches, short ones where a t_i rises and long ones elsewhere, and Gauss's rule serves each. The same digits
at every call, and tails as small as they are.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import special

from stats.exact.critical_values import critical_values
from stats.exact.known_scale import Floats, KnownScale
from stats.exact.over_scale import log_mean_over_scale, log_sum

_REACH = 9.5
"""Standard deviations beyond which a normal adds nothing to 16 digits."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)
_LOG_ROOT_2PI = 0.5 * math.log(2.0 * math.pi)


@dataclass(frozen=True)
class LargestAgainstControl(KnownScale):
    """The largest T, or |T|, of treatments against one control, the standard deviation being known."""

    n_control: int
    n_treated: tuple[tuple[int, int], ...]
    """Sizes of the treatments, each with how many have it; rising."""
    two_sided: bool
    fall: ClassVar[float] = 0.5

    def log_chance(self, w: Floats) -> Floats:
        """Return log g at each w of shape (m,), integrated over the control's mean."""
        y, log_widths = self._nodes(w)
        log_tails = []
        for n, _times in self.n_treated:
            slope, root = _slope_and_root(n, self.n_control)
            log_tail = special.log_ndtr((slope * y - w[:, None]) / root)
            if self.two_sided:
                log_tail = np.logaddexp(log_tail, special.log_ndtr((-slope * y - w[:, None]) / root))
            log_tails.append(np.minimum(log_tail, 0.0))
        times = [count for _n, count in self.n_treated]
        with np.errstate(divide="ignore"):
            none = sum(count * np.log1p(-np.exp(tail)) for count, tail in zip(times, log_tails, strict=True))
            any_of_them = np.log(-np.expm1(none))
        # Where all are too small for a double, the chance of any is their sum.
        rare = log_sum(
            np.stack([tail + math.log(count) for count, tail in zip(times, log_tails, strict=True)], axis=-1)
        )
        any_of_them = np.where(rare < -600.0, rare, any_of_them)
        # The integrand of both sides is even in y: half of it is integrated.
        whole = math.log(2.0) if self.two_sided else 0.0
        return np.minimum(log_sum(any_of_them - 0.5 * y * y + log_widths) + whole - _LOG_ROOT_2PI, 0.0)

    def log_bound(self, w: Floats) -> Floats:
        """Return the logarithm of all treatments' chances together, at most 0."""
        sides = math.log(2.0) if self.two_sided else 0.0
        return np.asarray(np.minimum(special.log_ndtr(-w) + sides + self.slack, 0.0))

    @property
    def slack(self) -> float:
        """The chances of all treatments together are at least the largest's, one treatment's at most."""
        return math.log(sum(count for _n, count in self.n_treated))

    def _nodes(self, w: Floats) -> tuple[Floats, Floats]:
        """Return the places y for each w and the logarithms of their weights, both of shape (m, places)."""
        edges = self._edges(w)
        half = np.diff(edges, axis=-1)[..., None] / 2.0
        y = edges[:, :-1, None] + half * (1.0 + _NODES)
        with np.errstate(divide="ignore"):
            log_widths = np.log(half * _WEIGHTS)
        return y.reshape(w.size, -1), log_widths.reshape(w.size, -1)

    def _edges(self, w: Floats) -> Floats:
        """Return where the stretches of y begin and end, shape (m, stretches + 1), the last perhaps of length 0."""
        slopes, roots = np.array([_slope_and_root(n, self.n_control) for n, _times in self.n_treated]).T
        # t_i rises around w / lambda over r_i / lambda; with the normal, what it adds lies around lambda w, over r_i.
        rise, most = w[:, None] / slopes, w[:, None] * slopes
        longest = _longest(sum(count for _n, count in self.n_treated))
        start = np.minimum(rise, most) - _REACH * roots / slopes
        end = np.maximum(rise, most) + _REACH * roots / slopes
        y = np.maximum(np.min(most, axis=-1) - _REACH, 0.0 if self.two_sided else -_REACH)
        last = np.maximum(np.max(most, axis=-1), 0.0) + _REACH
        edges = [y]
        while np.any(y < last):
            near = np.maximum(y[:, None] + longest * roots, start)
            y = np.minimum(y + longest, np.min(np.where(y[:, None] < end, near, np.inf), axis=-1))
            y = np.minimum(y, last)
            edges.append(y)
        return np.stack(edges, axis=-1)


def largest_log_upper(c: float, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> float:
    """Return log P(max |T_i| > c), or log P(max T_i > c), for groups of these sizes against one control."""
    if two_sided and c <= 0.0:
        return 0.0
    return log_mean_over_scale(_family(n_control, n_treated, two_sided), df, c)


@lru_cache(maxsize=1024)
def largest_critical(tail: float, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> float:
    """Return the c that the largest statistic exceeds with chance `tail`."""

    def log_upper(_rows: NDArray[np.intp], c: Floats) -> Floats:
        return np.array([largest_log_upper(float(c[0]), n_control, n_treated, df, two_sided=two_sided)])

    return float(critical_values(log_upper, tail, np.array([2.5]))[0])


def _family(n_control: int, n_treated: tuple[int, ...], two_sided: bool) -> LargestAgainstControl:
    return LargestAgainstControl(n_control, tuple(sorted(Counter(n_treated).items())), two_sided)


def _longest(treatments: int) -> float:
    """Return the length of a stretch of y, in the standard deviations of what varies along it.

    The more treatments, the steeper the rise of the largest one's distribution: over the inverse of where it rises,
    about ndtri(1 - 1/treatments). With 20 nodes a stretch the chance is right to 1e-14 for any number up to ten
    thousand.
    """
    return min(4.0, 4.2 / max(-float(special.ndtri(1.0 / treatments)), 1.0))


def _slope_and_root(n: int, n_control: int) -> tuple[float, float]:
    """Return lambda and r of a treatment of n values."""
    return math.sqrt(n / (n + n_control)), math.sqrt(n_control / (n + n_control))
