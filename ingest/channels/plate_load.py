"""The load on a force plate, judged from the level of the unloaded plate and never from zero, which amplifiers shift.

Whatever walks or hops on a plate leaves it at one level, and moves while it is on it: the unloaded level is the one
that is crowded while its neighbours are passed quickly, and the load lies on one side of it.
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
"""A level has so many times the samples beside it; the top of a hump, which is flat too, has 2.4 times as many."""
_LEAST_SAMPLES = 10
_BEYOND = 0.1
"""Share of the range that may lie beyond the unloaded level: what filters and vibrations add."""
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
    force = force_n[:: 1 + len(force_n) // _MOST_SAMPLES]
    force = np.sort(force[np.abs(force) < MOST_N])
    spikes = min(10, len(force) // 100)
    if len(force) < 2 * _LEAST_SAMPLES:
        return None
    low, high = float(force[spikes]), float(force[-1 - spikes])
    if not high - low > least_n:
        return None
    for share in _WIDTHS:
        width, beyond = share * (high - low), _BEYOND * (high - low)
        starts = np.arange(low - width, high, width / 4)
        edges = np.searchsorted(force, [starts - width, starts, starts + width, starts + 2 * width])
        below, inside, above = np.diff(edges, axis=0)
        level = (inside >= _CROWDED * np.maximum(below, above)) & (inside >= _LEAST_SAMPLES)
        lowest, highest = level & (starts - low <= beyond), level & (high - starts - width <= beyond)
        if lowest.any() and highest.any():
            return None
        if lowest.any() or highest.any():
            at = int(np.argmax(np.where(lowest | highest, inside, 0)))
            unloaded = float(np.median(force[edges[1, at] : edges[2, at]]))
            return Load(unloaded, 1, high - unloaded) if lowest.any() else Load(unloaded, -1, unloaded - low)
    return None
