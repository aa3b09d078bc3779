"""Rows in which a comma is both the decimal sign and what stands between cells: `0,005,300,12` is 0.005 and 300.12.

Such rows are read only where both are declared and a header has half as many cells, for without one they may as well
be whole numbers; and only those in which every column has a whole and a decimal part.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

from ingest.findings import FILE, FindingCollector
from ingest.model import Declarations
from ingest.text.cells import split_cells
from ingest.text.source import Line, TextSource

BETWEEN = ";"
"""What stands between cells afterwards."""

_PAIR = rb"[ \t]*[+-]?\d*,\d+[ \t]*"
_ANY_ROW = re.compile(_PAIR + rb"(?:," + _PAIR + rb")*,?[ \t]*")


def with_pairs_joined(source: TextSource, declared: Declarations, findings: FindingCollector) -> TextSource | None:
    """Return the text with `BETWEEN` between its cells, of the same length; None where its rows are otherwise.

    A line that is neither the header nor a row of pairs stays as it is, and has too few cells then. Rows whose columns
    are named by number, and by no header, refuse the file.
    """
    if declared.decimal_sign != "," or declared.delimiter != ",":
        return None
    lines = [line for line in source.head_lines() if line.content.strip()]
    first = next((index for index, line in enumerate(lines) if _ANY_ROW.fullmatch(line.content)), None)
    if first is None:
        return None
    columns = len(_cells(lines[first])) // 2
    header = _header(lines[:first], declared)
    named = 0 if header is None else len(_cells(header))
    by_number = any(name.isdigit() for name in {**declared.profile_columns, **declared.columns})
    if header is None or named != columns or (by_number and not declared.header_row):
        if by_number and named != 2 * columns:
            _refuse_unnamed(lines[first], columns, findings)
        return None
    row = re.compile(rb"(?m)^" + b",".join([_PAIR] * columns) + rb",?[ \t]*(?=\r?$)")
    data = source.data[source.start :]
    start = header.start - source.start
    end = start + len(header.content)
    data = data[:start] + data[start:end].replace(b",", BETWEEN.encode()) + data[end:]
    return dataclasses.replace(source, data=source.data[: source.start] + row.sub(_joined, data))


def _header(above: Sequence[Line], declared: Declarations) -> Line | None:
    """Return the line that names the columns: the one declared, else the last above the rows."""
    if declared.header_row is None:
        return above[-1] if above else None
    return next((line for line in above if line.number == declared.header_row), None)


def _refuse_unnamed(row: Line, columns: int, findings: FindingCollector) -> None:
    message = (
        f"No header says whether the rows are {2 * columns} whole numbers or {columns} with a decimal comma: declare "
        "the names' line as `header_row` in a profile, or leave `--decimal ,` out where no number has decimals."
    )
    findings.add(FILE, "decimal_comma_unquoted", message, lines=[row.number])


def _cells(line: Line) -> list[bytes]:
    """Return the cells of a line, without what a last comma leaves behind it."""
    cells = split_cells(line.content, b",") or []
    return cells[:-1] if cells[-1:] == [b""] else cells


def _joined(row: re.Match[bytes]) -> bytes:
    cells = row[0].split(b",")
    pairs = [b",".join(cells[at : at + 2]) for at in range(0, len(cells), 2)]
    return BETWEEN.encode().join(pairs)
