"""Zip archives and workbooks (.xlsx, .xls, .ods), held to limits before anything is unpacked.

Numbers of workbooks keep all their digits, dates are ISO-8601.
"""

from __future__ import annotations

import copy
import datetime
import io
import re
import zipfile
from collections.abc import Sequence
from xml.parsers import expat

from ingest.model import Limits

Cell = object
"""What calamine gives: text, a number, a truth, a date, a time, a duration; an empty text for an empty cell."""

_XLS = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_ODS = b"mimetypeapplication/vnd.oasis.opendocument.spreadsheet"
_LONGEST_END = 22 + (1 << 16)  # the record behind a zip's directory, with a comment
_MANY = 0xFFFF  # its count of members where another record has that
_EXACT = 2.0**53
_CELL = re.compile(rb"<(?:\w+:)?(?:c|row)[\s/>]")
_PLACE = re.compile(rb"""\sr\s*=\s*["'][A-Za-z]{0,3}(\d{1,9})""")
_LETTERS = re.compile(rb"""\sr\s*=\s*["']([A-Za-z]{2,3})\d""")


class ArchiveRefusedError(ValueError):
    """The archive is damaged, unsafe or beyond a limit; the message is a sentence without its end."""


def workbook_kind(data: bytes) -> str | None:
    """Return `xlsx`, `xls` or `ods` for a workbook, by its first bytes or its directory; None for anything else."""
    if data.startswith(_XLS):
        return "xls"
    if data.startswith(b"PK"):
        if b"xl/workbook." in data[-(1 << 16) :]:
            return "xlsx"
        if data[30 : 30 + len(_ODS)] == _ODS:
            return "ods"
    return None


def check_zip(archive: zipfile.ZipFile, data: bytes, limits: Limits) -> None:
    """Compare the directory of an archive with the count at its end and the limits. Raises `ArchiveRefusedError`."""
    members, packed = archive.infolist(), len(data)
    expanded = sum(member.file_size for member in members)
    end = data[-_LONGEST_END:]
    n_members = int.from_bytes(end[end.rfind(b"PK\5\6") :][10:12], "little")
    if n_members not in (len(members), _MANY):  # zipfile goes on where a damaged entry swallows the next
        raise ArchiveRefusedError(f"its directory names {len(members)} members of {n_members}: copy it again")
    if len(members) > limits.most_members:
        raise ArchiveRefusedError(f"it has {len(members)} members (limit most_members: {limits.most_members})")
    if expanded > limits.largest_expanded_bytes:
        bound = f"limit largest_expanded_bytes: {limits.largest_expanded_bytes}"
        raise ArchiveRefusedError(f"it holds {expanded} bytes ({bound})")
    if expanded > limits.most_expanded(packed):
        bound = f"limit largest_expansion: {limits.largest_expansion}"
        raise ArchiveRefusedError(f"its {packed} bytes would expand to {expanded} ({bound})")


def member_bytes(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """Unpack a member, its checksum compared, to one byte more at most than the directory says that there is.

    Raises `ArchiveRefusedError` where there is more or less: a reader that believes the directory stops too early.
    """
    stated, more = member.file_size, copy.copy(member)
    more.file_size += 1  # zipfile reads no further, and compares a checksum only where it came to the end
    with archive.open(more) as unpacking:
        content = unpacking.read(stated + 1)
    if len(content) != stated:
        raise ArchiveRefusedError(
            f"its member {member.filename!r} does not hold the {stated} bytes that its directory says: pack it again"
        )
    return content


def workbook_sheets(data: bytes, limits: Limits) -> list[tuple[str, Sequence[Sequence[Cell]]]]:
    """Return name and rows of every sheet that has cells, from its first row on, blank rows included.

    Raises `ArchiveRefusedError` for a workbook that is damaged or beyond a limit.
    """
    import python_calamine as calamine  # slow to load, and few files are of this format

    found: list[tuple[str, Sequence[Sequence[Cell]]]] = []
    try:
        if not data.startswith(_XLS):
            _check_sheets(data, limits)
        with calamine.CalamineWorkbook.from_filelike(io.BytesIO(data)) as book:
            names = [sheet.name for sheet in book.sheets_metadata if sheet.typ == calamine.SheetTypeEnum.WorkSheet]
            if len(names) > limits.most_members:
                raise ArchiveRefusedError(f"it has {len(names)} sheets (limit most_members: {limits.most_members})")
            for name in names:
                sheet = book.get_sheet_by_name(name)
                if sheet.start is not None:
                    found.append((name, sheet.to_python(skip_empty_area=False)))
    except ArchiveRefusedError:
        raise
    except Exception as error:  # calamine, zipfile and zlib raise many kinds for a damaged file
        raise ArchiveRefusedError(f"it is damaged ({str(error)[:120]})") from error
    return found


def cell_text(cell: Cell) -> str:
    """Return what a cell of a workbook shows, all digits of a number kept."""
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < _EXACT else repr(cell)
    if isinstance(cell, bool):
        return "1" if cell else "0"
    if isinstance(cell, datetime.datetime):
        return cell.isoformat(" ")
    if isinstance(cell, datetime.timedelta):
        minutes, seconds = divmod(cell.total_seconds(), 60)
        return f"{int(minutes // 60)}:{int(minutes % 60):02d}:{seconds:02.0f}"
    return str(cell)


def _check_sheets(data: bytes, limits: Limits) -> None:
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
            if name == "content.xml":
                _check_area(*_repeated_cells(content), limits)
            elif name.endswith(".xml") and "sharedstrings" not in name and "styles" not in name:
                _check_area(*_placed_cells(content), limits)


def _check_area(rows: int, columns: int, limits: Limits) -> None:
    if rows * columns > limits.most_cells:
        raise ArchiveRefusedError(
            f"a sheet of {rows} rows and {columns} columns is too large (limit most_cells: {limits.most_cells})"
        )


def _placed_cells(xml: bytes) -> tuple[int, int]:
    """Return the farthest row and column that a sheet of Excel names; cells without a place follow each other."""
    places = _PLACE.findall(xml)
    without = max(0, len(_CELL.findall(xml)) - len(places))
    rows = max(without, max(map(int, set(places)), default=0))
    columns = max(26, without)
    for letters in set(_LETTERS.findall(xml)):
        number = 0
        for letter in letters.upper():
            number = 26 * number + letter - 64
        columns = max(columns, number)
    return rows, columns


def _repeated_cells(xml: bytes) -> tuple[int, int]:
    """Return the farthest row and column with a value in any sheet of an OpenDocument, where cells and rows that are
    equal stand once with their number.
    """
    farthest = [0, 0]
    row = column = rows_repeated = 0
    filled = False

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal row, column, rows_repeated, filled
        if name == "table:table":
            row = 0
        elif name == "table:table-row":
            column, filled, rows_repeated = 0, False, int(attributes.get("table:number-rows-repeated", 1))
        elif name in ("table:table-cell", "table:covered-table-cell"):
            column += int(attributes.get("table:number-columns-repeated", 1))
        if "office:value-type" in attributes or name == "text:p":
            farthest[1], filled = max(farthest[1], column), True

    def end(name: str) -> None:
        nonlocal row
        if name == "table:table-row":
            row += rows_repeated
            farthest[0] = max(farthest[0], row) if filled else farthest[0]

    def refuse_entity(name: str, *_given: object) -> None:
        raise ArchiveRefusedError(f"it declares an entity {name!r}, which no spreadsheet does")

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, refuse_entity
    parser.Parse(xml, True)
    return farthest[0], farthest[1]
