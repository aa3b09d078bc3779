"""Clock times in files, and what instant they are: ISO-8601 dates, times of day, columns of both, counts from an epoch.

A time without zone is local to the book's time zone; one that exists twice or never, where the clocks are changed, gets
no instant. Dates as 03/04/2019 are not guessed at.

People and loggers write `5.6.2021`, `06/05/21 1:02:03 PM`, `12:30.5`. The order of day and month, and whether `12:30`
begins with hours or minutes, is declared, or follows from a value that only one order allows; it is never guessed.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from fractions import Fraction
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

from data_schema.errors import UsageError
from ingest.model import FILE, NOTE, Declarations, FindingCollector, FloatArray

_DAY_S = 86_400.0
_LAST_OF_DAY_US = 86_399_999_999
_EARLIEST_EPOCH_S = datetime(2000, 1, 1, tzinfo=UTC).timestamp()
_LATEST_EPOCH_S = datetime(2050, 1, 1, tzinfo=UTC).timestamp()
_FIRST_DAY = date(2000, 1, 1)
_UNIX_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_TIME_OF_DAY = re.compile(rb"(\d{1,3}):(\d\d):(\d\d(?:[.,]\d+)?)")


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
    first, second = (moment.replace(tzinfo=local_zone, fold=fold) for fold in (0, 1))
    if first.utcoffset() != second.utcoffset():
        message = f"At {text} the clocks in {zone} were changed: the time exists twice or never; kept as text only."
        findings.add(NOTE, "instant_unclear", message, value=text)
        return None
    return _format(first)


_UNIX_EPOCH_TICKS = {"filetime": 116_444_736_000_000_000, "d": 25_569}
"""1970 in units that count from an epoch of their own: 1601 of Windows, 1899-12-30 of spreadsheets; else it is 0."""


def epoch_time(ticks: float, unit: str, ticks_per_second: float) -> str | None:
    """Return the instant of a count of ticks that can only be a date of the years 2000 to 2050, else None.

    It is Unix time, Windows FILETIME (100 ns since 1601), or in days, without a zone, the serial date of a spreadsheet.
    """
    since_1970 = ticks - _UNIX_EPOCH_TICKS.get(unit, 0)
    if not _EARLIEST_EPOCH_S <= since_1970 / ticks_per_second < _LATEST_EPOCH_S:
        return None
    exact = Fraction(since_1970) / Fraction(ticks_per_second)
    instant = _format(_UNIX_EPOCH + timedelta(microseconds=round(exact * 1_000_000)))
    return instant.removesuffix("Z") if instant and unit == "d" else instant


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
        return _unwrapped(np.array([_time_of_day(cell) for cell in cells], dtype=np.float64), _DAY_S, findings)
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
    return (moment - _UNIX_EPOCH).total_seconds()


_PLAIN = re.compile(rb"(?:\d{4}-\d\d-\d\d[ T])?\d{1,3}:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?|\d{4}-\d\d-\d\d")
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

    Dates beside the times that are not clear, and of which nothing is declared, are left out, which is noted. Where
    the dates have times of day of their own they are the instants, and the column of times gives the axis alone: it may
    as well be elapsed time.
    """
    clocks = _texts(times)
    first = parse_stamp(clocks[0]) if clocks else None
    if first is not None and first.date is not None:
        dates = None
    elif dates is not None and declared.date_format is None:
        dates = _without_unclear(dates, findings)
    if dates is None:
        return _read_texts(times, clocks, column, declared, findings)
    days = _texts(dates)
    if any(map(_is_within_day, set(days))):
        axis = _read_texts(times, clocks, column, dataclasses.replace(declared, date_format=None), findings)
        instants = _read_texts(dates, days, column, dataclasses.replace(declared, clock_format=None), findings)
        return dataclasses.replace(instants, seconds=axis.seconds)
    texts = [f"{date_text(day)} {clock}" for day, clock in zip(days, clocks, strict=True)]
    return _interpreted(texts, column, declared, findings)


def _texts(cells: Sequence[bytes]) -> list[str]:
    return [cell.decode("ascii", errors="replace").strip() for cell in cells]


def _is_within_day(text: str) -> bool:
    """Whether a date has a time other than midnight, which spreadsheets write behind a date alone."""
    stamp = parse_stamp(text)
    order = None if stamp is None else clock_order([stamp], None)
    return stamp is not None and isinstance(order, str) and bool(seconds_of(stamp, order))


def _read_texts(
    cells: Sequence[bytes], texts: list[str], column: str, declared: Declarations, findings: FindingCollector
) -> ClockColumn:
    nothing_declared = declared.date_format is None and declared.clock_format is None
    if nothing_declared and all(_PLAIN.fullmatch(cell.strip()) for cell in cells[:1]):
        return ClockColumn(clock_seconds(cells, findings), texts, texts)
    return _interpreted(texts, column, declared, findings)


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
        day = _DAY_S * (found - _FIRST_DAY).days
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


DATE_FORMATS = ("y-m-d", "d.m.y", "d/m/y", "m/d/y")
"""Orders of year, month and day; the signs between them may be any of `-`, `.` and `/`."""

CLOCK_FORMATS = ("h:m:s", "h:m", "m:s")
"""What the parts of a clock time are; the last one may have decimals."""

_DATE = re.compile(r"(?<!\d)(\d{1,4})([-./])\s?(\d{1,2})\2\s?(\d{4}|\d{1,2})(?!\d)")
_CLOCK = re.compile(r"(\d{1,3}):(\d\d)(?::(\d\d))?(?:[.,](\d+))?\s*([AaPp]\.?[Mm]\.?)?")


@dataclass(frozen=True, slots=True)
class Stamp:
    """The parts of a text, not interpreted yet: date as (first, second, third, sign), clock as (first, second, third,
    decimals, am or pm), each as written, None where it is not there.
    """

    date: tuple[str, str, str, str] | None
    clock: tuple[str, str, str | None, str, str] | None


@dataclass(frozen=True, slots=True)
class Unclear:
    """Why the texts of a column cannot be read: `rule` and `message` of the finding."""

    rule: str
    message: str


def parse_stamp(text: str) -> Stamp | None:
    """Take a date, a clock time, or both in any order apart; None for a text that is something else."""
    found = _DATE.search(text)
    rest = text if found is None else text[: found.start()] + " " + text[found.end() :]
    rest = rest.strip(" \tT,")
    clock = _CLOCK.fullmatch(rest) if rest else None
    if (rest and clock is None) or (found is None and clock is None):
        return None
    return Stamp(
        None if found is None else (found[1], found[3], found[4], found[2]),
        None if clock is None else (clock[1], clock[2], clock[3], clock[4] or "", (clock[5] or "").lower()[:1]),
    )


def date_text(text: str) -> str:
    """Return the date in a text as written, the text itself where it has none."""
    found = _DATE.search(text)
    return text if found is None else found[0]


def date_order(stamps: Iterable[Stamp], declared: str | None) -> str | Unclear | None:
    """Return the order of the dates in a column, one of `DATE_FORMATS`; None where it has none.

    A date that begins with a year of four digits is read as such whatever the others are.
    """
    dates = {stamp.date for stamp in stamps if stamp.date is not None}
    if not dates:
        return None
    others = {written for written in dates if len(written[0]) != 4}
    example = min(others or dates)
    shown = example[3].join(example[:3])
    if not others:
        if declared in (None, "y-m-d"):
            return "y-m-d"
        return Unclear("date_contradicts", f"{shown!r} begins with the year and {declared} is declared: correct that.")
    if declared is not None:
        return declared
    dates, first = others, {int(written[0]) for written in others}
    if all(written[3] == "." for written in dates):
        return "d.m.y"
    second = {int(written[1]) for written in dates}
    if max(first) > 12 >= max(second):
        return "d/m/y"
    if max(second) > 12 >= max(first):
        return "m/d/y"
    return Unclear(
        "date_unclear", f"{shown!r} may be day or month first: say which with `--dates d/m/y` or `--dates m/d/y`."
    )


def clock_order(stamps: Iterable[Stamp], declared: str | None) -> str | Unclear | None:
    """Return what the parts of the clock times of a column are, one of `CLOCK_FORMATS`; None where it has none."""
    with_date = False
    clocks = set()
    for stamp in stamps:
        if stamp.clock is not None:
            clocks.add(stamp.clock)
            with_date |= stamp.date is not None
    if not clocks:
        return None
    if any(clock[2] is not None for clock in clocks):
        return "h:m:s"
    if declared is not None:
        return declared
    if any(clock[4] for clock in clocks) or with_date:
        return "h:m"
    if any(clock[3] for clock in clocks) or max(int(clock[0]) for clock in clocks) > 23:
        return "m:s"
    example = min(clocks)
    return Unclear(
        "clock_unclear",
        f"'{example[0]}:{example[1]}' may be hours or minutes first: say which with `--clock m:s` or `--clock h:m`.",
    )


def day_of(stamp: Stamp, order: str) -> date | None:
    """Return the date of a stamp in an order of `DATE_FORMATS`; None where there is none, or no such day."""
    if stamp.date is None:
        return None
    a, b, c, _ = stamp.date
    if (len(a) == 4) != (order == "y-m-d"):
        if len(a) != 4:
            return None
        order = "y-m-d"
    year, month, day = {"y-m-d": (a, b, c), "d.m.y": (c, b, a), "d/m/y": (c, b, a), "m/d/y": (c, a, b)}[order]
    if len(year) not in (2, 4):
        return None
    try:
        return date(int(year) + (2000 if len(year) == 2 else 0), int(month), int(day))
    except ValueError:
        return None


def seconds_of(stamp: Stamp, order: str) -> float | None:
    """Return the clock time of a stamp in seconds, in an order of `CLOCK_FORMATS`; None where it is no such time."""
    if stamp.clock is None:
        return None
    first, second, third, decimals, half = stamp.clock
    one, two = int(first), int(second)
    fraction = float(f"0.{decimals or 0}")
    if two > 59:
        return None
    if third is None and order == "m:s":
        return 60.0 * one + two + fraction
    if (third is None) == (order == "h:m:s") or one > 23 or (half and not 1 <= one <= 12):
        return None
    if half:
        one = one % 12 + (12 if half == "p" else 0)
    if third is None:
        return 3600.0 * one + 60.0 * (two + fraction)
    return None if int(third) > 59 else 3600.0 * one + 60.0 * two + int(third) + fraction


def iso_text(text: str, order: str) -> str:
    """Return a date with or without a clock time as ISO-8601, the text itself where it is no such date."""
    stamp = parse_stamp(text)
    day = None if stamp is None else day_of(stamp, order)
    if stamp is None or day is None:
        return text
    if stamp.clock is None:
        return day.isoformat()
    seconds = seconds_of(stamp, "h:m" if stamp.clock[2] is None else "h:m:s")
    return text if seconds is None else f"{day.isoformat()}T{iso_clock(seconds)}"


def iso_clock(seconds: float) -> str:
    """Return seconds of a day as `hh:mm:ss`, with microseconds where there are any; the last one is never midnight."""
    whole = min(round(seconds * 1e6), _LAST_OF_DAY_US)
    return (_UNIX_EPOCH + timedelta(microseconds=whole)).time().isoformat()
