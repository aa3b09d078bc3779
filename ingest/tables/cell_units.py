"""Units in the cells of a table, `5 ms;300.12 mm`: one unit throughout a column is the column's."""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Mapping, Sequence

from ingest.findings import FILE, NOTE, FindingCollector
from ingest.tables.header_cells import is_unit, normal_unit
from ingest.text.cells import is_missing
from ingest.text.source import TextSource

_NUMBER = rb"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?"
_BLANK = rb"(?:[ \t]|\xc2?\xa0)*"
_CELL = re.compile(rb"(" + _BLANK + _NUMBER + rb")(" + _BLANK + rb"([A-Za-z%\xb0\xb5\xc2\xce][^\s\d;,|\"]*))?" + _BLANK)
_SIGNS = (b"\t", b";", b"|", b",")
_JUDGED = 60
_FEWEST_ROWS = 3


def without_cell_units(
    source: TextSource, delimiter: bytes | None, findings: FindingCollector
) -> tuple[TextSource, Mapping[int, str]]:
    """Return the text with blanks for the units in its cells, of the same length, and the units by column from 0.

    A cell with another unit than those above it, or with none, refuses the file.
    """
    found = _columns(source, delimiter)
    if found is None:
        return source, {}
    sign, units = found
    lines = source.data[source.start :].split(b"\n")
    for index, line in enumerate(lines):
        cells = line.rstrip(b"\r").split(sign)
        ended = len(line) - len(line.rstrip(b"\r"))
        if not all(position < len(cells) for position in units):
            continue
        for position, unit in units.items():
            cells[position] = _plain(source, cells[position], unit, position, source.first_line + index, findings)
        lines[index] = sign.join(cells) + b"\r" * ended
    told = ", ".join(f"{unit!r} in column {position + 1}" for position, unit in units.items())
    findings.add(NOTE, "units_in_cells", f"Units stand in the cells and are read as those of the columns: {told}.")
    return dataclasses.replace(source, data=source.data[: source.start] + b"\n".join(lines)), units


def _columns(source: TextSource, delimiter: bytes | None) -> tuple[bytes, Mapping[int, str]] | None:
    """Return what stands between cells, and the units by column; None where the cells bear none."""
    lines = [line.content for line in source.head_lines() if line.content.strip()]
    best: tuple[float, bytes, list[list[bytes]]] = (0.0, b"", [])
    for sign in _SIGNS if delimiter is None else (delimiter,):
        rows = [row for row in (line.split(sign) for line in lines) if any(_unit(cell) for cell in row)][:_JUDGED]
        width, _ = Counter(map(len, rows)).most_common(1)[0] if rows else (0, 0)
        rows = [row for row in rows if len(row) == width]
        share = sum(_unit(cell) is not None for row in rows for cell in row) / max(1, sum(map(len, rows)))
        if len(rows) >= max(_FEWEST_ROWS, min(len(lines), _JUDGED) // 2) and width > 1 and share > best[0]:
            best = share, sign, rows
    _, sign, rows = best
    units = {position: unit for position in range(len(rows[0]) if rows else 0) if (unit := _usual(rows, position))}
    return (sign, units) if units else None


def _usual(rows: Sequence[Sequence[bytes]], position: int) -> str | None:
    """Return the unit that most of the cells of a column bear."""
    units = Counter(_unit(row[position]) for row in rows)
    unit, count = units.most_common(1)[0]
    return unit if unit is not None and 2 * count > len(rows) else None


def _unit(cell: bytes) -> str | None:
    """Return the unit behind the number in a cell, None where there is no number or no unit that is known."""
    match = _CELL.fullmatch(cell)
    text = match[3].decode("utf-8", errors="replace") if match and match[3] else ""
    return normal_unit(text) if text and is_unit(text) else None


def _plain(source: TextSource, cell: bytes, unit: str, position: int, line: int, findings: FindingCollector) -> bytes:
    """Return a cell with blanks for its unit; what is no number with that unit stays, and a number without is told."""
    match = _CELL.fullmatch(cell)
    if match is None or is_missing(cell.strip().lower()):
        return cell
    if _unit(cell) == unit:
        return match[1] + b" " * (len(cell) - len(match[1]))
    shown = source.decode(cell.strip())
    message = (
        f"Line {line} holds {shown!r} in column {position + 1}, of which the other cells are in {unit}: a column is "
        "read in one unit, so correct the cell, or export without units in the cells."
    )
    findings.add(FILE, "cell_units_differ", message, lines=[line], column=f"column {position + 1}", value=shown)
    return cell
