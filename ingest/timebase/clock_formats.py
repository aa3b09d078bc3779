"""Dates and clock times as people and loggers write them: `5.6.2021`, `06/05/21 1:02:03 PM`, `12:30.5`.

The order of day and month, and whether `12:30` begins with hours or minutes, is declared, or follows from a value that
only one order allows; it is never guessed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date

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
    """Return seconds of a day as `hh:mm:ss`, with microseconds where there are any."""
    whole = round(seconds * 1e6)
    hours, rest = divmod(whole // 1_000_000, 3600)
    text = f"{hours:02d}:{rest // 60:02d}:{rest % 60:02d}"
    return text + (f".{whole % 1_000_000:06d}" if whole % 1_000_000 else "")
