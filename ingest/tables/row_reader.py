"""Reads data rows line by line, so that every line can be reported with what is wrong in it.

One row is rejected once, but all that is wrong in it is reported.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ingest.findings import NOTE, ROW, FindingCollector
from ingest.tables.header_lines import with_units_joined
from ingest.tables.layout import Layout, is_header, second_header
from ingest.tables.table import Block, CellKind, Column, Wanted
from ingest.text.cells import (
    COMMENT_STARTS,
    INFINITY,
    NAN,
    NOT_A_NUMBER,
    NOT_FINITE,
    CellFault,
    integer_of,
    is_missing,
    is_number,
    parse_cell,
    split_cells,
)
from ingest.text.source import TextSource, logical_line, physical_line

_NO_NUMBER = re.compile(rb"[_\s]")
"""What `float` passes over, and a damaged byte may be."""


class _Reader:
    """State of reading one piece: where it is, and the rows accepted so far."""

    def __init__(
        self, source: TextSource, layout: Layout, wanted: Sequence[Wanted], findings: FindingCollector
    ) -> None:
        self.source, self.layout, self.wanted, self.findings = source, layout, wanted, findings
        self.numeric = [column for column in wanted if column.kind is CellKind.NUMBER]
        self.others = [column for column in wanted if column.kind is not CellKind.NUMBER]
        self.values: list[list[float]] = []
        self.exact: dict[int, list[int]] = {c.position: [] for c in self.others if c.kind is CellKind.INTEGER}
        self.clocks: dict[int, list[bytes]] = {c.position: [] for c in self.others if c.kind is not CellKind.INTEGER}
        self.lines: list[int] = []
        self.ordinals: list[int] = []
        self.rejected = 0
        self.position = 0

    def reject(self, rule: str, message: str, line: int, value: bytes) -> None:
        """Count a row that is left out as a whole."""
        self.findings.add(ROW, rule, message, lines=[line], value=self.source.decode(value[:80]))
        self.rejected += 1

    def take(self, cells: list[bytes], line: int, ordinal: int) -> None:
        """Keep a row of the right width, or report every cell that is wrong in it."""
        numbers = self._numbers(cells, line)
        exact: list[int] = []
        bad = numbers is None
        for column in self.others:
            if column.kind is not CellKind.INTEGER:
                continue
            cell = cells[column.position]
            number = integer_of(cell)
            if number is not None:
                exact.append(number)
            else:
                self._bad_cell(column, NOT_A_NUMBER.rule, NOT_A_NUMBER.message, line, cell)
                bad = True
        if bad or numbers is None:
            self.rejected += 1
            return
        self.values.append(numbers)
        for store, number in zip(self.exact.values(), exact, strict=True):
            store.append(number)
        for position, clock in self.clocks.items():
            clock.append(cells[position])
        self.lines.append(line)
        self.ordinals.append(ordinal)

    def _numbers(self, cells: list[bytes], line: int) -> list[float] | None:
        own = [cells[column.position] for column in self.numeric]
        decimal = self.layout.decimal
        try:
            # `float` reads all that counts as a number, and underscores, blanks and infinities beside it.
            quick = [float(cell) for cell in own]
            joined = b"".join(own)
            plain = decimal == b"." or b"." not in joined
            if plain and not _NO_NUMBER.search(joined) and INFINITY not in quick and -INFINITY not in quick:
                return quick
        except ValueError:
            pass
        numbers: list[float] = []
        for column, cell in zip(self.numeric, own, strict=True):
            parsed = parse_cell(cell, decimal)
            if parsed is NOT_FINITE and column.infinite_is_missing:
                numbers.append(NAN)
            elif isinstance(parsed, CellFault):
                self._bad_cell(column, parsed.rule, parsed.message, line, cell)
            else:
                numbers.append(parsed)
        return numbers if len(numbers) == len(own) else None

    def _bad_cell(self, column: Wanted, rule: str, message: str, line: int, cell: bytes) -> None:
        self.findings.add(ROW, rule, message, column=column.name, lines=[line], value=self.source.decode(cell[:80]))

    def block(self) -> Block:
        """Return the rows accepted."""
        matrix = np.array(self.values, dtype=np.float64).reshape(len(self.lines), len(self.numeric))
        numbers: dict[int, Column] = {
            column.position: np.ascontiguousarray(matrix[:, index]) for index, column in enumerate(self.numeric)
        }
        numbers |= {position: np.array(exact, dtype=np.int64) for position, exact in self.exact.items()}
        lines, ordinals = (np.array(each, dtype=np.int64) for each in (self.lines, self.ordinals))
        return Block(numbers, self.clocks, lines, ordinals, self.rejected)


def read_lines(
    source: TextSource,
    layout: Layout,
    wanted: Sequence[Wanted],
    span: tuple[int, int, int],
    line: int,
    ordinal: int,
    findings: FindingCollector,
) -> tuple[Block, int, int]:
    """Read the lines that start in `span[0]:span[1]`; a quoted cell may run on, at most to `span[2]`.

    `line` and `ordinal` number the first line and the first row. Returns the rows, and offset and number of the next
    line. Raises `SecondHeader` where another table begins.
    """
    reader = _Reader(source, layout, wanted, findings)
    position, piece_end, stop = span
    while position < piece_end:
        logical = logical_line(source.data, position, stop)
        if logical.spanned > 1 and not _is_whole_row(logical.content, layout):
            # Two rows with a forgotten quote each are no row with a quoted line end.
            logical = physical_line(source.data, position, stop)
        reader.position = position
        ordinal += _read_line(reader, logical.content, line, ordinal)
        position = logical.end
        line += logical.spanned
    return reader.block(), position, line


def _is_whole_row(content: bytes, layout: Layout) -> bool:
    cells = split_cells(content, layout.delimiter)
    return cells is not None and layout.width <= len(cells) <= layout.width + max(1, layout.trailing)


def _read_line(reader: _Reader, content: bytes, line: int, ordinal: int) -> int:
    """Deal with one line; returns how many data rows it was (0 or 1)."""
    layout = reader.layout
    bare = content.strip()
    if not bare:
        return 0
    if not bare.strip(b"\x1a"):
        reader.findings.add(NOTE, "ctrl_z", "A Ctrl-Z (old end-of-file mark) is skipped.", lines=[line])
        return 0
    if b"\0" in content:
        message = "NUL bytes stand in the line, as lost sectors of a memory card leave; the row is left out."
        reader.reject("nul_bytes", message, line, content.replace(b"\0", b""))
        return 1
    longest = reader.source.longest_line_bytes
    if len(content) > longest:
        message = f"A line is longer than {longest} bytes (limit longest_line_bytes); it is left out."
        reader.reject("line_too_long", message, line, content)
        return 1
    cells = split_cells(content, layout.delimiter)
    if cells is None:
        reader.reject("quote_unbalanced", "A quote is not closed; the row is left out.", line, content)
        return 1
    if layout.delimiter == b" ":
        cells = with_units_joined(cells, layout.width)
    whole = len(cells) == layout.width
    beyond = cells[layout.width :]
    if beyond and len(beyond) <= max(1, layout.trailing) and not any(beyond):
        del cells[layout.width :]
        whole = True
    elif layout.trailing and whole and not cells[-1]:
        whole = False  # a last delimiter alone: the cell before it, or what ends every row, is not there
    comment = _is_comment(content, cells, layout)
    if comment and not is_header(reader.source, content, cells, layout):
        reader.findings.add(NOTE, "comment_line", "Comment lines are skipped.", lines=[line])
    elif layout.header_cells and _same(cells, layout.header_cells):
        message = "The header stands again inside the data: pages, or another recording appended; it is skipped."
        reader.findings.add(NOTE, "header_repeated", message, lines=[line])
    elif layout.units_cells and _same(cells, layout.units_cells):
        reader.findings.add(NOTE, "units_repeated", "The row of units stands again; it is skipped.", lines=[line])
    elif layout.is_debug(content):
        message = "Lines `name: value` stand among the rows: they are skipped and stay in the raw copy only."
        reader.findings.add(NOTE, "debug_line", message, lines=[line], value=reader.source.decode(content[:60]))
    elif is_header(reader.source, content, cells, layout):
        raise second_header(reader.source, layout, reader.position, line)
    elif not whole:
        message = f"A row has more or fewer than {layout.width} cells; it is left out."
        reader.reject("ragged_row", message, line, content)
        return 1
    else:
        reader.take(cells, line, ordinal)
        return 1
    return 0


def _same(cells: list[bytes], known: tuple[bytes, ...]) -> bool:
    end = len(known) - (not known[-1])
    return tuple(cells[:end]) == known[:end] and len(cells) in (end, len(known))


def _is_comment(content: bytes, cells: list[bytes], layout: Layout) -> bool:
    """A comment starts with its sign and does not otherwise look like a row (`#N/A,1,2` is a row)."""
    if not content.lstrip().startswith(COMMENT_STARTS):
        return False
    numbers = sum(is_number(cell, comma=True) or is_missing(cell.lower()) for cell in cells)
    return len(cells) != layout.width or numbers * 2 < len(cells)
