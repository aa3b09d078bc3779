"""What one cell of a run sheet says; spreadsheets rewrite cells, so `25.0`, `9:05` and `12,5` are understood too.

Dates and times of day as people write them: what could be two days or two instants is asked, never guessed.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any
from zoneinfo import ZoneInfo

from data_schema.errors import InputRefused, unknown_name
from data_schema.vocabulary import RunKind
from labbook.config.reading import is_plain

DAY_FIRST, MONTH_FIRST = "d/m/y", "m/d/y"
FIRST, SECOND = "first", "second"
_ISO = re.compile(r"([0-9]{4})([-/])([0-9]{1,2})\2([0-9]{1,2})")
_DOTTED = re.compile(r"([0-9]{1,2})\.\s?([0-9]{1,2})\.\s?([0-9]{4})")
_SLASHED = re.compile(r"([0-9]{1,2})/([0-9]{1,2})/([0-9]{4})")
_CLOCK = re.compile(r"([0-9]{1,2}):([0-9]{2})(?::([0-9]{2}))?(Z|[+-][0-9]{2}:[0-9]{2})?")


class SheetQuestion(InputRefused):
    """What a person wrote could be two things: `option` (without `--`) with one of `choices` says which."""

    def __init__(self, sentence: str, option: str, choices: Mapping[str, str]) -> None:
        self.sentence, self.option, self.choices = sentence, option, choices
        options = " or ".join(f"`--{option} {choice}` ({meaning})" for choice, meaning in choices.items())
        super().__init__(f"{sentence}: say {options}.")


def date_reader(order: str | None = None) -> Callable[[str], datetime.date]:
    """Build the reader of a date: year-month-day, day.month.year, and with slashes in the `order` that was declared."""

    def read_date(cell: str) -> datetime.date:
        try:
            if (iso := _ISO.fullmatch(cell)) is not None:
                return datetime.date(int(iso[1]), int(iso[3]), int(iso[4]))
            if (dotted := _DOTTED.fullmatch(cell)) is not None:
                return datetime.date(int(dotted[3]), int(dotted[2]), int(dotted[1]))
            if (slashed := _SLASHED.fullmatch(cell)) is not None:
                return _slashed(cell, order, *map(int, slashed.groups()))
        except ValueError:
            pass  # a thirteenth month
        raise InputRefused(f"{cell!r} is not a date: write year-month-day, such as 2021-06-01, or 1.6.2021.")

    return read_date


def _slashed(cell: str, order: str | None, first: int, second: int, year: int) -> datetime.date:
    if order is None:
        raise SheetQuestion(
            f"the date {cell!r} does not say whether the day or the month comes first",
            "dates",
            {DAY_FIRST: "the day", MONTH_FIRST: "the month"},
        )
    day, month = (first, second) if order == DAY_FIRST else (second, first)
    return datetime.date(year, month, day)


def read_clock(cell: str) -> datetime.time:
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


def to_utc(
    date: datetime.date,
    clock: datetime.time,
    zone: ZoneInfo,
    fold: str | None = None,
    *,
    known_utc: str | None = None,
    what: str = "the run",
) -> str:
    """Return the instant of a local time as ISO text in UTC.

    A time that the change of clocks skips or repeats has two readings, by the offset before the change and after it:
    `fold` says which, or `known_utc`, where it is one of them. Raises `SheetQuestion`, about `what`, without both.
    """
    if clock.tzinfo is not None:
        return _text(datetime.datetime.combine(date, clock))
    readings = {
        choice: datetime.datetime.combine(date, clock, zone).replace(fold=place)
        for place, choice in enumerate((FIRST, SECOND))
    }
    offsets = {moment.utcoffset() for moment in readings.values()}
    if len(offsets) == 1:
        return _text(readings[FIRST])
    if fold is not None:
        return _text(readings[fold])
    if known_utc is not None and known_utc in map(_text, readings.values()):
        return known_utc
    there = readings[FIRST].astimezone(datetime.UTC).astimezone(zone).replace(tzinfo=None, fold=0)
    skipped = there != datetime.datetime.combine(date, clock)
    how = "clocks skip" if skipped else "clocks show twice"
    raise SheetQuestion(
        f"{what} started at {clock:%H:%M}, which {how} on {date} in {zone.key}",
        "fold",
        {choice: moment.isoformat(timespec="minutes")[11:] for choice, moment in readings.items()},
    )


def _text(moment: datetime.datetime) -> str:
    return moment.astimezone(datetime.UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


_NUMBER = re.compile(r"[+-]?[0-9]{1,15}(?:\.[0-9]{1,15}|,(?![0-9]{3}$)[0-9]{1,15})?")


_FORMULA = tuple("=+-@\t\r")
"""With these a spreadsheet begins a formula."""
_TEXT = "'"


def as_text(cell: object) -> object:
    """Return a cell that no spreadsheet takes for a formula: what begins like one gets an apostrophe, not numbers."""
    if isinstance(cell, str) and cell.startswith(_FORMULA) and as_float(cell) is None:
        return _TEXT + cell
    return cell


def without_mark(cell: str) -> str:
    """Return a cell without the apostrophe that `as_text` put before it."""
    return cell[1:] if cell.startswith(_TEXT) and cell[1:].startswith(_FORMULA) else cell


def as_float(cell: str) -> float | None:
    """Return a decimal number, written with a point or a comma, or None; `1,200` could be two numbers and is none."""
    return float(cell.replace(",", ".")) if _NUMBER.fullmatch(cell) else None


def read_name(cell: str) -> str:
    """Read the name of a run, robot or battery."""
    if not is_plain(cell):
        raise InputRefused(f"{cell!r} has unprintable characters: write a plain name.")
    return cell


def read_note(cell: str) -> str:
    """Read a note, of one or more lines."""
    if not is_plain("".join(cell.split())):
        raise InputRefused(f"{cell!r} has unprintable characters: write plain text.")
    return cell


def read_seconds(cell: str) -> float:
    """Read a duration, more than nothing and at most a day."""
    number = as_float(cell)
    if number is None or not 0.0 < number <= 86_400.0:
        raise InputRefused(f"{cell!r} is not a duration: write seconds, such as 720.")
    return number


def counted_from(least: int) -> Callable[[str], int]:
    """Build the reader of a whole number of `least` or more."""

    def read_count(cell: str) -> int:
        number = as_float(cell)
        if number is None or not number.is_integer() or not least <= number <= 1_000_000:
            raise InputRefused(f"{cell!r} is not a count: write a whole number, {least} or more.")
        return int(number)

    return read_count


def read_kind(cell: str) -> RunKind:
    """Read the kind of a run."""
    if cell not in list(RunKind):
        raise unknown_name("kind of run", cell, list(RunKind))
    return RunKind(cell)


def one_of(what: str, allowed: Iterable[str]) -> Callable[[str], str]:
    """Build the reader of one of the `allowed` names; a number may be written in another way (`400.0` for `400`)."""
    names = list(allowed)
    numbers = {as_float(name): name for name in names}

    def read_known(cell: str) -> str:
        if cell in names:
            return cell
        number = as_float(cell)
        if number is None or number not in numbers:
            raise unknown_name(what, cell, names)
        return numbers[number]

    return read_known


CELL_READERS: dict[str, Callable[[str], Any]] = {
    "run": read_name,
    "date": date_reader(),
    "position": counted_from(1),
    "kind": read_kind,
    "battery": read_name,
    "robot": read_name,
    "started": read_clock,
    "duration_s": read_seconds,
    "jumps_made": counted_from(0),
    "starts": counted_from(1),
    "note": read_note,
}
"""How the cells of each fixed column are read; an error's text is the sentence shown."""
