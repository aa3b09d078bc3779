"""Clock times in files: ISO-8601 dates, times of day, instants counted from an epoch; and what instant they are.

A time without zone is local to the book's time zone. Where summer time begins or ends some local times never or twice
exist: these get no instant. Dates as 03/04/2019 are not guessed at.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

from data_schema.errors import UsageError
from ingest.findings import NOTE, FindingCollector
from ingest.model import FloatArray

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
    """Return the instant of a date and time as ISO-8601 UTC, or None, noted, when the text does not tell one."""
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
