"""The value of a table's cell, how a line is split into cells, and by which delimiter.

Only ASCII spellings count as numbers: Python's own `float` would also take `1_000` and Arabic digits.
"""

from __future__ import annotations

import csv
import dataclasses
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ingest.model import FILE, NOTE, Declarations, FindingCollector
from ingest.text.source import SEPARATORS, Line, TextSource

EXPONENT = rb"(?:[eE][+-]?\d+|[dD][+-]\d+)?"
"""D is that of double precision in Fortran, which writes a sign behind it."""
NUMBER_PATTERN = rb"[+-]?(?:\d+\.?\d*|\.\d+)" + EXPONENT
NUMBER = re.compile(NUMBER_PATTERN)
COMMA_NUMBER = re.compile(rb"[+-]?(?:\d+,\d*|,\d+)" + EXPONENT)
_INTEGER = re.compile(rb"[+-]?\d{1,19}")
_GROUPED = re.compile(rb"[+-]?\d{1,3}(?:(?:[ '.]\d{3})+(?:,\d+)?|(?:[ ',]\d{3})+(?:\.\d+)?)")
_MAY_GROUP = re.compile(rb"[+-]?[1-9]\d{0,2}[.,]\d{3}")
_NAN = re.compile(rb"[+-]?nan(?:\([0-9a-z_]*\))?")
_MISSING = frozenset(
    {b"", b"na", b"n/a", b"#n/a", b"null", b"none", b"-", b"--", b"---", b"1.#qnan", b"1.#ind", b"1.#snan"}
)
_INFINITE = frozenset({b"inf", b"infinity", b"1.#inf"})
CLOCK_PATTERN = rb"(?:\d{4}-\d\d-\d\d[ T])?\d{1,2}:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?"
_CLOCK = re.compile(CLOCK_PATTERN + rb"|\d{4}-\d\d-\d\d(?:[ T]\d\d:\d\d)?")

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
    f"A number uses the other decimal sign than its file; {_ROW_OUT}; write one throughout.",
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


def value_of(number: bytes) -> float:
    """Return the value of a cell that `NUMBER` matches."""
    return float(number.lower().replace(b"d", b"e"))


def _finite(cell: bytes) -> float | CellFault:
    value = value_of(cell)
    return NOT_FINITE if value in (INFINITY, -INFINITY) else value


def integer_of(cell: bytes) -> int | None:
    """Return the integer in a stripped cell, None where it holds none or one beyond 64 bits."""
    if not _INTEGER.fullmatch(cell):
        return None
    number = int(cell)
    return number if -(2**63) <= number < 2**63 else None


def is_missing(cell: bytes) -> bool:
    """Whether a stripped cell, lower case, is one of the spellings of a missing value."""
    unsigned = cell.lstrip(b"+-") or cell  # a lone plus is what is left of a damaged number
    return cell in _MISSING or unsigned in _MISSING or _NAN.fullmatch(cell) is not None


def is_infinite(cell: bytes) -> bool:
    """Whether a stripped cell, lower case, is one of the spellings of infinity."""
    return cell.lstrip(b"+-") in _INFINITE


def is_number(cell: bytes, comma: bool) -> bool:
    """Whether a stripped cell is a number, with a decimal comma too where `comma` allows it."""
    return NUMBER.fullmatch(cell) is not None or (comma and COMMA_NUMBER.fullmatch(cell) is not None)


def is_grouped(cell: bytes) -> bool:
    """Whether a stripped cell is a number with thousands separators."""
    return _GROUPED.fullmatch(cell) is not None


def may_group(cell: bytes) -> bool:
    """Whether a stripped cell is a number as `1,002` or `1.002`, whose sign may be a decimal or group thousands."""
    return _MAY_GROUP.fullmatch(cell) is not None


def decimal_sign_of(cells: Sequence[bytes]) -> tuple[bytes, bytes | None]:
    """Return the decimal sign of most numbers among stripped cells, and one of those with a comma where all of these
    may group thousands.
    """
    commas = [cell for cell in cells if COMMA_NUMBER.fullmatch(cell)]
    points = sum(b"." in cell for cell in cells if NUMBER.fullmatch(cell))
    if not commas or points > len(commas):
        return b".", None
    return b",", commas[0] if all(map(may_group, commas)) else None


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


def too_wide(width: int, declared: Declarations, findings: FindingCollector) -> bool:
    """Report rows of more columns than a file may have; they are not read."""
    most = declared.limits.most_columns
    if width <= most:
        return False
    message = f"The rows have {width} columns, more than {most} (limit most_columns); "
    findings.add(FILE, "too_many_columns", message + "export one sample a line, not one a column.")
    return True


# A single space stands for any run of blanks; last, because blanks also pad other separators.
BETWEEN_CELLS = tuple(bytes([sign]) for sign in SEPARATORS)
CANDIDATES = (*BETWEEN_CELLS, b" ")
ONE_COLUMN = b"\x1f"
"""Stands for no delimiter: a character that no line holds."""


def texts_of(source: TextSource, line: Line, delimiter: bytes) -> list[str]:
    """Return the cells of a line as text; none where a quote is out of place."""
    return [source.decode(cell) for cell in split_cells(line.content, delimiter) or []]


_CLOCK_COMMA = re.compile(rb"(?m)(?<=\d:[0-5]\d:[0-5]\d),(?=(?:\d{3}|\d{6})(?:,|\s*$))")


def with_clock_points(source: TextSource, findings: FindingCollector) -> TextSource:
    """Return a text with a point for the comma before the milliseconds of clock times, `12:00:00,010`, of the same
    length, where a comma stands between cells, too, and the line above the first such row has so many fewer.
    """
    lines = [line.content for line in source.head_lines() if line.content.strip()]
    first = next((at for at, line in enumerate(lines) if _CLOCK_COMMA.search(line)), 0)
    fewer = len(_CLOCK_COMMA.findall(lines[first])) if first else 0
    if not fewer or lines[first - 1].count(b",") != lines[first].count(b",") - fewer:
        return source
    message = (
        "The comma before milliseconds of a clock time is read as their decimal sign, as the header has fewer cells."
    )
    findings.add(NOTE, "clock_decimal_comma", message)
    data = source.data[: source.start] + _CLOCK_COMMA.sub(b".", source.data[source.start :])
    return dataclasses.replace(source, data=data)


# A name begins with a letter, so that a row of numbers or clock times, cut anywhere, is none.
_NUMBER = re.compile(rb"[+-]?(?:\d+[.,]?\d*|\.\d+)" + EXPONENT + rb"(?:\s*[A-Za-z%/*^0-9]{1,8})?")
_DEBUG_LINE = re.compile(rb"\s*([A-Za-z_][\w ./\[\]()-]{0,60}?)\s*[:=]\s*(\S.*?)\s*")


LABEL_CLUE = rb"[a-z_][\w \t./%()\[\]\"-]{0,80}[:=]"
"""What every text holds in which values bear names, in lower case."""


class DebugLine(NamedTuple):
    """A line that programs print beside, or instead of, a table: `Acceleration: 9.46`, `motor1: -2957986`.

    The name before the colon or equals sign, and the text after it, both stripped.
    """

    name: bytes
    value: bytes


def debug_line(content: bytes) -> DebugLine | None:
    """Return the parts of a line `name: value` or `name = value`, None for any other line."""
    match = _DEBUG_LINE.fullmatch(content)
    return None if match is None else DebugLine(match[1], match[2])


def is_single_number(line: DebugLine | None) -> bool:
    """Whether the text after the name is one number, a unit perhaps behind it: such a line is no row of a table."""
    return line is not None and _NUMBER.fullmatch(line.value) is not None


_ROWS_JUDGED = 60
_CLOSE = 0.98
"""Splits of this share of the best quality may be meant as well."""


@dataclass(frozen=True, slots=True)
class Row:
    """A line split into cells; `data_like` when at least half of its cells are numbers, times or missing."""

    line: Line
    cells: list[bytes]
    data_like: bool
    share: float


@dataclass(frozen=True, slots=True)
class Split:
    """The sample under one delimiter: `head` the first lines, `rows` the data rows of the usual `width`."""

    delimiter: bytes
    width: int
    head: tuple[Row, ...]
    rows: tuple[Row, ...]
    quality: float


def best_split(head: list[Line], further: list[Line], delimiter: bytes | None = None) -> Split | None:
    """Return the sample under its most likely delimiter, None when no line looks like data.

    Judged on rows of numbers only, so that titles and header lines with other separators do not disturb it: every
    candidate splits the sample, the one that gives most rows of one width and of nothing but numbers wins.
    `head` are the first lines of the file, `further` lines from deeper inside; `delimiter` is the one declared.
    """
    possible: list[Split] = []
    best = 0.0
    for tried in _frequent([*head, *further]) if delimiter is None else [delimiter]:
        split = _split(head, further, tried, _CLOSE * best)
        if split is not None and split.rows:
            possible.append(split)
            best = max(best, split.quality)
    if not possible:
        return None
    close = [split for split in possible if split.quality >= _CLOSE * best]
    return max(close, key=lambda split: (_has_header(split), split.width > 1))


def _frequent(lines: list[Line]) -> list[bytes]:
    """Return the delimiters that half of the lines hold, and that there may be none."""
    filled = [line for line in lines if line.content.strip() and not _is_debug(line)]
    return [
        *(sign for sign in CANDIDATES if sum(sign in line.content for line in filled) * 2 >= len(filled)),
        ONE_COLUMN,
    ]


def row_of(line: Line, delimiter: bytes) -> Row:
    """Split one line and judge whether it holds data."""
    cells = split_cells(line.content, delimiter) or []
    numbers = empty = 0
    for cell in cells:
        if is_number(cell, comma=True) or is_clock(cell) or is_grouped(cell):
            numbers += 1
        elif is_missing(cell.lower()):
            empty += 1
    share = (numbers + empty) / len(cells) if cells else 0.0
    return Row(line, cells, numbers > 0 and share >= 0.5 and not _is_debug(line), share)


def _is_debug(line: Line) -> bool:
    return is_single_number(debug_line(line.content))


def _split(head: list[Line], further: list[Line], delimiter: bytes, least: float = 0.0) -> Split | None:
    """Split the sample; None where the rows from deeper inside already rule out a quality of `least`."""
    deeper = [row for line in further if (row := row_of(line, delimiter)).data_like]
    if len(deeper) + min(len(head), _ROWS_JUDGED) < least:
        return None
    rows = []
    data_rows = []
    for line in head:
        row = row_of(line, delimiter)
        rows.append(row)
        if row.data_like:
            data_rows.append(row)
            if len(data_rows) == _ROWS_JUDGED:
                break
    data_rows += deeper
    widths = Counter(len(row.cells) for row in data_rows)
    if not widths:
        return Split(delimiter, 0, tuple(rows), (), 0.0)
    width, _ = widths.most_common(1)[0]
    usual = tuple(row for row in data_rows if len(row.cells) == width)
    return Split(delimiter, width, tuple(rows), usual, sum(row.share for row in usual))


def _has_header(split: Split) -> bool:
    """Whether some line above the first data row has as many cells and no number."""
    for row in split.head:
        if row.data_like:
            return False
        if len(row.cells) == split.width and row.share == 0.0:
            return True
    return False
