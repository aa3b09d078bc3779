"""Rows in which a comma is both the decimal sign and what stands between cells: `0,005,300,12` is 0.005 and 300.12.

Such rows are read only where both are declared, and only those in which every column has a whole and a decimal part.
"""

from __future__ import annotations

import dataclasses
import re

from ingest.model import Declarations
from ingest.text.cells import split_cells
from ingest.text.source import Line, TextSource

BETWEEN = ";"
"""What stands between cells afterwards."""

_PAIR = rb"[ \t]*[+-]?\d*,\d+[ \t]*"
_ANY_ROW = re.compile(_PAIR + rb"(?:," + _PAIR + rb")*,?[ \t]*")


def with_pairs_joined(source: TextSource, declared: Declarations) -> TextSource | None:
    """Return the text with `BETWEEN` between its cells, of the same length; None where its rows are otherwise.

    A line that is neither the header nor a row of pairs stays as it is, and has too few cells then.
    """
    if declared.decimal_sign != "," or declared.delimiter != ",":
        return None
    lines = [line for line in source.head_lines() if line.content.strip()]
    rows = [index for index, line in enumerate(lines) if _ANY_ROW.fullmatch(line.content)]
    if not rows:
        return None
    columns = len(_cells(lines[rows[0]])) // 2
    header = next((line for line in lines[: rows[0]][::-1] if len(_cells(line)) == columns), None)
    if header is None and declared.header_row != 0:
        return None
    row = re.compile(rb"(?m)^" + b",".join([_PAIR] * columns) + rb",?[ \t]*(?=\r?$)")
    data = source.data[source.start :]
    if header is not None:
        start = header.start - source.start
        end = start + len(header.content)
        data = data[:start] + data[start:end].replace(b",", BETWEEN.encode()) + data[end:]
    return dataclasses.replace(source, data=source.data[: source.start] + row.sub(_joined, data))


def _cells(line: Line) -> list[bytes]:
    """Return the cells of a line, without what a last comma leaves behind it."""
    cells = split_cells(line.content, b",") or []
    return cells[:-1] if cells[-1:] == [b""] else cells


def _joined(row: re.Match[bytes]) -> bytes:
    cells = row[0].split(b",")
    pairs = [b",".join(cells[at : at + 2]) for at in range(0, len(cells), 2)]
    return BETWEEN.encode().join(pairs)
