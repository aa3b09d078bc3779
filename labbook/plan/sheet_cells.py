"""What one cell of a run sheet says; spreadsheets rewrite cells, so `25.0`, `9:05` and `12,5` are understood too."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

from data_schema.errors import InputRefused, unknown_name
from data_schema.vocabulary import RunKind
from labbook.config.tables import is_plain
from labbook.plan.sheet_times import date_reader, read_clock

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
