"""Where a sensor's signal is at rest, and by how much the zero of a height is off.

Between hops a leg that is longer than its rest length cannot be: where the body stands higher than the leg is long, the
height is not counted from the ground.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from stats.apexes.cleaning import Floats

_BLOCK_S = 0.02
_QUIET_SHARE = 0.02
"""A signal is at rest where it moves by less than this share of its range, or than the noise."""
_QUIET_NOISE = 6.0
_LONGEST_STROKE = 0.8
"""A leg shortens by less than this share of its rest length (the thesis's: 0.63)."""
ZERO_TOLERANCE_M = 0.01
"""A body that stands higher than the leg is long by less is as it should be: a leg is measured to some millimetres."""


@dataclass(frozen=True, slots=True)
class Rest:
    """A stretch at rest: from `start_s` to `stop_s`, with the mean of its values and their standard deviation."""

    start_s: float
    stop_s: float
    mean: float
    sd: float
    n: int


def rests(time_s: Floats, values: Floats, shortest_s: float = 0.5) -> tuple[Rest, ...]:
    """Return the stretches of at least `shortest_s` in which a signal is at rest, in order of time.

    `time_s` and `values` have shape (n,); values that are not finite are left out.
    """
    from scipy import ndimage

    finite = np.isfinite(values)
    time_s, values = time_s[finite], values[finite]
    if time_s.size < 2 or time_s[-1] - time_s[0] < shortest_s:
        return ()
    # Means of short blocks have little noise, and a long log few of them.
    blocks = np.unique(np.floor((time_s - time_s[0]) / _BLOCK_S), return_index=True)[1]
    n = np.diff(np.append(blocks, time_s.size))
    means = np.add.reduceat(values, blocks) / n
    low, high = np.percentile(means, (1.0, 99.0))
    noise = float(np.median(np.abs(np.diff(means))))
    width = max(3, round(shortest_s / max(_BLOCK_S, float(np.median(np.diff(time_s[blocks]))))))
    if means.size < width:
        return ()
    moves = ndimage.maximum_filter1d(means, width) - ndimage.minimum_filter1d(means, width)
    most = max(_QUIET_SHARE * (high - low), _QUIET_NOISE * noise)
    quiet = ndimage.binary_dilation(moves <= most, np.ones(width, dtype=np.bool_))
    steps = np.abs(np.diff(means)) > most  # from one rest to the next at once
    cuts = np.flatnonzero((quiet[1:] != quiet[:-1]) | steps) + 1
    ends = np.append(blocks, time_s.size)
    found = []
    for first, last in itertools.pairwise([0, *cuts.tolist(), means.size]):
        if not quiet[first]:
            continue
        trim = 2 if last - first > width else 0  # the signal may move within the outer blocks
        rows = slice(int(ends[first + trim]), int(ends[last - trim]))
        some = values[rows]
        if time_s[rows][-1] - time_s[rows][0] >= 0.9 * shortest_s:
            sd = float(some.std(ddof=1)) if some.size > 1 else 0.0
            found.append(Rest(float(time_s[rows][0]), float(time_s[rows][-1]), float(some.mean()), sd, some.size))
    return tuple(found)


def height_zero_m(
    time_s: Floats, body_height_m: Floats, leg_length_m: Floats | None, rest_length_m: float, stance_depth_m: float
) -> float:
    """Return by how much a log's heights seem to lie too high, in m; 0 where they do not or nothing tells.

    With a leg length the foot tells, which is on the ground while the leg is compressed by more than `stance_depth_m`;
    else the lowest level at which the body rests, if a leg can get it there from its lowest height. Arrays have shape
    (n,). Too low a zero is not seen: the ground gives way, and so does the leg under the body's weight. A body that is
    held by hand just above the ground is taken for one that stands there.
    """
    if leg_length_m is not None:
        compressed = leg_length_m < rest_length_m - stance_depth_m
        foot_m = body_height_m[compressed] - leg_length_m[compressed]
        foot_m = foot_m[np.isfinite(foot_m)]
        zero_m = float(np.median(foot_m)) if foot_m.size else 0.0
    else:
        finite = body_height_m[np.isfinite(body_height_m)]
        low = float(np.percentile(finite, 1.0)) if finite.size else 0.0
        stroke = (stance_depth_m, _LONGEST_STROKE * rest_length_m)
        stood = [one.mean for one in rests(time_s, body_height_m) if stroke[0] < one.mean - low < stroke[1]]
        zero_m = min(stood) - rest_length_m if stood else 0.0
    return zero_m if zero_m > ZERO_TOLERANCE_M else 0.0
