"""Tails of statistics whose standard deviation is known, kept as polynomials that many comparisons share.

A family of comparisons asks for one such tail g(w) at thousands of places: at every scale of every statistic, and at
every step of the search for a critical value. log g plus the square it falls with is smooth, so it is computed at 32
places of each stretch of w (Chebyshev's), and stretches are halved until the polynomial through them stands to a
double's digits. Each stretch is computed when it is first asked for and depends on nothing else: the same digits at
every call, in any order.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

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
