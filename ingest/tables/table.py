"""Tables: what a header says of the columns, and the rows as columns of numbers with the line each came from.

Every format ends here: text through `tables.text_table`, binary formats through `array_table`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ingest.explanation import TextShape
from ingest.model import FloatArray, IntArray
from ingest.tables.preamble import NO_PREAMBLE, Preamble

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
    """Rows that could be read. `lines` and `ordinals` say which line and which data row (rejected ones counted, from 0)
    each is; both are None where row follows row and line follows line from `first_line` and `first_ordinal`.

    `numbers` and `clocks` hold the columns by position, shape (n_rows,); `clocks` as the text of the cells.
    """

    numbers: Mapping[int, Column]
    clocks: Mapping[int, Sequence[bytes]]
    n_rows: int
    first_line: int
    lines: IntArray | None
    first_ordinal: int
    ordinals: IntArray | None
    rows_rejected: int

    @property
    def rows_read(self) -> int:
        """Rows kept and rejected."""
        return self.n_rows + self.rows_rejected

    def line_of(self, rows: IntArray) -> list[int]:
        """Return the 1-based lines of the first rows given, as many as a finding shows."""
        shown = rows[:21]
        found = self.first_line + shown if self.lines is None else self.lines[shown]
        return [int(line) for line in found]

    def ordinal(self) -> IntArray:
        """Return the number of each row among all data rows, shape (n_rows,)."""
        if self.ordinals is None:
            return np.arange(self.first_ordinal, self.first_ordinal + self.n_rows, dtype=np.int64)
        return self.ordinals


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """One table of a file. `names`, `units` (None where the header has none) and `kinds` have an entry per column.

    `channels`, where a format fixes what its columns hold, has an entry per column too: the channel, `time`, or None
    where the name decides. `text` says how a table in text is laid out.

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


def array_table(
    names: Sequence[str],
    units: Sequence[str | None],
    columns: Sequence[Column],
    preamble: Preamble = NO_PREAMBLE,
    lines: IntArray | None = None,
    ordinals: IntArray | None = None,
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
        return Block(numbers, {}, n_rows, 1, lines, 0, ordinals, rows_rejected)

    return Table(tuple(names), tuple(units), kinds, preamble, read_rows)
