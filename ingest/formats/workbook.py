"""Workbooks, .xlsx, .xls and .ods: every sheet is written out as tabbed text and read as a file of its own.

So logs and hand-kept charger sheets in workbooks get every check that text gets. Numbers keep all their digits, dates
are written as ISO-8601. Where a row of names holds one time column several times, each governs the columns to its right
and becomes a table of its own.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import pairwise

from ingest.channels.names import TIME_NAMES, parse_header, squash
from ingest.containers import ArchiveRefusedError, Cell, cell_text, workbook_kind, workbook_sheets
from ingest.formats.archive import read_members
from ingest.formats.format import Format, Head
from ingest.model import FILE, NOTE, Declarations, FindingCollector, Reading
from ingest.text import COMMA_NUMBER, is_number

_SAVE = "save its sheets as CSV"
_HEADER_ROWS = 60


def _read(head: Head, findings: FindingCollector) -> Reading:
    try:
        sheets = workbook_sheets(head.data, head.declared.limits)
    except ArchiveRefusedError as why:
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
        typed = (cell.strip().encode() for row in rows for cell in row if isinstance(cell, str))
        text_numbers |= any(map(COMMA_NUMBER.fullmatch, typed))
        for number, table in enumerate(tables, start=1):
            members.append((name if len(tables) == 1 else f"{name} {number}", _as_text(table)))
    if not members:
        findings.add(FILE, "no_data_rows", f"No sheet of the workbook holds numbers; {_SAVE} if one should.")
        return Reading()
    declared = _declared(head.declared, text_numbers)
    if any(b"\t" in text for _, text in members):
        declared = dataclasses.replace(declared, delimiter="\t")
    instead = f"{_SAVE} and ingest them one by one"
    return read_members(members, declared, head.read_file, findings, instead, of_workbook=True)


def _declared(declared: Declarations, text_numbers: bool) -> Declarations:
    """Return the declarations for the text written here: its decimal sign is the point, unless cells are typed text."""
    inside = None if declared.format in ("xlsx", "xls", "ods") else declared.format
    decimal = declared.decimal_sign or (None if text_numbers else ".")
    return dataclasses.replace(declared, format=inside, decimal_sign=decimal)


def _is_value(cell: Cell) -> bool:
    if isinstance(cell, str):
        return bool(cell) and is_number(cell.strip().encode("utf-8"), comma=True)
    return not isinstance(cell, bool)


def _tables(rows: Sequence[Sequence[Cell]]) -> list[list[Sequence[Cell]]]:
    """Split a sheet whose row of names repeats the name of its time column; what stands above goes with each."""
    for number, row in enumerate(rows[:_HEADER_ROWS]):
        names = [squash(parse_header(cell).base) if isinstance(cell, str) else "" for cell in row]
        times = [position for position, name in enumerate(names) if name in TIME_NAMES]
        if len(times) > 1 and len({squash(str(row[position])) for position in times}) == 1:
            edges = [0, *times[1:], len(row)]
            return [
                [*rows[:number], *(below[first:stop] for below in rows[number:])] for first, stop in pairwise(edges)
            ]
    return [list(rows)]


def _as_text(rows: Sequence[Sequence[Cell]]) -> bytes:
    """Return the rows as lines of tabbed text, line n being row n; empty columns and rows at the end are left out."""
    widest = max((position for row in rows for position, cell in enumerate(row) if cell != ""), default=-1) + 1
    lines = ["\t".join([_text(cell) for cell in row[:widest]]) for row in rows]
    while lines and not lines[-1].strip():
        lines.pop()
    return ("\n".join(lines) + "\n").encode()


def _text(cell: Cell) -> str:
    return " ".join(cell.replace('"', "'").split()) if isinstance(cell, str) else cell_text(cell)


def _format(name: str, version: int, evidence: str) -> Format:
    def recognise(head: Head) -> str | None:
        """Its first bytes, or its directory."""
        return evidence if workbook_kind(head.data) == name else None

    return Format(name, version, recognise, _read, container=True, begins=rb"PK|\xd0\xcf\x11\xe0")


FORMATS = (
    _format("xlsx", 4, "a zip archive with a workbook in it"),
    _format("xls", 3, "it begins as an old Excel workbook"),
    _format("ods", 1, "it begins as an OpenDocument spreadsheet"),
)
