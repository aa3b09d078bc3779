"""Clock times in files, and what instant they are: ISO-8601 dates, times of day, columns of both, counts from an epoch.

A time without zone is local to the book's time zone. Where summer time begins or ends some local times never or twice
exist: these get no instant. Dates as 03/04/2019 are not guessed at.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

from data_schema.errors import UsageError
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import Declarations, FloatArray
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

_DAY_S = 86_400.0
_EARLIEST_EPOCH_S = datetime(2000, 1, 1, tzinfo=UTC).timestamp()
_LATEST_EPOCH_S = datetime(2100, 1, 1, tzinfo=UTC).timestamp()
_FILETIME_EPOCH = datetime(1601, 1, 1, tzinfo=UTC)
_TIME_OF_DAY = re.compile(rb"(\d{1,2}):(\d\d):(\d\d(?:[.,]\d+)?)")


def time_zone(name: str | None) -> ZoneInfo | None:
    """Return the zone of that name, None for None. Raises `UsageError` for a name that does not exist."""
    if name is None:
        return None
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        raise UsageError(f"{name!r} is not a time zone: give one as 'America/New_York' or 'UTC'.") from error


def to_utc(text: str, zone: str | None, findings: FindingCollector) -> str | None:
    """Return the instant of a date and time as ISO-8601 UTC, or None, noted, when the text has none."""
    try:
        moment = datetime.fromisoformat(text.strip().replace(",", "."))
    except ValueError:
        findings.add(NOTE, "instant_unknown", f"{text!r} is no ISO date and time: kept as text only.", value=text)
        return None
    if moment.year < 2000:
        findings.add(NOTE, "clock_implausible", "The clock was before the year 2000: it had not been set.", value=text)
    if moment.tzinfo is not None:
        return _format(moment)
    local_zone = time_zone(zone)
    if local_zone is None:
        message = "The time names no zone, and the book has none either: kept as text only."
        findings.add(NOTE, "instant_unknown", message, value=text)
        return None
    local = moment.replace(tzinfo=local_zone)
    twice = local.utcoffset() != local.replace(fold=1).utcoffset()
    if twice:
        message = f"At {text} the clocks in {zone} were changed: the time exists twice or never; kept as text only."
        findings.add(NOTE, "instant_unclear", message, value=text)
        return None
    return _format(local)


def epoch_utc(seconds: float) -> str | None:
    """Return the instant of a count of seconds that can only be Unix time (years 2000 to 2100), else None."""
    if not _EARLIEST_EPOCH_S <= seconds < _LATEST_EPOCH_S:
        return None
    return _format(datetime.fromtimestamp(seconds, tz=UTC))


def filetime_utc(ticks: int) -> str | None:
    """Return the instant of a Windows FILETIME (100 ns since 1601), None when beyond what a date can hold."""
    try:
        return _format(_FILETIME_EPOCH + timedelta(microseconds=ticks // 10))
    except OverflowError:
        return None


def _format(moment: datetime) -> str | None:
    try:
        return moment.astimezone(UTC).isoformat(timespec="microseconds").replace("+00:00", "Z")
    except OverflowError:
        return None


def clock_seconds(cells: Sequence[bytes], findings: FindingCollector) -> FloatArray:
    """Return clock texts as seconds, shape (n,), on one increasing axis; NaN where a text is no time.

    Times of day run on past midnight: a step back by more than half a day is the next day, which is noted.
    """
    if all(_TIME_OF_DAY.fullmatch(cell.strip()) for cell in cells[:1]):
        seconds = np.array([_time_of_day(cell) for cell in cells], dtype=np.float64)
        with np.errstate(invalid="ignore"):
            wraps = np.diff(seconds, prepend=seconds[:1]) < -_DAY_S / 2
        if wraps.any():
            findings.add(NOTE, "midnight_passed", "The clock passes midnight: the day after is counted on.")
        return np.asarray(seconds + _DAY_S * np.cumsum(wraps), dtype=np.float64)
    return np.array([_moment(cell) for cell in cells], dtype=np.float64)


def _time_of_day(cell: bytes) -> float:
    match = _TIME_OF_DAY.fullmatch(cell.strip())
    if match is None:
        return float("nan")
    return 3600.0 * int(match[1]) + 60.0 * int(match[2]) + float(match[3].replace(b",", b"."))


def _moment(cell: bytes) -> float:
    try:
        moment = datetime.fromisoformat(cell.decode("ascii").strip().replace(",", "."))
    except ValueError:
        return float("nan")
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    return (moment - datetime(1970, 1, 1, tzinfo=UTC)).total_seconds()


_PLAIN = re.compile(rb"(?:\d{4}-\d\d-\d\d[ T])?\d{1,2}:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?|\d{4}-\d\d-\d\d")
_HOUR_S = 3600.0


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
        return ClockColumn(_unwrapped(seconds, period, findings), texts, [None] * len(texts))
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


def _unwrapped(seconds: FloatArray, period_s: float, findings: FindingCollector) -> FloatArray:
    """Return clock times counted on where the clock begins anew: at midnight, or minutes at the full hour."""
    rows = np.flatnonzero(np.isfinite(seconds))
    wraps = np.diff(seconds[rows], prepend=seconds[rows][:1]) < -period_s / 2
    if wraps.any():
        rule, what = ("hour_passed", "the full hour") if period_s == _HOUR_S else ("midnight_passed", "midnight")
        findings.add(NOTE, rule, f"The clock passes {what}: what follows is counted on.", count=int(wraps.sum()))
    counted = seconds.copy()
    counted[rows] += period_s * np.cumsum(wraps)
    return counted
