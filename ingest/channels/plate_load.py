"""The load on a force plate, judged from the level of the unloaded plate and never from zero, which amplifiers shift.

Whatever walks or hops on a plate leaves it at one level, and moves while it is on it. The unloaded level is an end of
the range at which the force stays: crowded while its neighbours are passed quickly, narrow as noise is and the top of a
hump is not, and where the record is most quiet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ingest.model import FloatArray

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
_STRETCH, _QUIETEST, _AT_LEVEL = 8, 0.1, 0.5
"""Of the quietest tenth of stretches of so many samples at least half are at the unloaded level."""
_LEAST_SAMPLES = 10
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


def find_load(force_n: FloatArray, least_n: float = LOADED_N) -> Load | None:
    """Find the load in a vertical force, shape (n,), NaN where a sample is missing.

    Returns None where nothing shows it: no more than `least_n` comes and goes, as of an idle or a quietly loaded plate;
    no level is returned to; or the load is a level as well, as that of a weight which is put on the plate.
    """
    stretches = force_n[: len(force_n) // _STRETCH * _STRETCH].reshape(-1, _STRETCH)
    stretches = stretches[:: 1 + len(force_n) // _MOST_SAMPLES]
    stretches = stretches[(np.abs(stretches) < MOST_N).all(axis=1)]
    force = np.sort(stretches, axis=None)
    if len(force) < 2 * _LEAST_SAMPLES:
        return None
    spikes = min(10, len(force) // 100)
    low, high = float(force[spikes]), float(force[-1 - spikes])
    if not high - low > least_n:
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
        lowest, highest = level & (starts <= low + beyond), level & (starts + width >= high - beyond)
        if lowest.any() and highest.any():
            return None
        if lowest.any() or highest.any():
            unloaded_n = float(middles[np.argmax(np.where(lowest | highest, inside, 0))])
            noise_n = stretches.std(axis=1)
            quiet_n = stretches.mean(axis=1)[noise_n <= np.quantile(noise_n, _QUIETEST)]
            if np.mean(np.abs(quiet_n - unloaded_n) < width) < _AT_LEVEL:
                return None
            return Load(unloaded_n, 1, high - unloaded_n) if lowest.any() else Load(unloaded_n, -1, unloaded_n - low)
    return None
