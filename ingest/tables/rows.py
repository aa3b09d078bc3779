"""Reads the data rows of a table: whole numeric blocks at once where these can be proved clean, else line by line.

The fast route hands the bytes, uncopied, to pyarrow's CSV parser. A block counts as clean when every cell is a finite
number or a missing value and there are as many rows as lines; both routes then give identical values, both
converting decimals with correct rounding. A block that is not clean is cut into pieces, so that one bad line costs
one piece. The rows of a large file are read in blocks, and their columns lie in temporary files.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ingest.findings import FindingCollector
from ingest.spool.mapped_bytes import let_go, mapped
from ingest.tables.joining import joiner
from ingest.tables.layout import Layout
from ingest.tables.row_reader import read_lines
from ingest.tables.table import Block, CellKind, Column, Wanted
from ingest.tables.tail import data_end
from ingest.text.source import TextSource

if TYPE_CHECKING:
    import pyarrow as pa

PIECE_BYTES = 1 << 18
BLOCK_BYTES = 1 << 24
"""What is tried at once of a large file."""

_WAIT_S, _LONGEST_WAIT_S = 1e-4, 1.0


def read_rows(source: TextSource, layout: Layout, wanted: Sequence[Wanted], findings: FindingCollector) -> Block:
    """Return the wanted columns of all rows that can be read; what cannot be is reported and left out."""
    end = data_end(source, layout, findings)
    large = mapped(source.data)
    rows = joiner(None if large is None else large.folder)
    tried_bytes = end.stop - layout.data_start if large is None else BLOCK_BYTES
    start, line, ordinal = layout.data_start, layout.data_line, 0
    while start < end.stop or not rows.filled:
        stop = _block_end(source, start, tried_bytes, end.stop)
        block = _read_clean(source, layout, wanted, start, stop, line, ordinal)
        if block is not None:
            let_go(source.data, start, stop)
            rows.add(block)
            start, line, ordinal = stop, line + block.n_rows, ordinal + block.rows_read
            continue
        while start < stop or not rows.filled:
            piece_start, piece_end = start, _block_end(source, start, PIECE_BYTES, end.stop)
            block = _read_clean(source, layout, wanted, start, piece_end, line, ordinal)
            if block is not None:
                start, line = piece_end, line + block.n_rows
            else:
                span = (start, piece_end, end.stop)
                block, start, line = read_lines(source, layout, wanted, span, line, ordinal, findings)
            let_go(source.data, piece_start, start)
            ordinal += block.rows_read
            rows.add(block)
    block = rows.joined()
    return dataclasses.replace(block, rows_rejected=block.rows_rejected + end.rows_rejected)


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
    from ingest.tables.arrow_columns import to_numpy

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
        if cells.null_count and column.kind is not CellKind.NUMBER:
            return None
        if column.kind is CellKind.CLOCK:
            clocks[column.position] = cells.to_pylist()
            continue
        values = to_numpy(cells)
        if column.kind is CellKind.NUMBER and _has_infinity(values):
            return None
        numbers[column.position] = values
    return Block(numbers, clocks, rows, line, None, ordinal, None, 0)


def _parsed(lines: memoryview, layout: Layout, wanted: Sequence[Wanted]) -> pa.Table | None:
    import pyarrow as pa
    from pyarrow import csv

    types = {CellKind.NUMBER: pa.float64(), CellKind.INTEGER: pa.int64(), CellKind.CLOCK: pa.binary()}
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
