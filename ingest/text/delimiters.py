"""Which byte separates the cells of a table, and how many cells its rows have.

Judged on rows of numbers only, so titles and header lines with other separators do not disturb it: every candidate
splits the sample, the one that gives most rows of one width and of nothing but numbers wins (formats: count
candidates per line over the numeric block only, most constant count wins).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from ingest.text.cells import is_clock, is_grouped, is_missing, is_number, split_cells
from ingest.text.debug_lines import debug_line, is_single_number
from ingest.text.source import Line

# A single space stands for any run of blanks; last, because blanks also pad other separators.
CANDIDATES = (b"\t", b";", b",", b"|", b" ")
ONE_COLUMN = b"\x1f"
"""Stands for no delimiter: a character that no line holds."""

_ROWS_JUDGED = 60


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

    `head` are the first lines of the file, `further` lines from deeper inside; `delimiter` is the one declared.
    """
    if delimiter is not None:
        declared = _split(head, further, delimiter)
        return declared if declared.rows else None
    filled = [line for line in [*head, *further] if line.content.strip() and not _is_debug(line)]
    frequent = [sign for sign in CANDIDATES if sum(sign in line.content for line in filled) * 2 >= len(filled)]
    tried = [_split(head, further, delimiter) for delimiter in (*frequent, ONE_COLUMN)]
    possible = [split for split in tried if split.rows]
    if not possible:
        return None
    best = max(split.quality for split in possible)
    close = [split for split in possible if split.quality >= 0.98 * best]
    return max(close, key=lambda split: (_has_header(split), split.width > 1))


def row_of(line: Line, delimiter: bytes) -> Row:
    """Split one line and judge whether it holds data."""
    cells = split_cells(line.content, delimiter) or []
    numbers = sum(is_number(cell, comma=True) or is_clock(cell) or is_grouped(cell) for cell in cells)
    empty = sum(is_missing(cell.lower()) for cell in cells)
    share = (numbers + empty) / len(cells) if cells else 0.0
    return Row(line, cells, numbers > 0 and share >= 0.5 and not _is_debug(line), share)


def _is_debug(line: Line) -> bool:
    return is_single_number(debug_line(line.content))


def _split(head: list[Line], further: list[Line], delimiter: bytes) -> Split:
    rows = []
    data_rows = []
    for line in head:
        row = row_of(line, delimiter)
        rows.append(row)
        if row.data_like:
            data_rows.append(row)
            if len(data_rows) == _ROWS_JUDGED:
                break
    data_rows += [row_of(line, delimiter) for line in further]
    data_rows = [row for row in data_rows if row.data_like]
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
