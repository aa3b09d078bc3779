"""Tails of statistics whose standard deviation is known, kept as polynomials that many comparisons share.

A family of comparisons asks for one such tail g(w) at thousands of places: at every scale of every statistic, and at
every step of the search for a critical value. log g plus the square it falls with is smooth, so it is computed at 32
places of each stretch of w (Chebyshev's), and stretches are halved until the polynomial through them stands to a
double's digits. Each stretch is computed when it is first asked for and depends on nothing else: the same digits at
every call, in any order.

Where the standard deviation is estimated, tails are integrated over that estimate. With s^2 = chi^2 / df the chance is
the mean of g(s), g(s) being the chance for a known standard deviation s times too small. Over u = log s the integrand
is smooth and falls off on both sides faster than any power, where the trapezoidal rule gains digits exponentially;
logarithms keep tails of any size. Nothing is random: the same input gives the same digits at every call.

Critical values at many degrees of freedom come from a polynomial. Each pair of Games and Howell has its own degrees of
freedom, and 200 groups have 19 900 pairs; the logarithm of a critical value is analytic in that of the degrees of
freedom.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from stats.exact.numbers import Number, next_share

Floats = NDArray[np.float64]

_FARTHEST = 512.0
"""The last place that is computed, beyond e**-65000; from there on tails fall as their square and their inverse."""
_SURE = -32.0
"""Any normal lies above: tails are 1 from here down."""
_NODES = 32
_NARROWEST = 2.0**-5
"""Stretches are halved no further than this, or this share of where they lie."""
_NOISE = 2.0**-50
"""Coefficients below this, over what log g itself is rounded by, are 0."""
_ODD = 2 * np.arange(_NODES) + 1
"""The angles of the places, in units of pi / 64: whole, so that their multiples keep all digits."""
_PLACES = np.cos(_ODD * (math.pi / (2 * _NODES)))
_TO_COEFFICIENTS = np.cos(np.outer(np.arange(_NODES), _ODD) % (4 * _NODES) * (math.pi / (2 * _NODES)))
_TO_COEFFICIENTS *= 2.0 / _NODES
_TO_COEFFICIENTS[0] /= 2.0
_AT_ONCE = 2**12
"""Places evaluated together: what that takes stays within a processor's cache."""


@dataclass(frozen=True)
class KnownScale(ABC):
    """What the largest of a family of comparisons exceeds, the standard deviation being known."""

    fall: ClassVar[float]
    """log g(w) + fall w^2 varies slowly for large w."""

    @abstractmethod
    def log_chance(self, w: Floats) -> Floats:
        """Return log g at each w of shape (m,), by integration."""

    @abstractmethod
    def log_bound(self, w: Floats) -> Floats:
        """Return what log g does not exceed, and comes within `slack` of; any shape."""

    @property
    @abstractmethod
    def slack(self) -> float:
        """How far log g may lie below its bound."""

    def log_tail(self, w: Floats) -> Floats:
        """Return log g at each w, any shape, from the polynomials."""
        flat = np.ravel(w)
        near = np.clip(flat, _SURE, _FARTHEST)
        pieces = _pieces(self, *_stretches(near))
        found = np.concatenate([pieces.at(near[i : i + _AT_ONCE]) for i in range(0, near.size, _AT_ONCE)])
        ahead = np.maximum(near, 0.0)
        found -= self.fall * ahead * ahead
        found[flat <= _SURE] = 0.0
        far = flat > _FARTHEST
        if np.any(far):
            beyond = flat[far]
            found[far] -= self.fall * (beyond - _FARTHEST) * (beyond + _FARTHEST) + np.log(beyond / _FARTHEST)
        return np.asarray(np.minimum(found, 0.0).reshape(np.shape(w)))


@dataclass(frozen=True, slots=True)
class _Pieces:
    """A polynomial for each of m stretches that follow on each other."""

    edges: Floats
    """Shape (m + 1,), rising."""
    coefficients: Floats
    """Of Chebyshev's polynomials, shape (32, m)."""

    def at(self, w: Floats) -> Floats:
        """Return the polynomials' values at each w, shape (p,)."""
        which = np.clip(np.searchsorted(self.edges, w, side="right") - 1, 0, self.edges.size - 2)
        low, high = self.edges[which], self.edges[which + 1]
        chebyshev = _chebyshev((2.0 * w - low - high) / (high - low))
        return np.asarray(np.einsum("np,np->p", chebyshev, np.take(self.coefficients, which, axis=1)))


def _chebyshev(x: Floats) -> Floats:
    """Return Chebyshev's polynomials T_0 to T_31 at each x of shape (p,), by T_(m+j) = 2 T_m T_j - T_(m-j)."""
    t = np.empty((_NODES, x.size))
    t[0], t[1], t[2] = 1.0, x, 2.0 * x * x - 1.0
    m = 2
    while m < _NODES:
        t[m + 1 : 2 * m] = 2.0 * t[m] * t[1:m] - t[m - 1 : 0 : -1]
        if 2 * m < _NODES:
            t[2 * m] = 2.0 * t[m] * t[m] - 1.0
        m *= 2
    return t


def _stretches(w: Floats) -> tuple[int, int]:
    """Return the first and the last whole stretch for all w: number 0 is [0, 1], 1 [1, 2], 2 [2, 4], -1 [-1, 0]."""
    return _stretch(float(np.min(w))), _stretch(float(np.max(w)))


def _stretch(w: float) -> int:
    size = math.frexp(min(abs(w), _FARTHEST * (1.0 - 2.0**-53)))[1]
    return max(size, 0) if w >= 0.0 else -1 - max(size, 0)


def _edges(number: int) -> tuple[float, float]:
    if number < 0:
        low, high = _edges(-1 - number)
        return -high, -low
    return (0.0, 1.0) if number == 0 else (2.0 ** (number - 1), 2.0**number)


@lru_cache(maxsize=1024)
def _pieces(family: KnownScale, first: int, last: int) -> _Pieces:
    """Return the polynomials of some stretches in one table."""
    parts = [_of_stretch(family, number) for number in range(first, last + 1)]
    edges = [part.edges[:-1] for part in parts] + [parts[-1].edges[-1:]]
    return _Pieces(np.concatenate(edges), np.concatenate([part.coefficients for part in parts], axis=1))


@lru_cache(maxsize=4096)
def _of_stretch(family: KnownScale, number: int) -> _Pieces:
    """Return the polynomials of one stretch, halved until they stand."""
    low, high = _edges(number)
    waiting, edges, rows = [(low, high)], [low], []
    while waiting:
        low, high = waiting.pop()
        w = (low + high) / 2.0 + (high - low) / 2.0 * _PLACES
        log_g = family.log_chance(w)
        coefficients = _TO_COEFFICIENTS @ (log_g + family.fall * np.maximum(w, 0.0) ** 2)
        noise = _NOISE * (4.0 + float(np.max(np.abs(log_g))))
        if np.max(np.abs(coefficients[-4:])) <= noise or high - low <= _NARROWEST * max(abs(low), 1.0):
            edges.append(high)
            rows.append(coefficients)
        else:
            waiting += [((low + high) / 2.0, high), (low, (low + high) / 2.0)]
    return _Pieces(np.array(edges), np.array(rows).T)


_NEGLIGIBLE = 42.0
"""What lies e**42 below the largest value adds nothing to 16 digits."""
STARTS = 24
"""Intervals of the first rule; each further rule halves them."""
_EVEN = np.arange(STARTS + 1) / STARTS
FAR = 2.0**300
"""From here on a tail falls as statistic**-df: what else it does is its square's inverse, 1e-180."""
_ZOOMS = 4
_MOST = 20000
"""Points of the last rule."""
_STATISTICS_AT_ONCE = 128
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
    for start in range(0, rows.size, _STATISTICS_AT_ONCE):
        some = rows[start : start + _STATISTICS_AT_ONCE]
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

    left = -(_NEGLIGIBLE / df + np.log(np.maximum(np.abs(statistic), 1.0)) + 3.0)
    least = _NEGLIGIBLE + known.slack
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


LogUpper = Callable[[NDArray[np.intp], Floats], Floats]
"""Logarithms of the upper tails of those of m distributions that are asked for, at a statistic each, shape (p,)."""

_ENOUGH = 1e-14
_MOST_STEPS = 200


def critical_values(log_upper: LogUpper, tail: float, guess: Floats) -> Floats:
    """Return the statistics that have the upper tail `tail`, shape (m,), searched from `guess` by Chandrupatla's rule.

    Source: Chandrupatla (1997), Advances in Engineering Software 28, 145: inverse quadratic interpolation where the
    three last places allow it, halves elsewhere.
    """
    wanted = math.log(min(tail, 1.0 - 2.0**-53))  # 1 is all that is left of a level near 0
    rows = np.arange(guess.size)
    b, fb, a, fa = _bracketed(log_upper, wanted, guess)
    c, fc = a.copy(), fa.copy()
    share = np.full(guess.size, 0.5)
    found = np.where(np.abs(fa) < np.abs(fb), a, b)
    for _ in range(_MOST_STEPS):
        x = a[rows] + share[rows] * (b[rows] - a[rows])
        f = log_upper(rows, x) - wanted
        same = np.sign(f) == np.sign(fa[rows])
        c[rows], fc[rows] = np.where(same, a[rows], b[rows]), np.where(same, fa[rows], fb[rows])
        b[rows], fb[rows] = np.where(same, b[rows], a[rows]), np.where(same, fb[rows], fa[rows])
        a[rows], fa[rows] = x, f
        found[rows] = np.where(np.abs(fa[rows]) < np.abs(fb[rows]), a[rows], b[rows])
        with np.errstate(divide="ignore"):
            least = _ENOUGH * np.maximum(np.abs(found[rows]), 1e-3) / np.abs(b[rows] - a[rows])
        going = (least < 0.5) & (f != 0.0)
        rows, least = rows[going], least[going]
        share[rows] = np.clip(next_share(a[rows], fa[rows], b[rows], fb[rows], c[rows], fc[rows]), least, 1.0 - least)
        if not rows.size:
            break
    return found


def _bracketed(log_upper: LogUpper, wanted: float, guess: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return places on both sides of each critical value: the lower, its excess, the upper, its excess."""
    low, high = guess.copy(), guess.copy()
    f_low = log_upper(np.arange(guess.size), guess) - wanted
    f_high = f_low.copy()
    for ends, values, others, other_values, side in (
        (low, f_low, high, f_high, -1.0),
        (high, f_high, low, f_low, 1.0),
    ):
        rows = np.flatnonzero(side * values > 0.0)
        while rows.size:
            others[rows], other_values[rows] = ends[rows], values[rows]
            ends[rows] += side * 0.5 * np.maximum(np.abs(ends[rows]), 1.0)
            values[rows] = log_upper(rows, ends[rows]) - wanted
            rows = rows[side * values[rows] > 0.0]
    return low, f_low, high, f_high


_DEGREE = 80
_HIGHEST_DF = 2.0**20
_STANDS = 1e-13
"""Last coefficients below this are the rounding of what is searched."""


def criticals_over_df(search: Callable[[Floats], Floats], df: Floats) -> Floats:
    """Return what `search` gives for degrees of freedom of shape (m,), of very many by a polynomial."""
    inside = (df >= 1.0) & (df <= _HIGHEST_DF)
    logs = np.log(df[inside])
    if logs.size > 2 * _DEGREE:
        curve = chebyshev.Chebyshev.interpolate(
            lambda log_df: np.log(search(np.exp(log_df))), _DEGREE, domain=[logs.min(), logs.max()]
        )
        if np.max(np.abs(curve.coef[-3:])) <= _STANDS:
            found = np.empty(df.shape)
            found[inside] = np.exp(curve(logs))
            found[~inside] = search(df[~inside])
            return found
    return search(df)
