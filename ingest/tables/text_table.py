"""The table in a delimited text, whose cells may bear units, `5 ms;300.12 mm`.

Such texts are made plain before their layout is looked for.
"""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ingest.channels.names import is_unit, normal_unit, refuse_two_units
from ingest.declared import declared_columns, flag_names
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import Declarations
from ingest.spool import LARGE_BYTES, mapped
from ingest.tables.layout import Layout, check_above, find_layout
from ingest.tables.rows import read_rows
from ingest.tables.table import Block, Table, Wanted, read_preamble
from ingest.text.cells import BETWEEN_CELLS, COMMENT_STARTS, EXPONENT, is_missing
from ingest.text.source import Line, TextSource, refuse_long_line


def text_table(source: TextSource, declared: Declarations, findings: FindingCollector) -> Table | None:
    """Find the table in a text, its rows not read yet; None, with a finding of severity file, where there is none.

    Raises `SecondHeader` where another table stands above it, as its rows do where one follows.
    """
    if source.first_line > 1:  # the lines declared are those of the first table in the text
        declared = dataclasses.replace(declared, header_row=None, units_row=None, first_row=None)
    if refuse_long_line(source, findings):
        return None
    source, cell_units = without_cell_units(source, declared, findings)
    if "cell_units_too_large" in findings:
        return None
    layout = find_layout(source, declared, findings)
    if layout is None:
        return None
    check_above(source, layout)

    def rows(wanted: Sequence[Wanted]) -> Block:
        return read_rows(source, layout, wanted, findings)

    preamble = read_preamble((*source.comments, *layout.preamble), declared.date_format)
    units = _units(layout, cell_units, declared, findings)
    return Table(layout.names, units, layout.kinds, preamble, rows, text=layout.shape)


def _units(
    layout: Layout, cell_units: Mapping[int, str], declared: Declarations, findings: FindingCollector
) -> tuple[str | None, ...]:
    """Return the units of the columns, from their cells or the row of units; two different ones refuse the file."""
    declarations = declared_columns(declared, layout.names) if declared.override_units else {}
    flags = flag_names(layout.names)
    for position, (name, unit) in enumerate(zip(layout.names, layout.units, strict=True)):
        decided = position in declarations and declarations[position].unit is not None
        if not decided:
            refuse_two_units(name, flags[position], normal_unit(unit or ""), cell_units.get(position), findings)
    return tuple(cell_units.get(position) or unit for position, unit in enumerate(layout.units))


_NUMBER = rb"[+-]?(?:\d+[.,]?\d*|[.,]\d+)" + EXPONENT
_BLANK = rb"(?:[ \t]|\xc2?\xa0)*"
_UNIT_BEGIN = rb"[A-Za-z%\xb0\xb5\xc2\xce]"
_UNIT_BEGINS = re.compile(_UNIT_BEGIN)
_CELL = re.compile(rb"(" + _BLANK + _NUMBER + rb")(" + _BLANK + rb"(" + _UNIT_BEGIN + rb"[^\s\d;,|\"]*))?" + _BLANK)
_JUDGED = 60
_FEWEST_ROWS = 3


@dataclass(frozen=True, slots=True)
class _Columns:
    """What stands between cells, the units by column from 0, the columns of numbers, the first row."""

    sign: bytes
    units: Mapping[int, str]
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
    listed = ", ".join(f"{unit!r} in column {position + 1}" for position, unit in columns.units.items())
    if mapped(source.data) is not None:
        message = (
            f"Units stand in the cells ({listed}), which are read in files of at most {LARGE_BYTES >> 20} MiB: export "
            "without units in the cells, or split the file."
        )
        findings.add(FILE, "cell_units_too_large", message)
        return source, columns.units
    findings.add(NOTE, "units_in_cells", f"Units stand in the cells and are read as those of the columns: {listed}.")
    return dataclasses.replace(source, data=_blanked(source, columns, findings)), columns.units


def _blanked(source: TextSource, columns: _Columns, findings: FindingCollector) -> bytes:
    """Return the data with blanks for the units in its rows."""
    start = columns.first.start
    lines = enumerate(source.data[start:].split(b"\n"), start=columns.first.number)
    return source.data[:start] + b"\n".join(_row(source, line, columns, number, findings) for number, line in lines)


def _row(source: TextSource, content: bytes, columns: _Columns, line: int, findings: FindingCollector) -> bytes:
    """Return a line with blanks for its units where it is a data row; one of another unit, or of none, is reported."""
    bare = content.rstrip(b"\r")
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
    for sign in BETWEEN_CELLS if declared.delimiter is None else (declared.delimiter.encode("latin-1"),):
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
    columns = _Columns(sign, units, numeric, lines[0])
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
    match = _CELL.fullmatch(cell)
    text = (match[3] or b"").decode("utf-8", errors="replace") if match else ""
    return normal_unit(text) if text and is_unit(text) else None


def _plain(source: TextSource, cell: bytes, unit: str, position: int, line: int, findings: FindingCollector) -> bytes:
    """Return a cell with blanks for its unit; what is no number with that unit stays; a number without is reported."""
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
