"""The time axis of a recording: elapsed seconds, mean rate, gaps; from a time column, or from a rate that was stated.

Whole milliseconds make the median step useless: 300 Hz shows steps of 3, 3, 4 ms and 333 Hz of 3, 3, 3, with one
median. The rate is therefore counted from end to end, samples that were dropped counted in and pauses left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_schema.vocabulary import GapKind
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import FloatArray, Gap, IntArray
from ingest.spool.columns import by_blocks

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

TICKS_PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9, "filetime": 1e7, "min": 1 / 60, "h": 1 / 3600}
"""Units of a time column."""


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
    period = _period(steps)
    holes = _holes(steps, period)
    inside = np.rint(steps[holes] / period).astype(np.int64) - 1
    paused = steps[holes] > max(PAUSE_S, PAUSE_PERIODS * period)
    recorded = float(time_s[-1]) - float(steps[holes][paused].sum())
    intervals = len(steps) - int(paused.sum()) + int(inside[~paused].sum())
    rate = intervals / recorded if recorded > 0 else 1 / period
    gaps = []
    for hole, pause in zip(holes.tolist(), paused.tolist(), strict=True):
        missing = max(1, round(float(steps[hole]) * rate) - 1)
        rejected = int(ordinals[hole + 1] - ordinals[hole]) - 1
        kind = GapKind.PAUSE if pause else GapKind.REJECTED if rejected >= missing else GapKind.DROPPED
        gaps.append(Gap(float(time_s[hole]), float(steps[hole]), missing, missing, kind))
    return Timebase(time_s, rate, tuple(gaps))


def from_rate(counts: IntArray, ordinals: IntArray, rate_hz: float) -> Timebase:
    """Build the axis of a file without time from its rate.

    `counts`, shape (n,), strictly increasing, number the samples as they were taken; `ordinals` the rows of the file.
    """
    time_s = (counts - counts[0]).astype(np.float64) / rate_hz
    steps = np.diff(counts)
    gaps = []
    for hole in np.flatnonzero(steps > 1).tolist():
        missing = int(steps[hole]) - 1
        rejected = int(ordinals[hole + 1] - ordinals[hole]) - 1
        kind = GapKind.REJECTED if rejected >= missing else GapKind.DROPPED
        gaps.append(Gap(float(time_s[hole]), float(steps[hole]) / rate_hz, missing, missing, kind))
    return Timebase(time_s, rate_hz, tuple(gaps))


def rows_after_gaps(timebase: Timebase, kind: GapKind) -> IntArray:
    """Return the first row after every gap of a kind."""
    starts = np.array([gap.start_s for gap in timebase.gaps if gap.kind is kind], dtype=np.float64)
    return np.asarray(np.searchsorted(timebase.time_s, starts) + 1, dtype=np.int64)


def _period(steps: FloatArray) -> float:
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
    measured_hz: float, stated_hz: float, where: str, findings: FindingCollector, said: str = "The time stamps give"
) -> None:
    """Compare a rate with the one stated elsewhere: over 0.5 % apart is noted, over 5 % refuses the file.

    `said` begins the sentence about `measured_hz`, the rate that is used; `where` tells where `stated_hz` stands.
    """
    apart = abs(measured_hz / stated_hz - 1)
    if apart <= RATE_NOTED:
        return
    found = f"{said} {measured_hz:.6g} Hz and {where} says {stated_hz:.6g} Hz"
    if apart <= RATE_REFUSED:
        findings.add(NOTE, "rate_differs", f"{found}: {measured_hz:.6g} Hz is used.")
    else:
        findings.add(
            FILE,
            "rate_contradicts",
            f"{found}: correct what is wrong, the time's unit with `--unit` or the rate with `--rate`.",
        )
