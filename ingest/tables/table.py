"""Tables: the columns as the header describes them, and the rows as columns of numbers with the line each came from.

Every format ends here: text through `rows.text_table`, binary formats through `array_table`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from ingest.model import FloatArray, IntArray, TextShape
from ingest.text import may_group
from ingest.timebase.clock import date_order, day_of, iso_text, parse_stamp

_SAMPLING = (
    "sampl|acqui|digiti|abtast|akwizyc|pr[oó]bkowa|[eé]chantillon|muestreo|adquisi|campionament|amostragem|bemonster"
)
_RATE = "rate|freq|fréq|frec|frekv|stotliwo|hz"
_OF_SAMPLING = re.compile(rf"(?i)(?:{_SAMPLING})\w*.{{0,20}}?(?:{_RATE})|(?:{_RATE})\w*.{{0,20}}?(?:{_SAMPLING})")
_OF_DATA = re.compile(r"(?i)\b(?:data|log|logging|recording|record)[ _-]*(?:rate|frequency|freq)\b")
_BARE = re.compile(r"(?i)\W*(?:rate|frequency|freq)\b[\s:=,(\[]*(?:k?hz)?[\s:=,)\]]*(?=\d|$)")
_OTHER_RATE = re.compile(
    r"(?i)filter|cut[ _-]?off|corner|pass\b|display|update|refresh|baud|bit|heart|frame|video|camera|screen|nyquist"
    r"|divi[ds]|limit|range|max|interval|period|ratio|error"
)
_VALUE = re.compile(
    r"(?i)(?<![\d.+-])(?<!\d,)(?P<value>\d+(?:[.,]\d+)?(?:e[+-]?\d+)?)(?![\d:]|[.-]\d)[ \t]*(?P<unit>k?hz)?"
)
_CLAUSE = re.compile(r"[;|\t]|,(?!\d)")
_START = re.compile(
    r"(?i)\b(?:date|datum|fecha|start\w*|began|recorded|recording)\b[^0-9]{0,30}"
    r"(?P<when>\d{1,4}([-./])\d{1,2}\2\d{1,4}[T ,]+\d\d?:\d\d(?::\d\d(?:\.\d+)?)?(?:\s*[ap]m\b)?)"
    r"(?P<zone>Z|[+-]\d\d:?\d\d)?"
)


@dataclass(frozen=True, slots=True)
class Preamble:
    """Facts in the lines above the table; None where there is none.

    `start` is ISO-8601, `start_text` the same as written. `rate_line` is the line that states the rate,
    `other_rate_line` one that states another sampling rate.
    """

    rate_hz: float | None = None
    start: str | None = None
    rate_line: str | None = None
    other_rate_line: str | None = None
    start_text: str | None = None


def read_preamble(lines: Sequence[str], date_format: str | None = None) -> Preamble:
    """Search the lines for a sampling rate and for a date and time, read in `date_format` where the year is not first.

    A date with dots is day.month.year; one with slashes whose order is neither declared nor evident is not read. A rate
    is one that names sampling, acquisition or logging, or a bare `rate` or `frequency` in hertz; that of a filter, a
    display or a serial line is none.
    """
    found = [(rate, line.strip()) for line in lines if (rate := _rate(line)) is not None]
    written = next((match for match in map(_START.search, lines) if match), None)
    start = None if written is None else _start(written["when"], date_format, written["zone"] or "")
    start_text = None if start is None or written is None else written[0][written.start("when") - written.start() :]
    if not found:
        return Preamble(None, start, start_text=start_text)
    rate, rate_line = found[0]
    other = next((line for further, line in found if abs(further / rate - 1) > 0.005), None)
    return Preamble(rate, start, rate_line, other, start_text)


def _start(text: str, date_format: str | None, zone: str) -> str | None:
    """Return a date and time as ISO-8601; None where the order of the date is not clear, or it is none."""
    stamp = parse_stamp(text)
    if stamp is None or stamp.date is None:
        return None
    order = "y-m-d" if len(stamp.date[0]) == 4 else date_order([stamp], date_format)
    if not isinstance(order, str) or day_of(stamp, order) is None:
        return None
    return iso_text(text, order) + zone


def _is_grouped(value: str) -> bool:
    """Whether `1,000` or `1.000` may be a thousand: a rate of 1 Hz is as unlikely."""
    return may_group(value.encode()) and ("," in value or float(value) < 20)


def _rate(line: str) -> float | None:
    clauses = _CLAUSE.split(line)
    for number, clause in enumerate(clauses):
        if _OTHER_RATE.search(clause):
            continue
        sampling = _OF_SAMPLING.search(clause) is not None
        if not (sampling or _OF_DATA.search(clause) or _BARE.match(clause)):
            continue
        # `Rate;1000` and `Rate<TAB>1000` put the value into the next cell.
        next_cell = next((cell.strip() for cell in clauses[number + 1 :] if cell.strip()), "")
        values = [*_VALUE.finditer(clause), *_VALUE.finditer(next_cell)]
        match = next((value for value in values if value["unit"]), values[0] if values else None)
        if match is None or _is_grouped(match["value"]):
            continue
        named = re.search(r"(?i)(k?)hz", clause)
        if not (sampling or match["unit"] or named):
            continue
        kilo = (match["unit"] or (named[0] if named else "")).lower() == "khz"
        value = float(match["value"].replace(",", ".")) * (1000.0 if kilo else 1.0)
        if value > 0:
            return value
    return None


Column = FloatArray | IntArray
"""float64, or int64 for time stamps beyond 2^53."""


class CellKind(StrEnum):
    """What the cells of a column hold, judged on a sample from head, middle and end."""

    NUMBER = "number"
    INTEGER = "integer"  # beyond 2^53, where float64 would round
    CLOCK = "clock"
    TEXT = "text"
    EMPTY = "empty"


@dataclass(frozen=True, slots=True)
class Wanted:
    """A column to read: its position in the row, its name for findings, what its cells hold.

    `infinite_is_missing` for quotients, such as a centre of pressure: without a load they are infinite.
    """

    position: int
    name: str
    kind: CellKind
    infinite_is_missing: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Rows that could be read. `lines` and `ordinals`, shape (n_rows,), hold the line and the number of the data row
    (rejected ones counted, from 0) of each.

    `numbers` and `clocks` hold the columns by position, shape (n_rows,); `clocks`, and words, as the text of the cells.
    """

    numbers: Mapping[int, Column]
    clocks: Mapping[int, Sequence[bytes]]
    lines: IntArray
    ordinals: IntArray
    rows_rejected: int

    @property
    def n_rows(self) -> int:
        """Rows accepted."""
        return len(self.lines)

    @property
    def rows_read(self) -> int:
        """Rows accepted and rejected."""
        return self.n_rows + self.rows_rejected


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """One table of a file. `names`, `units` (None where the header has none) and `kinds` have an entry per column.

    `channels`, where a format fixes what its columns hold, has an entry per column too: the channel, `time`, or None
    where the name decides. `text` is the layout of a table in text.

    `read_rows` returns the wanted columns of all rows that can be read; it is called once, when it is known which
    columns are wanted, and reports what it leaves out.
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    kinds: tuple[CellKind, ...]
    preamble: Preamble
    read_rows: Callable[[Sequence[Wanted]], Block]
    channels: tuple[str | None, ...] = ()
    text: TextShape | None = None


@dataclass(slots=True)
class LineRows:
    """Rows of numbers that are read line by line: the lines they stand in, and which of the file's rows they are."""

    rows: list[list[float]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    ordinals: list[int] = field(default_factory=list)

    def add(self, row: list[float], line: int, rejected: int) -> None:
        """Add a row before which so many of the file were left out."""
        self.rows.append(row)
        self.lines.append(line)
        self.ordinals.append(len(self.rows) + rejected)

    def column(self, position: int) -> FloatArray:
        """Return one number of all rows, shape (n,)."""
        return np.array([row[position] for row in self.rows], dtype=np.float64)


def array_table(
    names: Sequence[str],
    units: Sequence[str | None],
    columns: Sequence[Column],
    preamble: Preamble = Preamble(),
    lines: Sequence[int] | IntArray | None = None,
    ordinals: Sequence[int] | IntArray | None = None,
    rows_rejected: int = 0,
) -> Table:
    """Return the table of a format that holds arrays: `columns` have shape (n_rows,) each, float64 or int64.

    `lines`, shape (n_rows,), are the lines that the rows stand in and `ordinals` the data rows that they are, those
    left out counted; without them row follows row. `rows_rejected` were left out while the arrays were made.
    """
    kinds = tuple(CellKind.INTEGER if column.dtype.kind == "i" else CellKind.NUMBER for column in columns)
    n_rows = len(columns[0]) if columns else 0

    def read_rows(wanted: Sequence[Wanted]) -> Block:
        numbers = {column.position: columns[column.position] for column in wanted}
        own_lines = np.asarray(np.arange(1, n_rows + 1) if lines is None else lines, dtype=np.int64)
        own_ordinals = np.asarray(np.arange(n_rows) if ordinals is None else ordinals, dtype=np.int64)
        return Block(numbers, {}, own_lines, own_ordinals, rows_rejected)

    return Table(tuple(names), tuple(units), kinds, preamble, read_rows)
