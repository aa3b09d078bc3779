"""The table in a delimited text, whose cells may bear units, `5 ms;300.12 mm`, or part at their own decimal commas.

Such texts are made plain before their layout is looked for. Rows in which a comma is both the decimal sign and what
stands between cells, `0,005,300,12` for 0.005 and 300.12, are read only where both are declared and a header has half
as many cells, for without one they may as well be whole numbers; and only those in which every column has a whole and a
decimal part.
"""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ingest.channels.names import is_unit, normal_unit, refuse_two_units
from ingest.declared import declared_columns, flag_names
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import Declarations
from ingest.spool import LARGE_BYTES, mapped
from ingest.tables.layout import Layout, check_above, find_layout
from ingest.tables.rows import read_rows
from ingest.tables.table import Block, Table, Wanted, read_preamble
from ingest.text.cells import BETWEEN_CELLS, COMMENT_STARTS, EXPONENT, is_missing, split_cells
from ingest.text.source import Line, TextSource, refuse_long_line


def text_table(source: TextSource, declared: Declarations, findings: FindingCollector) -> Table | None:
    """Find the table in a text, its rows not read yet; None, with a finding of severity file, where there is none.

    Raises `SecondHeader` where another table stands above it, as its rows do where one follows.
    """
    if source.first_line > 1:  # the lines declared are those of the first table in the text
        declared = dataclasses.replace(declared, header_row=None, units_row=None, first_row=None)
    if refuse_long_line(source, findings):
        return None
    pairs = with_pairs_joined(source, declared, findings)
    if "decimal_comma_unquoted" in findings:
        return None
    if pairs is not None:
        source, declared = pairs, dataclasses.replace(declared, delimiter=BETWEEN)
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
    shape = layout.shape if pairs is None else dataclasses.replace(layout.shape, delimiter=",")
    return Table(layout.names, units, layout.kinds, preamble, rows, text=shape)


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
    """Return a line with blanks for its units where it is a data row; one of another unit, or of none, is reported."""
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
    header = _pairs_header(lines[:first], declared)
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
    return dataclasses.replace(source, data=source.data[: source.start] + row.sub(_row_of_pairs, data))


def _pairs_header(above: Sequence[Line], declared: Declarations) -> Line | None:
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


def _row_of_pairs(row: re.Match[bytes]) -> bytes:
    cells = row[0].split(b",")
    pairs = [b",".join(cells[at : at + 2]) for at in range(0, len(cells), 2)]
    return BETWEEN.encode().join(pairs)
