"""Units in the cells of a table, `5 ms;300.12 mm`: one unit throughout a column is the column's."""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import Declarations
from ingest.spool.mapped_bytes import LARGE_BYTES, mapped
from ingest.tables.header_cells import is_unit, normal_unit
from ingest.text.cells import COMMENT_STARTS, is_missing
from ingest.text.source import Line, TextSource

_NUMBER = rb"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?"
_BLANK = rb"(?:[ \t]|\xc2?\xa0)*"
_UNIT_BEGIN = rb"[A-Za-z%\xb0\xb5\xc2\xce]"
_UNIT_BEGINS = re.compile(_UNIT_BEGIN)
_CELL = re.compile(rb"(" + _BLANK + _NUMBER + rb")(" + _BLANK + rb"(" + _UNIT_BEGIN + rb"[^\s\d;,|\"]*))?" + _BLANK)
_SIGNS = (b"\t", b";", b"|", b",")
_JUDGED = 60
_FEWEST_ROWS = 3
_BLOCK_BYTES = 1 << 20


@dataclass(frozen=True, slots=True)
class _Columns:
    """What stands between cells, the units by column from 0 and as written, the columns of numbers, the first row."""

    sign: bytes
    units: Mapping[int, str]
    spelled: Mapping[int, Collection[bytes]]
    numeric: Sequence[int]
    first: Line

    def row(self, content: bytes) -> list[bytes] | None:
        """Return the cells of a data row: numbers, with a unit or without, or missing, in each column of numbers.

        None for any other line: a title, a comment, a header, a sum below the rows.
        """
        cells = content.split(self.sign)
        if len(cells) <= self.numeric[-1] or _is_comment(content, cells):
            return None
        own = [cells[position].strip() for position in self.numeric]
        return cells if any(own) and all(_CELL.fullmatch(cell) or is_missing(cell.lower()) for cell in own) else None


def without_cell_units(
    source: TextSource, declared: Declarations, findings: FindingCollector
) -> tuple[TextSource, Mapping[int, str]]:
    """Return the text with blanks for the units in its cells, of the same length, and the units by column from 0.

    A data row with another unit than those above it, or with none, refuses the file; so do units in a mapped one.
    """
    columns = _columns(source, declared)
    if columns is None:
        return source, {}
    told = ", ".join(f"{unit!r} in column {position + 1}" for position, unit in columns.units.items())
    if mapped(source.data) is not None:
        message = (
            f"Units stand in the cells ({told}), which are read in files of at most {LARGE_BYTES >> 20} MiB: export "
            "without units in the cells, or split the file."
        )
        findings.add(FILE, "cell_units_too_large", message)
        return source, columns.units
    findings.add(NOTE, "units_in_cells", f"Units stand in the cells and are read as those of the columns: {told}.")
    return dataclasses.replace(source, data=_blanked(source, columns, findings)), columns.units


def _blanked(source: TextSource, columns: _Columns, findings: FindingCollector) -> bytes:
    """Return the data with blanks for the units in its rows, made in blocks of whole lines."""
    data, start, line = source.data, columns.first.start, columns.first.number - 1
    usual = _usual_row(columns)
    done = [data[:start]]

    def blanked(found: re.Match[bytes]) -> bytes:
        nonlocal line
        line += 1
        if found.lastindex is None:
            return _other_row(source, found[0], columns, line, findings)
        parts = found.groups()
        return b"".join([part if at % 2 == 0 else b" " * len(part) for at, part in enumerate(parts)])

    while start < len(data):
        stop = data.find(b"\n", start + _BLOCK_BYTES) + 1 or len(data)
        done.append(usual.sub(blanked, data[start:stop]))
        start = stop
    return b"".join(done)


def _usual_row(columns: _Columns) -> re.Pattern[bytes]:
    """Return what matches a line: with groups, in turn text and unit, where every unit is written as in the first rows.

    Of any other line there is no group.
    """
    sign = re.escape(columns.sign)
    blank = rb"(?: |\xc2?\xa0)*"
    pattern = b"("
    for position in range(max(columns.units) + 1):
        between = sign if position else b""
        if position not in columns.units:
            pattern += between + rb"[^\n" + sign + rb"]*"
            continue
        unit = b"|".join(map(re.escape, columns.spelled[position]))
        pattern += between + blank + _NUMBER + rb")(" + blank + rb"(?:" + unit + rb"))(" + blank
    return re.compile(pattern + rb"(?:" + sign + rb"[^\n]*)?\r?(?:\n|\Z))|[^\n]+\n?|\n")


def _other_row(source: TextSource, content: bytes, columns: _Columns, line: int, findings: FindingCollector) -> bytes:
    """Return a line with blanks for its units where it is a data row; one of another unit, or of none, is told."""
    bare = content.rstrip(b"\r\n")
    cells = columns.row(bare)
    if cells is None:
        return content
    for position, unit in columns.units.items():
        cells[position] = _plain(source, cells[position], unit, position, line, findings)
    return columns.sign.join(cells) + content[len(bare) :]


def _columns(source: TextSource, declared: Declarations) -> _Columns | None:
    """Return what is known of the columns from the first lines; None where no cells bear units."""
    lines = [line for line in source.head_lines() if line.content.strip()]
    lettered = [line for line in lines if _UNIT_BEGINS.search(line.content)]  # of most logs only the header
    best: tuple[float, bytes, list[list[bytes]]] = (0.0, b"", [])
    for sign in _SIGNS if declared.delimiter is None else (declared.delimiter.encode("latin-1"),):
        rows = [row for row in (line.content.split(sign) for line in lettered) if any(map(_unit, row))][:_JUDGED]
        width, _ = Counter(map(len, rows)).most_common(1)[0] if rows else (0, 0)
        rows = [row for row in rows if len(row) == width]
        share = sum(_unit(cell) is not None for row in rows for cell in row) / max(1, sum(map(len, rows)))
        if len(rows) >= max(_FEWEST_ROWS, min(len(lines), _JUDGED) // 2) and width > 1 and share > best[0]:
            best = share, sign, rows
    _, sign, rows = best
    positions = range(len(rows[0]) if rows else 0)
    units = {position: unit for position in positions if (unit := _usual(rows, position))}
    if not units:
        return None
    numeric = [at for at in positions if 2 * sum(_CELL.fullmatch(row[at]) is not None for row in rows) > len(rows)]
    spelled = {at: {_written(row[at]) for row in rows if _unit(row[at]) == units[at]} for at in units}
    columns = _Columns(sign, units, spelled, numeric, lines[0])
    return dataclasses.replace(columns, first=_first_row(lines, columns, declared))


def _first_row(lines: Sequence[Line], columns: _Columns, declared: Declarations) -> Line:
    """Return the first of the rows that no line of words, and no declared one, parts from the first with its units."""
    above = max(declared.header_row or 0, declared.units_row or 0, (declared.first_row or 1) - 1)
    first = None
    for line in lines:
        cells = line.content.split(columns.sign)
        row = columns.row(line.content)
        if line.number <= above or (row is None and not (_is_comment(line.content, cells) and len(cells) == 1)):
            first = None
            continue
        first = first or line
        if row is not None and any(_unit(row[position]) == unit for position, unit in columns.units.items()):
            break
    return first or lines[0]


def _is_comment(content: bytes, cells: Sequence[bytes]) -> bool:
    return content.lstrip().startswith(COMMENT_STARTS) and not is_missing(cells[0].strip().lower())


def _usual(rows: Sequence[Sequence[bytes]], position: int) -> str | None:
    """Return the unit that most of the cells of a column bear."""
    units = Counter(_unit(row[position]) for row in rows)
    unit, count = units.most_common(1)[0]
    return unit if unit is not None and 2 * count > len(rows) else None


def _unit(cell: bytes) -> str | None:
    """Return the unit behind the number in a cell, None where there is no number or no unit that is known."""
    text = _written(cell).decode("utf-8", errors="replace")
    return normal_unit(text) if text and is_unit(text) else None


def _written(cell: bytes) -> bytes:
    """Return what stands behind the number in a cell, empty where nothing does."""
    match = _CELL.fullmatch(cell)
    return (match[3] or b"") if match else b""


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
