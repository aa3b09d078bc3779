"""Which samples of a height log are measurements: dropouts, rails, held values and spikes are left out, not repaired.

Everything after this works on the samples that remain, with their own times; nothing is interpolated.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import InputRefused

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_BLOCK_ROWS = 1 << 15
_SCALE_SAMPLES = 20_000
"""Noise and sampling interval are medians over about this many places, however long the log."""


@dataclass(frozen=True, slots=True)
class CleaningParameters:
    """What counts as a measurement of the body's height."""

    height_low_m: float = 0.02
    """At or below: the sensor reads zero or its lower rail; the body cannot be there."""
    height_high_m: float = 1.5
    """At or above: the upper rail."""
    speed_max_m_s: float = 5.0
    """A pair of opposite steps faster than this encloses a dropout (a 0.25 m fall reaches 2.2 m/s)."""
    spike_min_m: float = 0.005
    """A sample this far from the median of five, and six standard deviations of the noise, is a spike."""
    dropout_max_s: float = 0.2
    """Longest dropout that two opposite steps are believed to enclose."""


@dataclass(frozen=True, slots=True)
class CleanSignal:
    """The valid samples of a log, in order; arrays have shape (n_valid,)."""

    time_s: Floats
    height_m: Floats
    """As measured."""
    coarse_m: Floats
    """Running median of five valid samples: for finding things, not for measuring them."""
    leg_m: Floats | None
    """Leg length at these samples, where the log has it; NaN where it was not measured."""
    interval_s: float
    """Sampling interval of the log, gaps left out."""
    noise_sd_m: float
    """Standard deviation of the white noise, from third differences."""


def clean_signal(
    time_s: Floats,
    body_height_m: Floats,
    leg_length_m: Floats | None,
    gaps: Floats,
    parameters: CleaningParameters,
) -> CleanSignal:
    """Return the valid samples of a log; arrays of shape (n,), gaps of shape (n_gaps, 2): start and length, seconds.

    A sample inside a gap (a held value) is no measurement. Raises `InputRefused` when shapes differ or time
    does not increase.
    """
    check_log(time_s, body_height_m, leg_length_m, gaps)
    interval_s = sampling_interval(time_s)
    # NaN compares false, so that a missing height is left out here too.
    valid = (body_height_m > parameters.height_low_m) & (body_height_m < parameters.height_high_m)
    for first, last in zip(
        np.searchsorted(time_s, gaps[:, 0], side="right"),
        np.searchsorted(time_s, gaps[:, 0] + gaps[:, 1], side="left"),
        strict=True,
    ):
        valid[first:last] = False
    time_s, height, leg = _keep(valid, time_s, body_height_m, leg_length_m)

    noise_sd_m = _noise_sd(height)
    coarse = running_median_of_five(height)
    good = _within(height, coarse, max(parameters.spike_min_m, 6.0 * noise_sd_m))
    # The ends of a log have no median of their own.
    good[:2] = good[-2:] = True
    time_s, height, leg = _keep(good, time_s, height, leg)
    in_dropout = _between_opposite_steps(time_s, height, noise_sd_m, parameters)
    time_s, height, leg = _keep(~in_dropout, time_s, height, leg)
    if not (good.all() and not in_dropout.any()):
        coarse = running_median_of_five(height)
    return CleanSignal(time_s, height, coarse, leg, interval_s, noise_sd_m)


def check_log(time_s: Floats, body_height_m: Floats, leg_length_m: Floats | None, gaps: Floats) -> None:
    """Raise `InputRefused` unless the arrays of a log fit together and its time increases."""
    shapes = {"time": time_s.shape, "body height": body_height_m.shape}
    if leg_length_m is not None:
        shapes["leg length"] = leg_length_m.shape
    if len(set(shapes.values())) > 1 or time_s.ndim != 1:
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InputRefused(f"the channels have shapes {listed}: give one value of each for every sample.")
    if gaps.ndim != 2 or gaps.shape[1] != 2:
        raise InputRefused(f"gaps have shape {gaps.shape}: give one row (start_s, length_s) for each gap.")
    if time_s.size and not (np.isfinite(time_s[0]) and np.isfinite(time_s[-1])):
        raise InputRefused("the time axis begins or ends with a value that is not finite: give seconds.")
    if not np.all(time_s[1:] > time_s[:-1]):
        raise InputRefused("the time axis does not increase from sample to sample: sort the log and drop repeats.")


def sampling_interval(time_s: Floats) -> float:
    """Return the sampling interval in seconds, gaps left out; 0 for fewer than two samples.

    A mean, because a clock that shows whole milliseconds steps by 3, 3, 4 at 300 Hz and its median is wrong.
    """
    if time_s.size < 2:
        return 0.0
    steps = time_s[1:] - time_s[:-1]
    typical = float(np.median(steps[:: max(1, steps.size // _SCALE_SAMPLES)]))
    return float(np.mean(steps[steps <= 1.5 * typical]))


def gaps_in_time(time_s: Floats) -> Floats:
    """Return steps in time of more than one and a half intervals as gaps, shape (n_gaps, 2): start and length."""
    steps = time_s[1:] - time_s[:-1]
    wide = np.flatnonzero(steps > 1.5 * sampling_interval(time_s)) if steps.size else np.empty(0, dtype=np.int64)
    return np.column_stack([time_s[wide], steps[wide]])


def running_median_of_five(values: Floats) -> Floats:
    """Return the centred running median of five, shape (n,); the two values at each end repeat their neighbour."""
    if values.size < 5:
        return values.copy()
    median = np.empty_like(values)
    for rows in _blocks(values.size - 4):
        a, b, c, d, e = (values[rows.start + k : rows.stop + k] for k in range(5))
        # Ten comparisons instead of a sort: the median of five is that of e and two middle bounds of the other four.
        low = np.maximum(np.minimum(a, b), np.minimum(c, d))
        high = np.minimum(np.maximum(a, b), np.maximum(c, d))
        median[rows.start + 2 : rows.stop + 2] = np.maximum(np.minimum(low, high), np.minimum(np.maximum(low, high), e))
    median[:2], median[-2:] = median[2], median[-3]
    return median


def _within(values: Floats, other: Floats, distance: float) -> Bools:
    """Return where two arrays of shape (n,) are at most `distance` apart."""
    close = np.empty(values.size, dtype=np.bool_)
    for rows in _blocks(values.size):
        close[rows] = np.abs(values[rows] - other[rows]) <= distance
    return close


def _blocks(n: int) -> Iterator[slice]:
    """Yield slices of n rows that fit the processor's cache: a long log then needs no arrays of its length beside."""
    return (slice(start, min(start + _BLOCK_ROWS, n)) for start in range(0, n, _BLOCK_ROWS))


def _keep(mask: Bools, time_s: Floats, height_m: Floats, leg_m: Floats | None) -> tuple[Floats, Floats, Floats | None]:
    if mask.all():
        return time_s, height_m, leg_m
    return time_s[mask], height_m[mask], None if leg_m is None else leg_m[mask]


def _noise_sd(height_m: Floats) -> float:
    """Noise from third differences, which a parabola and slow motion leave alone; their variance is 20 sd^2."""
    if height_m.size < 4:
        return 0.0
    step = max(1, (height_m.size - 3) // _SCALE_SAMPLES)
    at = np.arange(0, height_m.size - 3, step)
    third = height_m[at + 3] - 3.0 * height_m[at + 2] + 3.0 * height_m[at + 1] - height_m[at]
    return float(np.median(np.abs(third))) / (0.6745 * math.sqrt(20.0))


def _between_opposite_steps(
    time_s: Floats, height_m: Floats, noise_sd_m: float, parameters: CleaningParameters
) -> Bools:
    """Mark samples between a step that no body can make and the step back."""
    marked = np.zeros(height_m.size, dtype=np.bool_)
    allowed = parameters.spike_min_m + 8.5 * noise_sd_m
    # Few steps pass the first test; only those are compared with their own time difference.
    steps = np.flatnonzero(~_within(height_m[1:], height_m[:-1], allowed))
    change = height_m[steps + 1] - height_m[steps]
    large = np.abs(change) > allowed + parameters.speed_max_m_s * (time_s[steps + 1] - time_s[steps])
    steps, change = steps[large], change[large]
    for number, (begin, end) in enumerate(itertools.pairwise(steps.tolist())):
        opposite = change[number] * change[number + 1] < 0.0
        if opposite and not marked[begin] and time_s[end] - time_s[begin] <= parameters.dropout_max_s:
            marked[begin + 1 : end + 1] = True
    return marked
