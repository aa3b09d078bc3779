"""A column of clock texts, with the column of dates beside it, as seconds on one axis and as instants."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import Declarations, FloatArray
from ingest.timebase.clock import clock_seconds
from ingest.timebase.clock_formats import (
    Stamp,
    Unclear,
    clock_order,
    date_order,
    day_of,
    iso_clock,
    parse_stamp,
    seconds_of,
)

_PLAIN = re.compile(rb"(?:\d{4}-\d\d-\d\d[ T])?\d{1,2}:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?|\d{4}-\d\d-\d\d")
_DAY_S, _HOUR_S = 86_400.0, 3600.0


@dataclass(frozen=True, slots=True, eq=False)
class ClockColumn:
    """`seconds`, shape (n_rows,), on one axis, NaN where a text is no time; `texts` as written, date first; `iso` the
    same as ISO-8601, None where no date is known.
    """

    seconds: FloatArray
    texts: Sequence[str]
    iso: Sequence[str | None]


def read_clocks(
    times: Sequence[bytes],
    dates: Sequence[bytes] | None,
    column: str,
    declared: Declarations,
    findings: FindingCollector,
) -> ClockColumn:
    """Read clock texts in the formats declared, or in those that their values prove; what stays open is asked for.

    Dates beside the times that are not clear, and of which nothing is declared, are left out, which is noted.
    """
    clocks = [cell.decode("ascii", errors="replace").strip() for cell in times]
    nothing_declared = declared.date_format is None and declared.clock_format is None
    first = parse_stamp(clocks[0]) if clocks else None
    if first is not None and first.date is not None:
        dates = None
    elif dates is not None and declared.date_format is None:
        dates = _without_unclear(dates, findings)
    if dates is None and nothing_declared and all(_PLAIN.fullmatch(cell.strip()) for cell in times[:1]):
        return ClockColumn(clock_seconds(times, findings), clocks, clocks)
    texts = clocks
    if dates is not None:
        days = [cell.decode("ascii", errors="replace").strip() for cell in dates]
        texts = [f"{day} {clock}" for day, clock in zip(days, clocks, strict=True)]
    return _interpreted(texts, column, declared, findings)


def split_clocks(columns: Mapping[str, Sequence[bytes]]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the columns that hold clock times, with or without a date, and of those that hold dates."""
    firsts = {
        name: parse_stamp(cells[0].decode("ascii", errors="replace").strip()) if len(cells) else None
        for name, cells in columns.items()
    }
    stamps = {name: stamp for name, stamp in firsts.items() if stamp is not None}
    times = tuple(name for name, stamp in stamps.items() if stamp.clock is not None)
    return times, tuple(name for name, stamp in stamps.items() if stamp.clock is None)


def _without_unclear(dates: Sequence[bytes], findings: FindingCollector) -> Sequence[bytes] | None:
    stamps = [parse_stamp(cell.decode("ascii", errors="replace").strip()) for cell in dates]
    order = date_order([stamp for stamp in stamps if stamp is not None], None)
    if isinstance(order, Unclear):
        findings.add(NOTE, order.rule, f"The dates beside the times are not used: {order.message}")
    return dates if isinstance(order, str) else None


def _interpreted(texts: list[str], column: str, declared: Declarations, findings: FindingCollector) -> ClockColumn:
    stamps = [parse_stamp(text) for text in texts]
    read = [stamp for stamp in stamps if stamp is not None]
    orders = [date_order(read, declared.date_format), clock_order(read, declared.clock_format)]
    for order in orders:
        if isinstance(order, Unclear):
            findings.add(FILE, order.rule, order.message, column=column, value=texts[0])
    by_date, by_clock = (None if isinstance(order, Unclear) else order for order in orders)
    nothing = np.full(len(texts), np.nan)
    if any(isinstance(order, Unclear) for order in orders):
        return ClockColumn(nothing, texts, [None] * len(texts))
    seconds = np.array([_seconds(stamp, by_date, by_clock) for stamp in stamps], dtype=np.float64)
    if by_date is None:
        period = _HOUR_S if by_clock == "m:s" and not (seconds >= _HOUR_S).any() else _DAY_S
        return ClockColumn(_counted_on(seconds, period, findings), texts, [None] * len(texts))
    iso = [_iso(stamp, by_date, by_clock) for stamp in stamps]
    return ClockColumn(seconds, texts, iso)


def _seconds(stamp: Stamp | None, by_date: str | None, by_clock: str | None) -> float:
    if stamp is None:
        return float("nan")
    day = 0.0
    if by_date is not None:
        found = day_of(stamp, by_date)
        if found is None:
            return float("nan")
        day = _DAY_S * found.toordinal()
    seconds = 0.0 if by_clock is None else seconds_of(stamp, by_clock)
    return float("nan") if seconds is None else day + seconds


def _iso(stamp: Stamp | None, by_date: str, by_clock: str | None) -> str | None:
    day = None if stamp is None else day_of(stamp, by_date)
    if stamp is None or day is None:
        return None
    seconds = 0.0 if by_clock is None else seconds_of(stamp, by_clock)
    return None if seconds is None else f"{day.isoformat()}T{iso_clock(seconds)}"


def _counted_on(seconds: FloatArray, period_s: float, findings: FindingCollector) -> FloatArray:
    """Return clock times counted on where the clock begins anew: at midnight, or minutes at the full hour."""
    rows = np.flatnonzero(np.isfinite(seconds))
    wraps = np.diff(seconds[rows], prepend=seconds[rows][:1]) < -period_s / 2
    if wraps.any():
        rule, what = ("hour_passed", "the full hour") if period_s == _HOUR_S else ("midnight_passed", "midnight")
        findings.add(NOTE, rule, f"The clock passes {what}: what follows is counted on.", count=int(wraps.sum()))
    counted = seconds.copy()
    counted[rows] += period_s * np.cumsum(wraps)
    return counted
