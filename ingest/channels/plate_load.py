"""The load on a force plate, judged from the level of the unloaded plate and never from zero, which amplifiers shift.

Whatever walks or jumps on a plate leaves it at one level, and pushes harder at times than it weighs. The unloaded level
is the one end of the range at which the force stays, crowded while its neighbours are passed quickly, and narrow as
noise is and the top of a hump is not; a level inside the range is a body's that stands.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ingest.model import BoolArray, FloatArray

LOADED_N = 20.0
"""A plate with less on it is unloaded: its centre of pressure, a quotient, means nothing and may be of any size."""
MOST_N = 1e5
"""More, either way, is a damaged row or another unit."""

_WIDTHS = (0.05, 0.1, 0.2)
"""How wide a level is with its noise, as a share of the range: the narrowest width that shows a level counts."""
_CROWDED = 3.0
"""A level has so many times the samples of either neighbour; the top of half a sine has 2.4 times as many."""
_NARROW = 0.85
"""Share of a level's samples in the middle half of its width; of the top of half a sine it is 0.71."""
_BEYOND = 0.1
"""Share of the range that may lie beyond the unloaded level: what filters and vibrations add."""
_LEAST_SAMPLES = 10
_OF_OTHER_END = 0.1
"""A level has so many of the samples at the other end: the tops of impacts, which are few and crowded, have less."""
_STRETCH = 8
"""Samples whose mean has little noise."""
_MOST_SAMPLES = 1 << 17


@dataclass(frozen=True, slots=True)
class Load:
    """What a vertical force shows: the unloaded level, on which side of it the load is (1 or -1), the largest load."""

    unloaded_n: float
    sign: int
    largest_n: float

    def of(self, force_n: FloatArray) -> FloatArray:
        """Return the load in samples of this force, shape (n,), in newtons."""
        return self.sign * (force_n - self.unloaded_n)

    def is_on(self, force_n: FloatArray) -> BoolArray:
        """Return in which samples of this force, shape (n,), the plate is loaded."""
        return np.asarray(self.of(force_n) > LOADED_N)

    def turned(self) -> Load:
        """Return the load of the force with the opposite sign."""
        return Load(0.0 - self.unloaded_n, -self.sign, self.largest_n)


def _stretches(force_n: FloatArray) -> FloatArray:
    """Return stretches of successive samples, shape (n, _STRETCH), of all of a long record, without damaged ones."""
    stretches = force_n[: len(force_n) // _STRETCH * _STRETCH].reshape(-1, _STRETCH)
    stretches = stretches[:: 1 + len(force_n) // _MOST_SAMPLES]
    return stretches[(np.abs(stretches) < MOST_N).all(axis=1)]


def change_n(force_n: FloatArray) -> float:
    """Return how much a force, shape (n,), changes beyond its noise, in newtons."""
    stretches = _stretches(force_n)
    return float(np.ptp(stretches.mean(axis=1))) if len(stretches) else 0.0


def find_load(force_n: FloatArray) -> Load | None:
    """Find the load in a vertical force, shape (n,), NaN where a sample is missing.

    Returns None where nothing shows it: an idle or a quietly loaded plate; no level is returned to; the load is a level
    as well, as that of a weight which is put on the plate; or it comes or goes but once, as where a body steps off.
    """
    stretches = _stretches(force_n)
    force = np.sort(stretches, axis=None)
    if len(force) < 2 * _LEAST_SAMPLES:
        return None
    spikes = min(10, len(force) // 100)
    low, high = float(force[spikes]), float(force[-1 - spikes])
    if not high > low:
        return None
    for share in _WIDTHS:
        width, beyond = share * (high - low), _BEYOND * (high - low)
        starts = np.arange(low - width, high, width / 4)
        edges = np.searchsorted(force, [starts - width, starts, starts + width, starts + 2 * width])
        below, inside, above = np.diff(edges, axis=0)
        middles = force[np.minimum((edges[1] + edges[2]) // 2, len(force) - 1)]
        (near,) = np.diff(np.searchsorted(force, [middles - width / 4, middles + width / 4]), axis=0)
        level = (inside >= _CROWDED * np.maximum(below, above)) & (near >= _NARROW * inside)
        level &= inside >= _LEAST_SAMPLES
        at_low, from_high = np.searchsorted(force, [low + beyond, high - beyond])
        lowest = level & (starts <= low + beyond) & (inside >= _OF_OTHER_END * (len(force) - from_high))
        highest = level & (starts + width >= high - beyond) & (inside >= _OF_OTHER_END * at_low)
        if lowest.any() and highest.any():
            return None
        if lowest.any() or highest.any():
            sign, ends = (1, lowest) if lowest.any() else (-1, highest)
            outermost = np.flatnonzero(ends)[::sign]
            outermost = outermost[np.abs(starts[outermost] - starts[outermost[0]]) < width]
            unloaded_n = float(middles[outermost[np.argmax(inside[outermost])]]) + 0.0  # no negative zero
            loaded = 2.0 * sign * (stretches.mean(axis=1) - unloaded_n) > high - low
            if np.count_nonzero(loaded[1:] != loaded[:-1]) < 2 + loaded[0]:
                return None
            return Load(unloaded_n, sign, high - unloaded_n if sign == 1 else unloaded_n - low)
    return None
