"""The time axis of a recording: elapsed seconds, mean rate, gaps; from a time column, or from a given rate.

Whole milliseconds make the median step useless: 300 Hz shows steps of 3, 3, 4 ms and 333 Hz of 3, 3, 3, with one
median. The rate is therefore counted from end to end, samples that were dropped counted in and pauses left out.

Stamps may also come in bursts: then they are times at which packets arrived, ten samples at once, and not when samples
were taken. Between one burst and the next passes the time of the samples in it, so the rate is samples over time and
the axis even. Samples that were lost are seen from bursts that bring too few for the time that passed, and that no
later ones make up for: a burst that comes late, and the few after it that come the sooner, have lost nothing.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from data_schema.vocabulary import GapKind
from ingest.channels.names import multiple_in, normal_unit
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import FloatArray, Gap, IntArray
from ingest.spool import by_blocks

PAUSE_S = 1.0
PAUSE_PERIODS = 10.0
"""A hole longer than both is a pause of the recording, a shorter one dropped packets."""

GAP_RULES = (
    (GapKind.DROPPED, "packets_dropped", "Samples are missing: recorded as gaps, nothing is interpolated."),
    (GapKind.PAUSE, "recording_paused", "The recording pauses: recorded as gaps."),
)
"""How gaps are reported; those of rejected rows are reported by what rejected them."""

RATE_NOTED = 0.005
RATE_REFUSED = 0.05

TICKS_PER_SECOND = {
    "s": 1.0,
    "ms": 1e3,
    "us": 1e6,
    "ns": 1e9,
    "filetime": 1e7,
    "min": 1 / 60,
    "h": 1 / 3600,
    "d": 1 / 86_400,
}
"""Units of a time column."""
_MULTIPLE = re.compile(r"(1/[1-9]\d*|\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)\s*([A-Za-zµμ]+)")


def ticks_per_second(unit: str | None) -> float | None:
    """Return the ticks a second of a unit of time, or of a multiple such as `0.1 ms`; None where it is neither."""
    multiple = None if unit is None else _MULTIPLE.fullmatch(unit)
    if multiple is None:
        return TICKS_PER_SECOND.get(unit or "")
    number, known = multiple_in(multiple[1]), TICKS_PER_SECOND.get(normal_unit(multiple[2]) or "")
    return known / number if known and number else None


@dataclass(frozen=True, slots=True, eq=False)
class Timebase:
    """Elapsed time of the samples, shape (n,), seconds from the first one; mean rate; gaps in order of time."""

    time_s: FloatArray
    rate_hz: float | None
    gaps: tuple[Gap, ...]


def from_stamps(seconds: FloatArray, ordinals: IntArray) -> Timebase:
    """Build the axis from strictly increasing stamps of one segment, shape (n,).

    `ordinals` number the rows as they stand in the file: rows rejected in between leave a hole of that kind.
    """
    first_s = seconds[0]
    time_s = by_blocks(seconds, lambda block: block - first_s)
    if len(time_s) < 2:
        return Timebase(time_s, None, ())
    steps = np.diff(time_s)
    period = usual_step(steps)
    holes = _holes(steps, period)
    inside = np.rint(steps[holes] / period).astype(np.int64) - 1
    paused = steps[holes] > max(PAUSE_S, PAUSE_PERIODS * period)
    recorded = float(time_s[-1]) - float(steps[holes][paused].sum())
    intervals = len(steps) - int(paused.sum()) + int(inside[~paused].sum())
    rate = intervals / recorded if recorded > 0 else 1 / period
    gaps = []
    for hole, pause in zip(holes.tolist(), paused.tolist(), strict=True):
        missing = max(1, round(float(steps[hole]) * rate) - 1)
        gap = _gap(float(time_s[hole]), float(steps[hole]), missing, ordinals, hole)
        gaps.append(dataclasses.replace(gap, kind=GapKind.PAUSE) if pause else gap)
    return Timebase(time_s, rate, tuple(gaps))


def from_rate(counts: IntArray, ordinals: IntArray, rate_hz: float) -> Timebase:
    """Build the axis of a file without time from its rate.

    `counts`, shape (n,), strictly increasing, number the samples as they were taken; `ordinals` the rows of the file.
    """
    time_s = (counts - counts[0]).astype(np.float64) / rate_hz
    steps = np.diff(counts)
    gaps = []
    for hole in np.flatnonzero(steps > 1).tolist():
        length_s = float(steps[hole]) / rate_hz
        gaps.append(_gap(float(time_s[hole]), length_s, int(steps[hole]) - 1, ordinals, hole))
    return Timebase(time_s, rate_hz, tuple(gaps))


def _gap(start_s: float, length_s: float, missing: int, ordinals: IntArray, row: int) -> Gap:
    """Return the gap behind a row: of rows that were rejected, where so many stand there, else of dropped samples."""
    rejected = int(ordinals[row + 1] - ordinals[row]) - 1
    return Gap(start_s, length_s, missing, missing, GapKind.REJECTED if rejected >= missing else GapKind.DROPPED)


def missing_samples(timebase: Timebase) -> int:
    """Return how many samples are missing without a pause and without rejected rows."""
    return sum(gap.samples_missing for gap in timebase.gaps if gap.kind is GapKind.DROPPED)


def rows_after_gaps(timebase: Timebase, kind: GapKind) -> IntArray:
    """Return the first row after every gap of a kind."""
    starts = np.array([gap.start_s for gap in timebase.gaps if gap.kind is kind], dtype=np.float64)
    return np.asarray(np.searchsorted(timebase.time_s, starts) + 1, dtype=np.int64)


def usual_step(steps: FloatArray) -> float:
    """Return the mean of the steps without holes: those up to 1.6 median steps (3, 3, 4 ms belong together)."""
    median = float(np.median(steps))
    return float(steps[steps <= 1.6 * median].mean())


def _holes(steps: FloatArray, period: float) -> IntArray:
    """Return the positions of steps in which samples are missing.

    A late sample that the next one makes up for is jitter: with its neighbour such a step still spans two periods.
    """
    long = np.flatnonzero(steps > 1.5 * period)
    if not long.size:
        return long
    padded = np.concatenate([[np.inf], steps, [np.inf]])
    with_neighbour = padded[long + 1] + np.minimum(padded[long], padded[long + 2])
    return np.asarray(long[with_neighbour > 2.5 * period], dtype=np.int64)


def check_rate(
    measured_hz: float,
    reference_hz: float,
    where: str,
    findings: FindingCollector,
    subject: str = "The time stamps give",
    remedy: str | None = "correct what is wrong, the time's unit with `--unit` or the rate with `--rate`",
) -> None:
    """Compare a rate with a reference: over 0.5 % apart is noted, over 5 % refuses the file.

    `subject` begins the sentence about `measured_hz`, the rate that is used; `where` is the source of `reference_hz`.
    Without a `remedy`, since a person has decided, any difference is only noted.
    """
    apart = abs(measured_hz / reference_hz - 1)
    if apart <= RATE_NOTED:
        return
    found = f"{subject} {measured_hz:.6g} Hz and {where} says {reference_hz:.6g} Hz"
    if apart <= RATE_REFUSED or remedy is None:
        findings.add(NOTE, "rate_differs", f"{found}: {measured_hz:.6g} Hz is used.")
    else:
        findings.add(
            FILE,
            "rate_contradicts",
            f"{found}: {remedy}.",
        )


_WITHIN = 0.5
"""A step below this share of the mean step lies within a burst."""
_SHORT, _FEWEST_SHORT = 0.25, 0.1
"""No jitter: so many steps are as short as this share of the mean step."""
_FEWEST_EQUAL = 0.01
"""A clock coarser than the samples, 1100 Hz in whole milliseconds: so many stamps, and ten, equal the one before."""
_FEWEST_BURSTS = 10
_REGULAR, _REGULAR_SHARE = 0.35, 0.7
_CONTINUOUS = 5.0
_LONGEST_STEP_S = 3600.0
_FEWEST_LONG, _LONG_TOGETHER = 20, 5
"""Steps of two ticks from which rounding is told from losses, and how many of them in a row vary by less than one."""
_TOGETHER = 20
"""Bursts over which their period is taken."""
_MOST_ROUNDED = 1.1
"""Samples by which a coarse clock makes a burst early or late."""
_MAKES_UP = 50
"""Bursts within which a delay is made up for; later ones would take the drift of a clock for it."""
_ENDS = 50
"""Bursts at either end, a third of all at most, whose usual lateness gives the duration of a recording."""
_MOST_ROWS = 1 << 20
"""A long recording that does not begin in bursts has none."""


def burst_starts(seconds: FloatArray) -> IntArray | None:
    """Return the rows at which bursts start, or None where stamps, shape (n,), come one by one.

    Rows of a burst repeat their stamp or follow in a small part of the mean step, and every burst brings about as many
    samples as fit into the time until the next, give or take the one by which a coarse clock rounds.
    """
    if len(seconds) > _MOST_ROWS and burst_starts(seconds[:_MOST_ROWS]) is None:
        return None
    if len(seconds) < 2 * _FEWEST_BURSTS or not np.isfinite(seconds).all():
        return None
    steps = np.diff(seconds)
    if steps.min() < 0 or not 0 < steps.max() <= _LONGEST_STEP_S:
        return None
    usual = steps[steps <= PAUSE_S] if (steps <= PAUSE_S).any() else steps
    mean = float(usual.mean())
    short, equal = np.count_nonzero(steps < _SHORT * mean), np.count_nonzero(steps == 0)
    if short < _FEWEST_SHORT * len(steps) and equal < max(_FEWEST_BURSTS, _FEWEST_EQUAL * len(steps)):
        return None
    starts = np.concatenate([[0], np.flatnonzero(steps >= _shortest_between(usual, mean)) + 1])
    if len(starts) < _FEWEST_BURSTS or np.diff(starts).max() < 2:
        return None
    passed, brought = np.diff(seconds[starts]), np.diff(starts)
    period = _usual_period(passed, brought)
    near = (np.abs(passed / (brought * period) - 1) < _REGULAR) | (np.abs(passed / period - brought) < 1)
    return np.asarray(starts, dtype=np.int64) if np.count_nonzero(near) >= _REGULAR_SHARE * len(near) else None


def are_rounded(seconds: FloatArray) -> bool:
    """Whether steps of one and of two ticks alternate as evenly as rounding to a decimal place spreads them: 700 Hz in
    whole milliseconds, or 1000 Hz of which samples are missing very evenly. Stamps have shape (n,).
    """
    steps = np.diff(seconds)
    tick = float(np.median(steps)) if len(steps) else 0.0
    n_long = np.count_nonzero((steps > 1.6 * tick) & (steps < 2.4 * tick))
    if tick <= 0 or n_long < _FEWEST_LONG or abs(np.log10(tick) - np.rint(np.log10(tick))) > 0.01:
        return False
    some = len(steps) * _LONG_TOGETHER // n_long
    sums = seconds[some:] - seconds[:-some]
    return bool(np.count_nonzero(np.abs(sums - np.median(sums)) < 1.1 * tick) >= 0.9 * len(sums))


def _shortest_between(steps: FloatArray, mean: float) -> float:
    """Return the shortest step from burst to burst: above the widest gap, by ratio, in the lengths of steps.

    Looked for from `_WITHIN` mean steps up to the usual long one, so that neither pauses nor jitter are taken for it.
    """
    longest = float(np.median(steps[steps > mean]))
    lengths = np.sort(steps[(steps > _WITHIN * mean) & (steps <= longest)])
    ratios = lengths / np.concatenate([[_WITHIN * mean], lengths[:-1]])
    return float(lengths[np.argmax(ratios)])


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
    # All samples of a burst have come by its last stamp, however a burst was parted or two of them joined.
    # How much of the last burst the file holds shows nothing; when it came, only what it made up for.
    brought = np.diff(counts[last_of_burst])[:-1]
    between = np.diff(seconds[last_of_burst])
    passed = between[:-1]
    steps = np.diff(seconds)
    period, tolerated = _burst_period(passed, brought, float(steps[steps > 0].min()))
    lateness = np.concatenate([[0.0], np.cumsum(passed - brought * period)])
    of_last = lateness[-1] + between[-1] - float(np.median(brought)) * period
    lowest = _lowest_from_each_on(np.append(lateness, of_last))[:-1]
    for_good = np.diff(lowest)
    # What the last bursts are late may yet be made up for, as it usually was before.
    is_last = np.arange(len(for_good)) >= len(for_good) - _MAKES_UP
    allowed = np.where(is_last, tolerated + float(np.percentile(lateness - lowest, 90)), tolerated)
    missing = np.where(for_good > allowed, np.rint(for_good / period), 0).astype(np.int64)
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


def _usual_period(passed: FloatArray, brought: IntArray) -> float:
    """Return the time of one sample: the median over bursts, of some together, for a coarse clock brings 1, 2, 2, 1."""
    some = min(_TOGETHER, len(passed) // 3 + 1)
    took, samples = (np.concatenate([[0], np.cumsum(each)]) for each in (passed, brought))
    return float(np.median((took[some:] - took[:-some]) / (samples[some:] - samples[:-some])))


def _burst_period(passed: FloatArray, brought: IntArray, tick: float) -> tuple[float, float]:
    """Return the time of one sample, the mean over bursts that came in time, and how late these are at most, in s.

    `tick` is the shortest time between two different stamps: a clock coarser than the samples makes a burst early or
    late by one of them, which does not add up.
    """
    usual = _usual_period(passed, brought)
    late = passed - brought * usual
    jitter = 5 * 1.4826 * float(np.median(np.abs(late - np.median(late))))
    in_time = np.abs(late) <= max(_MOST_ROUNDED * usual, jitter)
    period = float(passed[in_time].sum() / brought[in_time].sum()) if in_time.any() else usual
    is_coarse = tick > 0.5 * usual and float(np.percentile(np.abs(late), 95)) <= _MOST_ROUNDED * usual
    return period, 0.75 * usual if is_coarse else max(0.75 * usual, jitter)


def _rate(took: FloatArray, samples: IntArray) -> float:
    """Return the samples over the time that they took, each counted until a burst, by the medians at either end."""
    few = max(1, min(_ENDS, len(took) // 3))
    period = (took[-1] - took[0]) / (samples[-1] - samples[0])
    late = took - samples * period
    drift = (np.median(late[-few:]) - np.median(late[:few])) / (np.median(samples[-few:]) - np.median(samples[:few]))
    return float(1 / (period + drift))


def _lowest_from_each_on(lateness: FloatArray) -> FloatArray:
    """Return the least lateness of each burst and those after it, shape (n,): what was not made up for."""
    following = np.concatenate([lateness, np.full(_MAKES_UP - 1, np.inf)])
    return np.asarray(np.lib.stride_tricks.sliding_window_view(following, _MAKES_UP).min(axis=1), dtype=np.float64)
