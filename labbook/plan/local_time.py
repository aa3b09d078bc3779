"""Dates and times of day as people write them: what could be two days or two instants is asked, never guessed."""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence
from zoneinfo import ZoneInfo

from data_schema.errors import InputRefused
from ingest.timebase.clock import Unclear, date_order, day_of, parse_stamp, seconds_of

_CLOCK = re.compile(r"([0-9]{1,2}):([0-9]{2})(?::([0-9]{2}))?(Z|[+-][0-9]{2}:[0-9]{2})?")


class SheetQuestion(InputRefused):
    """A date could be two days: `--dates` with one of `choices` says which."""

    choices = ("d/m/y", "m/d/y")

    def __init__(self, sentence: str) -> None:
        self.sentence = sentence
        super().__init__(f"{sentence}: say `--dates d/m/y` (the day) or `--dates m/d/y` (the month).")


def order_of_dates(cells: Sequence[str], declared: str | None) -> str | None:
    """Return the order of year, month and day in dates, None where there are none.

    Raises `SheetQuestion` where they could be of two orders and none is declared.
    """
    order = date_order([stamp for stamp in map(parse_stamp, cells) if stamp is not None], declared)
    if isinstance(order, Unclear):
        slashed = next(cell for cell in cells if not cell[:4].isdigit())
        raise SheetQuestion(f"the date {slashed!r} does not say whether the day or the month comes first")
    return order


def parse_date(cell: str, order: str | None = None) -> datetime.date:
    """Read a date in an order of `clock_formats.DATE_FORMATS`, or in the one that it shows alone."""
    stamp = parse_stamp(cell)
    order = order or order_of_dates([cell], None)
    found = None if stamp is None or order is None else day_of(stamp, order)
    if found is None or stamp is None or (stamp.clock is not None and seconds_of(stamp, "h:m:s") != 0.0):
        raise InputRefused(f"{cell!r} is not a date: write year-month-day, such as 2021-06-01, or 1.6.2021.")
    return found


def parse_clock(cell: str) -> datetime.time:
    """Read a time of day, with or without seconds, and with its offset from UTC where that is written."""
    match = _CLOCK.fullmatch(cell)
    try:
        if match is None:
            raise ValueError
        hour, minute, second = (int(part or 0) for part in match.groups()[:3])
        zone = None if match[4] is None else datetime.datetime.strptime(match[4], "%z").tzinfo
        return datetime.time(hour, minute, second, tzinfo=zone)
    except ValueError:
        raise InputRefused(f"{cell!r} is not a time of day: write hours and minutes, such as 14:05.") from None


def to_utc(date: datetime.date, clock: datetime.time, zone: ZoneInfo, what: str = "the run") -> str:
    """Return the instant of a local time as ISO text in UTC.

    Raises `InputRefused`, about `what`, for a time without an offset that the change of clocks skips or repeats.
    """
    if clock.tzinfo is not None:
        return _text(datetime.datetime.combine(date, clock))
    moment = datetime.datetime.combine(date, clock, zone)
    readings = [moment, moment.replace(fold=1)]
    if moment.utcoffset() != readings[1].utcoffset():
        either = " or ".join(one.isoformat(timespec="minutes")[11:] for one in readings)
        raise InputRefused(
            f"{what} started at {clock:%H:%M}, which clocks skip or show twice on {date} in {zone.key}: write it with "
            f"its offset from UTC, {either}."
        )
    return _text(moment)


def _text(moment: datetime.datetime) -> str:
    return moment.astimezone(datetime.UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
