"""Where the data of a text end: padding stripped, and a last line that was cut while being written left out."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ingest.findings import NOTE, ROW, FindingCollector
from ingest.tables.layout import Layout
from ingest.text.cells import split_cells
from ingest.text.source import TextSource

_SHAPE = re.compile(rb"[+-]?(\d*)(?:[.,](\d*))?(?:[eE][+-]?(\d+))?")


@dataclass(frozen=True, slots=True)
class DataEnd:
    """`data[:stop]` holds the whole rows; `rows_rejected` is 1 when a cut last line follows."""

    stop: int
    rows_rejected: int


def data_end(source: TextSource, layout: Layout, findings: FindingCollector) -> DataEnd:
    """Find the end of the data; a last line without line end is kept only if it is as complete as those before it."""
    stop = _without_padding(source.data, layout.data_start, findings)
    if stop <= layout.data_start or source.data[stop - 1 : stop] in (b"\n", b"\r"):
        return DataEnd(stop, 0)
    start = max(source.data.rfind(b"\n", layout.data_start, stop) + 1, layout.data_start)
    start = max(source.data.rfind(b"\r", start, stop) + 1, start)
    if layout.is_debug(source.data[start:stop]):
        return DataEnd(stop, 0)
    if not _is_cut(source.data[start:stop], _cell_above(source.data, layout, start), layout):
        findings.add(
            NOTE, "no_final_newline", "The last line has no line end; it is as complete as the others and kept."
        )
        return DataEnd(stop, 0)
    findings.add(
        ROW,
        "last_line_cut",
        "The last line ends in the middle, as when power is cut while it is written; it is left out.",
        lines=[source.data.count(b"\n", layout.data_start, start) + layout.data_line],
        value=source.decode(source.data[start:stop][:80]),
    )
    return DataEnd(start, 1)


def _without_padding(data: bytes, start: int, findings: FindingCollector) -> int:
    """Return the end without trailing NULs, Ctrl-Z and blank lines, keeping the line end of the last row."""
    stop = len(data)
    while stop > start and data[stop - 1] in b"\0\x1a\r\n":
        stop -= 1
    padding = data[stop:]
    if b"\0" in padding:
        findings.add(NOTE, "nul_padding", "The file ends in NUL bytes, as preallocated files do; they are skipped.")
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


def _is_cut(line: bytes, cell_above: bytes | None, layout: Layout) -> bool:
    """Whether cells are missing, or the last number may miss digits: it has fewer than some seen above it.

    A number that repeats the one above it is whole. One row less of a log is no loss, 79 for 799 is a wrong value.
    """
    cells = split_cells(line, layout.delimiter)
    if cells is None or len(cells) < layout.width + layout.trailing:
        return True
    if layout.trailing:
        return len(cells) == layout.width  # every whole row ends in a delimiter
    last = _SHAPE.fullmatch(cells[-1])
    above = [shape for shape in map(_SHAPE.fullmatch, layout.last_cells) if shape and shape[0]]
    if not layout.last_cells:
        return True  # nothing to compare with
    if last is None:
        return False  # no number: the reader of rows judges it
    if not last[0]:
        return all(layout.last_cells)
    decimals = [len(shape[2]) for shape in above if shape[2] is not None]
    exponents = [len(shape[3]) for shape in above if shape[3] is not None]
    if len(exponents) == len(above) and exponents:
        return last[3] is None or len(last[3]) < min(exponents)
    if cells[-1] == cell_above:
        return False
    if decimals:
        # Numbers of one precision have fewer decimals the longer they are.
        fewer_digits = len(last[1] + (last[2] or b"")) < max(len(shape[1] + (shape[2] or b"")) for shape in above)
        one_format = len(decimals) == len(above) and min(decimals) == max(decimals)
        return len(last[2] or b"") < max(decimals) or (fewer_digits and not one_format)
    return bool(above) and len(last[1]) < max(len(shape[1]) for shape in above)
