"""Stamps in bursts: they tell when packets arrived, ten samples at once, and not when samples were taken.

Between one burst and the next passes the time of the samples in it, so the rate is samples over time and the axis even.
Samples that were lost are seen from bursts that bring too few for the time that passed, and that no later ones make up
for: a burst that comes late, and the few after it that come the sooner, have lost nothing.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

import numpy as np

from data_schema.vocabulary import GapKind
from ingest.model import FloatArray, IntArray
from ingest.timebase.stamps import PAUSE_PERIODS, PAUSE_S, Timebase, from_rate

_WITHIN = 0.5
"""A step below this share of the mean step lies within a burst."""
_SHORT, _FEWEST_SHORT = 0.25, 0.1
"""No jitter: so many steps are as short as this share of the mean step."""
_FEWEST_BURSTS = 10
_REGULAR, _REGULAR_SHARE = 0.35, 0.7
_CONTINUOUS = 5.0
_LONGEST_STEP_S = 3600.0
_MAKES_UP = 50
"""Bursts within which a delay is made up for; later ones would take the drift of a clock for it."""
_ENDS = 50
"""Bursts at either end, a third of all at most, whose usual lateness says how long a recording took."""
_MOST_ROWS = 1 << 20
"""A long recording that does not begin in bursts has none."""


def burst_starts(seconds: FloatArray) -> IntArray | None:
    """Return the rows at which bursts start, or None where stamps, shape (n,), come one by one.

    Rows of a burst repeat their stamp or follow in a small part of the mean step, and every burst brings about as many
    samples as fit into the time until the next.
    """
    if len(seconds) > _MOST_ROWS and burst_starts(seconds[:_MOST_ROWS]) is None:
        return None
    if len(seconds) < 2 * _FEWEST_BURSTS or not np.isfinite(seconds).all():
        return None
    steps = np.diff(seconds)
    if steps.min() < 0 or steps.max() > _LONGEST_STEP_S:
        return None
    usual = steps[steps <= PAUSE_S] if (steps <= PAUSE_S).any() else steps
    mean = float(usual.mean())
    if np.count_nonzero(steps < _SHORT * mean) < _FEWEST_SHORT * len(steps):
        return None
    starts = np.concatenate([[0], np.flatnonzero(steps >= _WITHIN * mean) + 1])
    if len(starts) < _FEWEST_BURSTS or np.diff(starts).max() < 2:
        return None
    period = np.diff(seconds[starts]) / np.diff(starts)
    near = np.abs(period / np.median(period) - 1) < _REGULAR
    return np.asarray(starts, dtype=np.int64) if np.count_nonzero(near) >= _REGULAR_SHARE * len(near) else None


def rate_within(seconds: FloatArray, starts: IntArray) -> float | None:
    """Return the rate, in hertz, at which rows follow each other within bursts; None where they share their stamps."""
    within = np.ones(len(seconds) - 1, dtype=np.bool_)
    within[starts[1:] - 1] = False
    step = float(np.median(np.diff(seconds)[within]))
    return 1 / step if step > 0 else None


def are_continuous(channels: Iterable[FloatArray], starts: IntArray) -> bool:
    """Whether values, shape (n,) each, change within bursts, and most not much more from burst to burst than within.

    A logger that records only now and then leaves the stamps of bursts, but its channels jump from one to the next;
    rows that are written twice repeat all their values.
    """
    moving = moving_within = jumping = 0
    for values in channels:
        within = np.ones(len(values) - 1, dtype=np.bool_)
        within[starts[1:] - 1] = False
        change = np.abs(np.diff(values))
        inside, between = _mean(change[within]), _mean(change[~within])
        moving += inside + between > 0
        moving_within += inside > 0
        jumping += 0 < _CONTINUOUS * inside < between
    return 2 * jumping <= moving_within and (moving_within > 0 or not moving)


def _mean(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else 0.0


def from_bursts(seconds: FloatArray, ordinals: IntArray, starts: IntArray, numbers: IntArray | None = None) -> Timebase:
    """Build the even axis of samples that came in bursts.

    `seconds`, shape (n,), are the stamps, `ordinals` number the rows as they stand in the file, `starts` are the rows
    at which bursts start, `numbers` the instrument's own numbers of the samples, where it has them.
    """
    counts = (ordinals if numbers is None else numbers).copy()
    last_of_burst = np.append(starts[1:], len(counts)) - 1
    # How much of the last burst the file holds says nothing; when it came, only what it made up for.
    brought = np.diff(counts[last_of_burst])[:-1]
    between = np.diff(seconds[starts])
    passed = between[:-1]
    period, tolerated = _period(passed, brought)
    lateness = np.concatenate([[0.0], np.cumsum(passed - brought * period)])
    of_last = lateness[-1] + between[-1] - float(np.median(brought)) * period
    for_good = np.diff(_lowest_from_here(np.append(lateness, of_last))[:-1])
    missing = np.where(for_good > tolerated, np.rint(for_good / period), 0).astype(np.int64)
    paused = for_good > max(PAUSE_S, PAUSE_PERIODS * period)
    took = np.concatenate([[0.0], np.cumsum(np.where(paused, brought * period, passed))])
    rate = _rate(took, np.concatenate([[0], np.cumsum(brought + np.where(paused, 0, missing))]))
    for start, number in zip(starts[1:-1][missing > 0].tolist(), missing[missing > 0].tolist(), strict=True):
        counts[start:] += number
    even = from_rate(counts, ordinals, rate)
    longest = max(PAUSE_S, PAUSE_PERIODS / rate)
    gaps = tuple(
        dataclasses.replace(gap, kind=GapKind.PAUSE) if gap.kind is GapKind.DROPPED and gap.length_s > longest else gap
        for gap in even.gaps
    )
    return dataclasses.replace(even, gaps=gaps)


def _period(passed: FloatArray, brought: IntArray) -> tuple[float, float]:
    """Return the time of one sample, the mean over bursts that came in time, and how late these are at most, in s."""
    usual = float(np.median(passed / brought))
    late = passed - brought * usual
    tolerated = max(0.75 * usual, 5 * 1.4826 * float(np.median(np.abs(late - np.median(late)))))
    in_time = np.abs(late) <= tolerated
    return float(passed[in_time].sum() / brought[in_time].sum()) if in_time.any() else usual, tolerated


def _rate(took: FloatArray, samples: IntArray) -> float:
    """Return the samples over the time that they took, each counted until a burst, by the medians at either end."""
    few = max(1, min(_ENDS, len(took) // 3))
    period = (took[-1] - took[0]) / (samples[-1] - samples[0])
    late = took - samples * period
    drift = (np.median(late[-few:]) - np.median(late[:few])) / (np.median(samples[-few:]) - np.median(samples[:few]))
    return float(1 / (period + drift))


def _lowest_from_here(lateness: FloatArray) -> FloatArray:
    """Return the least lateness of each burst and those after it, shape (n,): what was not made up for."""
    following = np.concatenate([lateness, np.full(_MAKES_UP - 1, np.inf)])
    return np.asarray(np.lib.stride_tricks.sliding_window_view(following, _MAKES_UP).min(axis=1), dtype=np.float64)
