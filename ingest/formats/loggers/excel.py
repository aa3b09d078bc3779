"""Excel workbooks, .xlsx and .xls: every sheet is written out as tabbed text and read as a file of its own.

So logs and hand-kept charger sheets in workbooks get every check that text gets. Numbers keep all their digits, dates
are written as ISO-8601. Where a row of names holds one time column several times, each governs the columns to its right
and becomes a table of its own.
"""

from __future__ import annotations

import dataclasses
import datetime
import io
import re
import zipfile
from collections.abc import Sequence
from itertools import pairwise

from ingest.channels.names import TIME_NAMES, parse_header, squash
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.formats.archive import ArchiveRefusedError, check_zip, is_workbook, member_bytes, read_members
from ingest.formats.format import SIGNATURE, Clue, Format, Head, Recognition
from ingest.model import Declarations, Limits, Reading
from ingest.text.cells import COMMA_NUMBER, is_number

Cell = object
"""What calamine gives: text, a number, a truth, a date, a time, a duration; an empty text for an empty cell."""

_XLS = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_SAVE = "save its sheets as CSV"
_HEADER_ROWS = 60
_EXACT = 2.0**53
_CELL = re.compile(rb"<(?:\w+:)?(?:c|row)[\s/>]")
_PLACE = re.compile(rb"""\sr\s*=\s*["'][A-Za-z]{0,3}(\d{1,9})""")
_LETTERS = re.compile(rb"""\sr\s*=\s*["']([A-Za-z]{2,3})\d""")


def _recognise_xlsx(head: Head) -> Recognition | None:
    return Recognition(SIGNATURE, "a zip archive with a workbook in it") if is_workbook(head.data) else None


def _recognise_xls(head: Head) -> Recognition | None:
    return Recognition(SIGNATURE, "it begins as an old Excel workbook") if head.data.startswith(_XLS) else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    limits = head.declared.limits
    try:
        if not head.data.startswith(_XLS):
            _check_size(head.data, limits)
        sheets = _sheets(head.data, limits)
    except Exception as error:  # calamine, zipfile and zlib raise many kinds for a damaged file
        why = str(error) if isinstance(error, ArchiveRefusedError) else f"it is damaged ({str(error)[:120]})"
        findings.add(FILE, "workbook_refused", f"The workbook is not read: {why}; {_SAVE}.")
        return Reading()
    members: list[tuple[str, bytes]] = []
    text_numbers = False
    for name, rows in sheets:
        if not any(_is_value(cell) for row in rows for cell in row):
            message = "The sheet holds no number: it stays in the raw copy only."
            findings.add(NOTE, "sheet_without_numbers", message, column=name)
            continue
        tables = _tables(rows)
        text_numbers |= any(_is_comma_number(cell) for row in rows for cell in row)
        for number, table in enumerate(tables, start=1):
            members.append((name if len(tables) == 1 else f"{name} {number}", _as_text(table)))
    if not members:
        findings.add(FILE, "no_data_rows", f"No sheet of the workbook holds numbers; {_SAVE} if one should.")
        return Reading()
    declared = _declared(head.declared, text_numbers)
    if any(b"\t" in text for _, text in members):
        declared = dataclasses.replace(declared, delimiter="\t")
    instead = f"{_SAVE} and ingest them one by one"
    return read_members(members, declared, findings, instead, beside_table=True)


def _declared(declared: Declarations, text_numbers: bool) -> Declarations:
    """Return the declarations for the text written here: its decimal sign is the point, unless cells are typed text."""
    inside = None if declared.format in ("xlsx", "xls") else declared.format
    decimal = declared.decimal_sign or (None if text_numbers else ".")
    return dataclasses.replace(declared, format=inside, decimal_sign=decimal)


def _check_size(data: bytes, limits: Limits) -> None:
    """Refuse a workbook that unpacks to too much, or whose cells lie so far apart that the area between is too large.

    Calamine allocates the whole rectangle of a sheet, which two cells can make larger than any memory.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        check_zip(archive, data, limits)
        for member in archive.infolist():
            name = member.filename.lower()
            if name.endswith(".bin") and "worksheets" in name:
                raise ArchiveRefusedError("it is a binary workbook (.xlsb)")
            content = member_bytes(archive, member)
            if name.endswith(".xml") and "sharedstrings" not in name and "styles" not in name:
                _check_cells(content, limits)


def _check_cells(xml: bytes, limits: Limits) -> None:
    """Refuse a sheet by the farthest row and column that its XML names; cells without a place follow each other."""
    places = _PLACE.findall(xml)
    without = max(0, len(_CELL.findall(xml)) - len(places))
    rows = max(without, max(map(int, set(places)), default=0))
    columns = max(26, without)
    for letters in set(_LETTERS.findall(xml)):
        number = 0
        for letter in letters.upper():
            number = 26 * number + letter - 64
        columns = max(columns, number)
    if rows * columns > limits.most_cells:
        raise ArchiveRefusedError(
            f"a sheet of {rows} rows and {columns} columns is too large (limit most_cells: {limits.most_cells})"
        )


def _sheets(data: bytes, limits: Limits) -> list[tuple[str, Sequence[Sequence[Cell]]]]:
    """Return name and rows of every sheet of cells, from the first row on, blank ones included."""
    import python_calamine as calamine  # slow to load, and few files are of this format

    found: list[tuple[str, Sequence[Sequence[Cell]]]] = []
    with calamine.CalamineWorkbook.from_filelike(io.BytesIO(data)) as book:
        names = [sheet.name for sheet in book.sheets_metadata if sheet.typ == calamine.SheetTypeEnum.WorkSheet]
        if len(names) > limits.most_members:
            raise ArchiveRefusedError(f"it has {len(names)} sheets (limit most_members: {limits.most_members})")
        for name in names:
            sheet = book.get_sheet_by_name(name)
            if sheet.start is not None:
                found.append((name, sheet.to_python(skip_empty_area=False)))
    return found


def _is_value(cell: Cell) -> bool:
    if isinstance(cell, str):
        return bool(cell) and is_number(cell.strip().encode("utf-8"), comma=True)
    return not isinstance(cell, bool)


def _is_comma_number(cell: Cell) -> bool:
    return isinstance(cell, str) and bool(cell) and COMMA_NUMBER.fullmatch(cell.strip().encode("utf-8")) is not None


def _tables(rows: Sequence[Sequence[Cell]]) -> list[list[Sequence[Cell]]]:
    """Split a sheet whose row of names repeats the name of its time column; what stands above goes with each."""
    for number, row in enumerate(rows[:_HEADER_ROWS]):
        times = [position for position, cell in enumerate(row) if isinstance(cell, str) and _is_time(cell)]
        if len(times) > 1 and len({squash(str(row[position])) for position in times}) == 1:
            edges = [0, *times[1:], len(row)]
            return [
                [*rows[:number], *(below[first:stop] for below in rows[number:])] for first, stop in pairwise(edges)
            ]
    return [list(rows)]


def _is_time(name: str) -> bool:
    return squash(parse_header(name).base) in TIME_NAMES


def _as_text(rows: Sequence[Sequence[Cell]]) -> bytes:
    """Return the rows as lines of tabbed text, line n being row n; empty columns and rows at the end are left out."""
    widest = max((position for row in rows for position, cell in enumerate(row) if cell != ""), default=-1) + 1
    lines = ["\t".join([_text(cell) for cell in row[:widest]]) for row in rows]
    while lines and not lines[-1].strip():
        lines.pop()
    return ("\n".join(lines) + "\n").encode()


def _text(cell: Cell) -> str:
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < _EXACT else repr(cell)
    if isinstance(cell, str):
        return " ".join(cell.replace('"', "'").split())
    if isinstance(cell, bool):
        return "1" if cell else "0"
    if isinstance(cell, datetime.datetime):
        return cell.isoformat(" ")
    if isinstance(cell, datetime.timedelta):
        minutes, seconds = divmod(cell.total_seconds(), 60)
        return f"{int(minutes // 60)}:{int(minutes % 60):02d}:{seconds:02.0f}"
    return str(cell)


XLSX = Format("xlsx", 4, _recognise_xlsx, _read, container=True, clue=Clue(begins=(b"PK",)))
XLS = Format("xls", 3, _recognise_xls, _read, container=True, clue=Clue(begins=(_XLS,)))
