"""How a table fits on a page of LaTeX: type size, columns whose words break their lines, heads of two lines."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from reports.tables.table import Column, Table

PAGE_LINES = 48
"""Lines that a page holds beside the caption; a table with more breaks over pages."""

_SIZES = ((r"\footnotesize", 87), (r"\scriptsize", 95))
"""Type sizes, and about how many letters of each stand on a line of LaTeX's `article` (345 pt)."""

_GAP_LETTERS = 1.4
_PROSE_LETTERS = 14
_SHORT_LETTERS = 8


@dataclass(frozen=True, slots=True)
class Layout:
    """A table's type size, each column's head as lines, and the share of the line of columns of broken lines.

    `lines` is about how many lines the rows take, with the names of the blocks and the space between them.
    """

    size: str
    heads: Mapping[Column, tuple[str, ...]]
    shares: Mapping[Column, float]
    lines: int


def layout_of(table: Table, columns: Sequence[Column]) -> Layout:
    """Lay out a table: smaller type, then heads of two lines, then words that break beside the numbers.

    Columns that break share the room by how much stands in them.
    """
    texts = {column: [row.cells[table.columns.index(column)].text for row in table.rows] for column in columns}
    gaps = _GAP_LETTERS * (len(columns) - 1)
    for heads in (
        {column: (column.head,) for column in columns},
        {column: _two_lines(column.head) for column in columns},
    ):
        wide = {column: max(map(len, [*heads[column], *texts[column]])) for column in columns}
        least = sum(min(wide[column], _PROSE_LETTERS) if column.prose else wide[column] for column in columns) + gaps
        size, line = next(((name, letters) for name, letters in _SIZES if least <= letters), _SIZES[-1])
        if least <= line:
            break
    breaking = [column for column in columns if column.prose]
    if least > line:
        breaking += [column for column in columns[:1] if not column.numeric and not column.prose]
    room = line - gaps - sum(wide[column] for column in columns if column not in breaking)
    widths = {} if sum(wide[column] for column in breaking) <= room else _widths(breaking, wide, texts, room)
    shares = {column: width / line for column, width in widths.items()}
    return Layout(size, heads, shares, _lines(table, texts, widths))


def _two_lines(head: str) -> tuple[str, ...]:
    """Break a head where its lines are most alike."""
    places = [place for place, letter in enumerate(head) if letter == " "]
    at = min(places, key=lambda place: max(place, len(head) - place), default=None)
    return (head,) if at is None else (head[:at], head[at + 1 :])


def _widths(
    breaking: Sequence[Column], wide: Mapping[Column, int], texts: Mapping[Column, Sequence[str]], room: float
) -> dict[Column, float]:
    floors = {
        column: max(
            [min(wide[column], _SHORT_LETTERS), *(len(word) for text in texts[column] for word in text.split())]
        )
        for column in breaking
    }
    spare = max(0.0, room - sum(floors.values()))
    rest = sum(wide[column] - floors[column] for column in breaking) or 1
    return {
        column: floors[column] + spare * (wide[column] - floors[column]) / rest
        for column in breaking
        if wide[column] > floors[column]
    }


def _lines(table: Table, texts: Mapping[Column, Sequence[str]], widths: Mapping[Column, float]) -> int:
    rows = [
        max([1, *(math.ceil(len(texts[column][index]) / width) for column, width in widths.items())])
        for index in range(len(table.rows))
    ]
    blocks = [block for block, _ in table.blocks]
    return sum(rows) + sum(bool(block) for block in blocks) + len(blocks) // 2
