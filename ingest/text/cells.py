"""What one cell of a table says: a number, a missing value, or why it is neither.

Only ASCII spellings count as numbers: Python's own `float` would also take `1_000` and Arabic digits.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass

NUMBER = re.compile(rb"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
COMMA_NUMBER = re.compile(rb"[+-]?(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?")
_GROUPED = re.compile(rb"[+-]?\d{1,3}(?:(?:[ '.]\d{3})+(?:,\d+)?|(?:[ ',]\d{3})+(?:\.\d+)?)")
_NAN = re.compile(rb"[+-]?nan(?:\([0-9a-z_]*\))?")
_MISSING = frozenset({b"", b"na", b"n/a", b"#n/a", b"null", b"none", b"-", b"--", b"1.#qnan", b"1.#ind", b"1.#snan"})
_INFINITE = frozenset({b"inf", b"infinity", b"1.#inf"})
_CLOCK = re.compile(
    rb"(?:\d{4}-\d\d-\d\d[ T])?\d{1,2}:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?|\d{4}-\d\d-\d\d(?:[ T]\d\d:\d\d)?"
)

_CLOCK_LIKE = re.compile(
    rb"(?:\d{1,4}([-./])\d{1,2}\1\d{1,4})?[ T,]*(?:\d{1,3}:\d\d(?::\d\d)?(?:[.,]\d+)? ?(?:[AaPp]\.?[Mm]\.?)?)?"
    rb"(?: +\d{1,4}([-./])\d{1,2}\2\d{1,4})?"
)

COMMENT_STARTS = (b"#", b"%", b"//")
"""With which lines of remarks begin."""

BLANKS = b" \t\r\n"
"""What may stand around the content of a cell."""

INFINITY = float("inf")
NAN = float("nan")


@dataclass(frozen=True, slots=True)
class CellFault:
    """Why a cell is neither a number nor a missing value; `rule` and `message` of the finding."""

    rule: str
    message: str


_ROW_OUT = "the row is left out"
NOT_A_NUMBER = CellFault("not_a_number", f"A cell is no number; {_ROW_OUT}.")
NOT_FINITE = CellFault("not_finite", f"A cell is infinite or beyond what a number can hold; {_ROW_OUT}.")
GROUPED = CellFault(
    "thousands_separator",
    f"A number holds a thousands separator, which can be misread by 1000; {_ROW_OUT}; export without.",
)
OTHER_DECIMAL = CellFault(
    "decimal_sign_mixed",
    f"A number uses the other decimal sign than its file; {_ROW_OUT}; declare it with `--decimal ,` or `--decimal .`.",
)


def parse_cell(cell: bytes, decimal: bytes) -> float | CellFault:
    """Return the number in a stripped cell, NaN for a missing value, or the fault. `decimal` is b"." or b","."""
    if NUMBER.fullmatch(cell):
        if decimal == b"." or b"." not in cell:
            return _finite(cell)
        return GROUPED if _GROUPED.fullmatch(cell) else OTHER_DECIMAL
    if COMMA_NUMBER.fullmatch(cell):
        if decimal == b",":
            return _finite(cell.replace(b",", b"."))
        return GROUPED if _GROUPED.fullmatch(cell) else OTHER_DECIMAL
    folded = cell.lower()
    if is_missing(folded):
        return NAN
    if is_infinite(folded):
        return NOT_FINITE
    return GROUPED if _GROUPED.fullmatch(cell) else NOT_A_NUMBER


def _finite(cell: bytes) -> float | CellFault:
    value = float(cell)
    return NOT_FINITE if value in (INFINITY, -INFINITY) else value


def is_missing(cell: bytes) -> bool:
    """Whether a stripped cell, lower case, is one of the spellings of a missing value."""
    return cell in _MISSING or cell.lstrip(b"+-") in _MISSING or _NAN.fullmatch(cell) is not None


def is_infinite(cell: bytes) -> bool:
    """Whether a stripped cell, lower case, is one of the spellings of infinity."""
    return cell.lstrip(b"+-") in _INFINITE


def is_number(cell: bytes, comma: bool) -> bool:
    """Whether a stripped cell is a number, with a decimal comma too where `comma` allows it."""
    return NUMBER.fullmatch(cell) is not None or (comma and COMMA_NUMBER.fullmatch(cell) is not None)


def is_grouped(cell: bytes) -> bool:
    """Whether a stripped cell is a number with thousands separators."""
    return _GROUPED.fullmatch(cell) is not None


def is_clock(cell: bytes) -> bool:
    """Whether a stripped cell is a date with time (ISO-8601) or a time of day."""
    return _CLOCK.fullmatch(cell) is not None


def is_clock_like(cell: bytes) -> bool:
    """Whether a stripped cell is a date, a time of day or both, in whatever order people write them."""
    return is_clock(cell) or (cell != b"" and _CLOCK_LIKE.fullmatch(cell) is not None)


def split_cells(line: bytes, delimiter: bytes) -> list[bytes] | None:
    """Split a line into stripped cells, quotes (`"`, doubled inside) honoured; None when a quote is out of place.

    A delimiter of one space means any run of spaces and tabs. Other blanks, as a damaged byte may be one, stay.
    """
    if b'"' not in line:
        if delimiter == b" ":
            return [cell for cell in line.replace(b"\t", b" ").rstrip(b"\r\n").split(b" ") if cell]
        return [cell.strip(BLANKS) for cell in line.split(delimiter)]
    text = line.decode("latin-1")
    if delimiter == b" ":
        text = text.replace("\t", " ").strip()
    rows = csv.reader([text], delimiter=delimiter.decode("latin-1"), strict=True, skipinitialspace=True)
    try:
        cells = [cell.encode("latin-1").strip(BLANKS) for cell in next(rows)]
    except csv.Error:
        return None
    return [cell for cell in cells if cell] if delimiter == b" " else cells
