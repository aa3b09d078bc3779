"""The table in a delimited text: whole numeric blocks at once where these can be proved clean, else line by line.

The fast route hands the bytes, uncopied, to pyarrow's CSV parser. A block counts as clean when every cell is a finite
number or a missing value and there are as many rows as lines; both routes then give identical values, both
converting decimals with correct rounding. A block that is not clean is cut into pieces, so that one bad line costs
one piece. The rows of a large file are read in blocks, and their columns lie in temporary files. Where the data end,
padding is stripped, and a last line that was cut while being written is left out.
"""

from __future__ import annotations

import dataclasses
import functools
import re
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ingest.model import NOTE, ROW, Declarations, FindingCollector
from ingest.spool import ColumnFile, mapped, release_bytes
from ingest.tables.layout import Layout
from ingest.tables.table import Block, CellKind, Column, Table, Wanted, read_preamble
from ingest.text import TextSource, split_cells

if TYPE_CHECKING:
    import pyarrow as pa


from ingest.tables.layout import check_above, find_layout, is_header, second_header, with_units_joined
from ingest.text import (
    COMMENT_STARTS,
    INFINITY,
    NAN,
    NOT_A_NUMBER,
    NOT_FINITE,
    CellFault,
    integer_of,
    is_missing,
    is_number,
    logical_line,
    parse_cell,
    physical_line,
    refuse_long_line,
)

PIECE_BYTES = 1 << 18
BLOCK_BYTES = 1 << 24
"""What is tried at once of a large file."""

_WAIT_S, _LONGEST_WAIT_S = 1e-4, 1.0


def text_table(source: TextSource, declared: Declarations, findings: FindingCollector) -> Table | None:
    """Find the table in a text, its rows not read yet; None, with a finding of severity file, where there is none.

    Raises `SecondHeader` where another table stands above it, as its rows do where one follows.
    """
    if source.first_line > 1:  # the lines declared are those of the first table in the text
        declared = dataclasses.replace(declared, header_row=None, units_row=None, first_row=None)
    if refuse_long_line(source, findings):
        return None
    layout = find_layout(source, declared, findings)
    if layout is None:
        return None
    check_above(source, layout)
    preamble = read_preamble((*source.comments, *layout.preamble), declared.date_format)
    rows = functools.partial(read_rows, source, layout, findings)
    return Table(layout.names, layout.units, layout.kinds, preamble, rows, text=layout.shape)


def read_rows(source: TextSource, layout: Layout, findings: FindingCollector, wanted: Sequence[Wanted]) -> Block:
    """Return the wanted columns of all rows that can be read; what cannot be is reported and left out."""
    end, cut = _data_end(source, layout, findings)
    large = mapped(source.data)
    rows = _Rows(None if large is None else large.folder)
    tried_bytes = end - layout.data_start if large is None else BLOCK_BYTES
    start, line, ordinal = layout.data_start, layout.data_line, 0
    while start < end or not rows.columns:
        stop = _block_end(source, start, tried_bytes, end)
        block = _read_clean(source, layout, wanted, start, stop, line, ordinal)
        if block is not None:
            release_bytes(source.data, start, stop)
            rows.add(block)
            start, line, ordinal = stop, line + block.n_rows, ordinal + block.rows_read
            continue
        while start < stop or not rows.columns:
            piece_start, piece_end = start, _block_end(source, start, PIECE_BYTES, end)
            block = _read_clean(source, layout, wanted, start, piece_end, line, ordinal)
            if block is not None:
                start, line = piece_end, line + block.n_rows
            else:
                span = (start, piece_end, end)
                block, start, line = read_lines(source, layout, wanted, span, line, ordinal, findings)
            release_bytes(source.data, piece_start, start)
            ordinal += block.rows_read
            rows.add(block)
    block = rows.joined()
    return dataclasses.replace(block, rows_rejected=block.rows_rejected + cut)


def _block_end(source: TextSource, start: int, n_bytes: int, stop: int) -> int:
    """Return the end of the line in which a block of `n_bytes` from `start` ends."""
    return source.data.find(b"\n", min(start + n_bytes, stop), stop) + 1 or stop


def _read_clean(
    source: TextSource,
    layout: Layout,
    wanted: Sequence[Wanted],
    start: int,
    stop: int,
    line: int,
    ordinal: int,
) -> Block | None:
    """Return the rows of `data[start:stop]`, whole lines, or None where they are not proved clean."""
    from ingest.spool import to_numpy

    if start >= stop or not wanted:
        return None
    lent = memoryview(source.data)[start:stop]
    table = _parsed(lent, layout, wanted)
    _take_back(lent)
    if table is None:
        return None
    rows = table.num_rows
    if rows != _count_line_ends(source.data, start, stop) + (source.data[stop - 1] != 0x0A):
        return None
    numbers: dict[int, Column] = {}
    clocks: dict[int, Sequence[bytes]] = {}
    for index, column in enumerate(wanted):
        cells = table.column(index)
        if column.kind is CellKind.TEXT:
            known: dict[bytes, bytes] = {}  # words repeat: one object each
            clocks[column.position] = [known.setdefault(cell or b"", cell or b"") for cell in cells.to_pylist()]
            continue
        if cells.null_count and column.kind is not CellKind.NUMBER:
            return None
        if column.kind is CellKind.CLOCK:
            clocks[column.position] = cells.to_pylist()
            continue
        values = to_numpy(cells)
        if column.kind is CellKind.NUMBER and _has_infinity(values):
            return None
        numbers[column.position] = values
    counted = np.arange(rows, dtype=np.int64)
    return Block(numbers, clocks, line + counted, ordinal + counted, 0)


def _parsed(lines: memoryview, layout: Layout, wanted: Sequence[Wanted]) -> pa.Table | None:
    import pyarrow as pa
    from pyarrow import csv

    texts = dict.fromkeys((CellKind.CLOCK, CellKind.TEXT), pa.binary())
    types = {CellKind.NUMBER: pa.float64(), CellKind.INTEGER: pa.int64(), **texts}
    width = layout.width + layout.trailing
    blank = [str(position) for position in range(layout.width, width)]
    try:
        return csv.read_csv(
            pa.BufferReader(pa.py_buffer(lines)),
            read_options=csv.ReadOptions(column_names=[str(position) for position in range(width)]),
            parse_options=csv.ParseOptions(delimiter=layout.delimiter.decode("latin-1"), quote_char=False),
            convert_options=csv.ConvertOptions(
                column_types={
                    **{str(column.position): types[column.kind] for column in wanted},
                    **dict.fromkeys(blank, pa.null()),  # what stands there makes the row another one
                },
                include_columns=[*(str(column.position) for column in wanted), *blank],
                null_values=[""],
                decimal_point=layout.decimal.decode(),
            ),
        )
    except pa.ArrowException:
        return None


def _take_back(lent: memoryview) -> None:
    """Wait until no thread of Arrow holds the bytes; some still do when its parser has returned.

    To let go of Python's bytes a thread needs the interpreter, and one that first asks while the interpreter ends
    aborts the process. Bytes that are held for good are left to their holder.
    """
    end = time.monotonic() + _LONGEST_WAIT_S
    while time.monotonic() < end:
        try:
            lent.release()
        except BufferError:
            time.sleep(_WAIT_S)
        else:
            return


def _count_line_ends(data: bytes, start: int, stop: int) -> int:
    """Count as `bytes.count` does, in a quarter of its time where lines are short."""
    found = np.frombuffer(data, np.uint8, stop - start, start)
    return sum(int(np.count_nonzero(found[at : at + PIECE_BYTES] == 0x0A)) for at in range(0, len(found), PIECE_BYTES))


def _has_infinity(values: np.ndarray) -> bool:
    """A sum is finite where every value is; one that is not may be of missing or large values."""
    with np.errstate(all="ignore"):
        return not np.isfinite(values.sum()) and bool(np.isinf(values).any())


def _end_digits(cell: bytes) -> int:
    return len(cell) - len(cell.rstrip(b"0123456789"))


def _data_end(source: TextSource, layout: Layout, findings: FindingCollector) -> tuple[int, int]:
    """Return where the data end, and how many lines are left out behind that: a last line without line end is read
    only if it is as complete as those before it.
    """
    stop = _without_padding(source.data, layout.data_start, findings)
    if stop <= layout.data_start or source.data[stop - 1 : stop] in (b"\n", b"\r"):
        return stop, 0
    start = max(source.data.rfind(b"\n", layout.data_start, stop) + 1, layout.data_start)
    start = max(source.data.rfind(b"\r", start, stop) + 1, start)
    if layout.is_debug(source.data[start:stop]):
        return stop, 0
    why = _why_cut(source.data[start:stop], _cell_above(source.data, layout, start), layout)
    if why is None:
        findings.add(
            NOTE, "no_final_newline", "The last line has no line end; it is as complete as the others and kept."
        )
        return stop, 0
    findings.add(
        ROW,
        "last_line_cut",
        why,
        lines=[source.data.count(b"\n", layout.data_start, start) + layout.data_line],
        value=source.decode(source.data[start:stop][:80]),
    )
    return start, 1


def _without_padding(data: bytes, start: int, findings: FindingCollector) -> int:
    """Return the end without trailing Ctrl-Z and blank lines, keeping the line end of the last row."""
    stop = len(data)
    while stop > start and data[stop - 1] in b"\x1a\r\n":
        stop -= 1
    padding = data[stop:]
    if b"\x1a" in padding:
        findings.add(NOTE, "ctrl_z", "A Ctrl-Z (old end-of-file mark) is skipped.")
    for end in (b"\r\n", b"\n", b"\r"):
        if padding.startswith(end):
            return stop + len(end)
    return stop


def _cell_above(data: bytes, layout: Layout, start: int) -> bytes | None:
    """Return the last cell of the line before the one at `start`."""
    begin = max(data.rfind(b"\n", layout.data_start, start - 1) + 1, layout.data_start)
    cells = split_cells(data[begin:start].strip(b"\r\n"), layout.delimiter) if begin < start else None
    return cells[-1] if cells else None


_CUT = "The last line ends in the middle, as when power is cut while it is written; it is left out."
_MAY_GO_ON = (
    "The last line has no line end and its last number may go on; it is left out: say `--complete` if it is whole."
)


def _why_cut(line: bytes, cell_above: bytes | None, layout: Layout) -> str | None:
    """Say that cells are missing, or that the last one may miss digits: it, or what ends it, is shorter than some above
    it, or, in a table of a maker, decimals differ. None where the line is whole.

    A number that repeats the one above it is whole. One row less of a log is no loss, 79 for 799 is a wrong value.
    """
    cells, above = split_cells(line, layout.delimiter), layout.last_cells
    if cells is None or len(cells) < layout.width + layout.trailing:
        return _CUT
    if layout.trailing:
        return _CUT if len(cells) == layout.width else None  # every whole row ends in a delimiter
    if layout.complete:
        return None
    decimals = {len(cell.rpartition(layout.decimal)[2]) if layout.decimal in cell else 0 for cell in above}
    if layout.fixed and len(cells) == layout.width and any(above) and (len(decimals) > 1 or decimals == {0}):
        return _MAY_GO_ON
    if cells[-1] == cell_above:
        return None
    without_exponent = above and all(b"e" in one.lower() for one in above) and b"e" not in cells[-1].lower()
    shorter = (
        not above or len(cells[-1]) < max(map(len, above)) or _end_digits(cells[-1]) < max(map(_end_digits, above))
    )
    return _CUT if without_exponent or shorter else None


_LINES, _ORDINALS = -1, -2
"""Places of the numbers of lines and rows beside those of the columns."""


class _Rows:
    """Joins blocks in the order of the rows, in memory or, where `folder` is given, in temporary files of it."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._rejected = 0
        self._clocks: dict[int, list[bytes]] = {}
        self.columns: dict[int, ColumnFile[Any]] = {}

    def add(self, block: Block) -> None:
        """Add the block that follows."""
        for key, values in {**block.numbers, _LINES: block.lines, _ORDINALS: block.ordinals}.items():
            if key not in self.columns:
                self.columns[key] = ColumnFile(self._folder, values.dtype)
            self.columns[key].append(values)
        for key, cells in block.clocks.items():
            self._clocks.setdefault(key, []).extend(cells)
        self._rejected += block.rows_rejected

    def joined(self) -> Block:
        """Return all rows as one block."""
        whole = {key: column.finish() for key, column in self.columns.items()}
        return Block(whole, self._clocks, whole.pop(_LINES), whole.pop(_ORDINALS), self._rejected)


_NO_NUMBER = re.compile(rb"[_\s]")
"""What `float` passes over, and a damaged byte may be."""


class _Reader:
    """State of reading one piece: where it is, and the rows accepted so far, their numbers before other cells."""

    def __init__(
        self, source: TextSource, layout: Layout, wanted: Sequence[Wanted], findings: FindingCollector
    ) -> None:
        self.source, self.layout, self.findings = source, layout, findings
        self.numeric = [column for column in wanted if column.kind is CellKind.NUMBER]
        self.others = [column for column in wanted if column.kind is not CellKind.NUMBER]
        self.rows: list[list[float | bytes]] = []
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
        quick = self._quick([cells[column.position] for column in self.numeric])
        one_by_one = self.others if quick else (*self.numeric, *self.others)
        found = [self._value(column, cells[column.position], line) for column in one_by_one]
        row = [*quick, *(value for value in found if value is not None)]
        if len(row) < len(self.numeric) + len(self.others):
            self.rejected += 1
            return
        self.rows.append(row)
        self.lines.append(line)
        self.ordinals.append(ordinal)

    def _quick(self, cells: list[bytes]) -> list[float]:
        """Return the numbers in cells that hold nothing else, none where one may."""
        try:
            # `float` reads all that counts as a number, and underscores, blanks and infinities beside it.
            quick = [float(cell) for cell in cells]
        except ValueError:
            return []
        joined = b"".join(cells)
        plain = self.layout.decimal == b"." or b"." not in joined
        is_clear = plain and not _NO_NUMBER.search(joined) and INFINITY not in quick and -INFINITY not in quick
        return quick if is_clear else []

    def _value(self, column: Wanted, cell: bytes, line: int) -> float | bytes | None:
        """Return what a cell holds, None, reported, where it is not of the column's kind."""
        parsed: float | CellFault | None
        if column.kind is CellKind.NUMBER:
            parsed = parse_cell(cell, self.layout.decimal)
        elif column.kind is CellKind.INTEGER:
            parsed = integer_of(cell)
        else:
            return cell
        if parsed is NOT_FINITE and column.infinite_is_missing:
            return NAN
        fault = NOT_A_NUMBER if parsed is None else parsed
        if isinstance(fault, CellFault):
            value = self.source.decode(cell[:80])
            self.findings.add(ROW, fault.rule, fault.message, column=column.name, lines=[line], value=value)
            return None
        return fault

    def block(self) -> Block:
        """Return the rows accepted."""
        wanted = (*self.numeric, *self.others)
        columns = dict(zip(wanted, zip(*self.rows, strict=True) if self.rows else ((),) * len(wanted), strict=True))
        types: dict[CellKind, Any] = {CellKind.NUMBER: np.float64, CellKind.INTEGER: np.int64}
        numbers: dict[int, Column] = {
            column.position: np.array(cells, dtype=types[column.kind])
            for column, cells in columns.items()
            if column.kind in types
        }
        clocks = {column.position: list(cells) for column, cells in columns.items() if column.kind not in types}
        lines, ordinals = (np.array(each, dtype=np.int64) for each in (self.lines, self.ordinals))
        return Block(numbers, clocks, lines, ordinals, self.rejected)


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
        logical = logical_line(source.data, position, stop, layout.delimiter)
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
