"""The one reader of sheets that people keep: a header, and a row for each thing; as text, or in a workbook.

Text is UTF-8, UTF-16 with its mark, or a page such as cp1252; a comma, a semicolon, a tab or a stroke stands between
cells. Line numbers are those of the file, or of the rows of a workbook's sheet.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import merge
from operator import itemgetter
from typing import NamedTuple

from data_schema.errors import InputRefused, UsageError, unknown_name
from ingest.containers import ArchiveRefusedError, cell_text, workbook_kind, workbook_sheets
from ingest.model import DEFAULT_LIMITS, FindingCollector
from ingest.text import (
    BETWEEN_CELLS,
    COMMA_NUMBER,
    DEFAULT_PAGE,
    NUMBER,
    CellFault,
    TextSource,
    decimal_sign_of,
    is_grouped,
    is_missing,
    is_text,
    is_wide,
    may_group,
    numbered_lines,
    open_text,
    parse_cell,
    split_cells,
)

MINUS = "\N{MINUS SIGN}"
"""The typeset minus, which word processors write in place of the hyphen."""
MOST_FAULTS_SHOWN = 50
_MOST_LINES_SHOWN = 20
SEPARATOR_LINE = re.compile(rb'\s*"?sep=([,;\t|])"?\s*', re.IGNORECASE)
"""A first line that spreadsheets write."""
_MOST_QUOTED_LINES = 254
"""Lines that the quoted cells of a row may span: as many as a cell of Excel can hold."""
_HUNDREDS = re.compile(r"[+-]?[1-9]\d\d")
_WITH_UNIT = re.compile(r"([+-]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?)\s*([^\W\d_]\S*|[%°]\S*)")


@dataclass(frozen=True, slots=True)
class SheetFile:
    """The bytes of a sheet, what messages call it, and what is declared of it.

    `page` is that of text which is neither UTF-8 nor UTF-16 (None: cp1252), `decimal` the decimal sign, None where it
    shows; `complete`: a last line without line end is whole.
    """

    name: str
    data: bytes
    page: str | None = None
    decimal: str | None = None
    complete: bool = True


@dataclass(frozen=True, slots=True)
class SheetFault:
    """What is wrong with a cell, or with a whole row where `column` is None."""

    line: int
    column: str | None
    sentence: str
    value: str = ""


class SheetRefused(InputRefused):
    """A sheet that cannot be used: all that is wrong with it, each by file, line and column.

    `sentences` has one for all `faults` of a column that are alike, beside these.
    """

    def __init__(self, file: str, faults: Sequence[SheetFault]) -> None:
        self.faults = tuple(sorted(faults, key=lambda fault: fault.line))
        alike: dict[tuple[str | None, str], list[SheetFault]] = {}
        for fault in self.faults:
            alike.setdefault((fault.column, fault.sentence), []).append(fault)
        self.sentences = [(_fault_text(same, f" of {file}"), same) for same in alike.values()]
        shown = list(alike.values())[:MOST_FAULTS_SHOWN]
        if len(alike) == 1:
            super().__init__(self.sentences[0][0])
            return
        rest = len(self.faults) - sum(map(len, shown))
        listed = [*map(_fault_text, shown), *([f"and {rest} more."] if rest else [])]
        count = f"{len(self.faults)} faults; correct them and try again:"
        super().__init__("\n  ".join([f"{file} has {count}", *listed]))


def _fault_text(same: Sequence[SheetFault], of: str = "") -> str:
    """Say once what is wrong in several lines."""
    first = same[0]
    where = f"line {first.line}{of}"
    if len(same) > 1:
        where = f"{len(same)} lines{of}, {', '.join(str(fault.line) for fault in same[:_MOST_LINES_SHOWN])}"
        where += f" and {len(same) - _MOST_LINES_SHOWN} more" if len(same) > _MOST_LINES_SHOWN else ""
    return f"{where}{'' if first.column is None else f', {first.column}'}: {first.sentence}"


@dataclass(frozen=True, slots=True)
class Sheet:
    """Cells as text, stripped, a row for each of `lines`, as wide as `names`.

    `delimiter` is empty in a workbook; `encoding` is the page that the text was read in. Rows of another width are
    among the `faults`; `cut`: its last line has no line end, and nobody said that it is whole.
    """

    file: SheetFile
    names: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    header_line: int
    delimiter: str
    encoding: str
    faults: tuple[SheetFault, ...]
    cut: bool

    @property
    def columns(self) -> Mapping[str, tuple[str, ...]]:
        """The columns that have a name, by it."""
        return {name: tuple(row[place] for row in self.rows) for place, name in enumerate(self.names) if name}

    def cells(self, name: str, option: str) -> tuple[str, ...]:
        """Return a column; raises `UnknownName` with the nearest name that there is."""
        if name not in self.names:
            raise unknown_name(f"column of {self.file.name} (for {option})", name, self.columns)
        return self.columns[name]

    def refuse(self, further: Iterable[SheetFault] = ()) -> None:
        """Raise `SheetRefused` where the sheet has faults, or there are further ones."""
        if faults := (*self.faults, *further):
            raise SheetRefused(self.file.name, faults)
        if self.cut:
            sentence = "the last line has no line end and may be cut: end it, or say `--complete` if it is whole."
            raise self.fault(self.lines[-1], None, sentence)

    def fault(self, line: int, column: str | None, sentence: str) -> SheetRefused:
        """Return the error of a single fault."""
        return SheetRefused(self.file.name, [SheetFault(line, column, sentence)])


def read_sheet(file: SheetFile, give: str = "a header that names the columns, and a row for each") -> Sheet:
    """Read a sheet under its first line; empty rows count for nothing.

    `give` says what should be given. Raises `InputRefused` for what is no sheet of several columns and rows at all.
    """
    delimiter, encoding, cut = b"", "utf-8", False
    if workbook_kind(file.data) is not None:
        rows = _rows_of_workbook(file)
    else:
        source = _source(file)
        delimiter, rows = _rows_of_text(source)
        encoding, cut = source.encoding, not file.complete and not is_ended(source)
    if not rows:
        raise InputRefused(f"{file.name} is empty: give {give}.")
    (header_line, header), *body = rows
    if isinstance(header, RowFault):
        raise InputRefused(f"line {header_line} of {file.name}: {header.sentence}")
    width = 1 + max(place for place, name in enumerate(header) if name)
    names = header[:width]
    if width < 2:
        raise InputRefused(f"{file.name} is no table of several columns: give {give}.")
    if not body:
        raise InputRefused(f"{file.name} has a header and no rows: give {give}.")
    faults = [
        SheetFault(header_line, name, f"the column {name!r} is there twice: keep one.", name)
        for place, name in enumerate(names)
        if name and name in names[:place]
    ]
    whole: list[tuple[int, tuple[str, ...]]] = []
    for line, row in body:
        cells = checked(row, names)
        if isinstance(cells, RowFault):
            faults.append(SheetFault(line, cells.column, cells.sentence))
        elif len(cells) < width:
            faults.append(SheetFault(line, None, _other_width(cells, width)))
        else:
            whole.append((line, tuple(cells[:width])))
    lines, cells_of_rows = tuple(line for line, _ in whole), tuple(cells for _, cells in whole)
    sign = delimiter.decode()
    return Sheet(file, tuple(names), cells_of_rows, lines, header_line, sign, encoding, tuple(faults), cut)


class RowFault(NamedTuple):
    """What is wrong with a row as a whole, by a rule of findings; `column` is None where it is in no one cell."""

    rule: str
    sentence: str
    column: str | None = None


Row = tuple[int, list[str] | RowFault]
"""The number of a line and its cells, or that a quote is out of place."""
_QUOTES = RowFault("quote_unbalanced", "a quote is not closed, or out of place: correct the quotes.")


def checked(row: list[str] | RowFault, names: Sequence[str]) -> list[str] | RowFault:
    """Return the cells of a row, which may be shorter than the header, or what is wrong with it."""
    if isinstance(row, RowFault):
        return row
    if any(row[len(names) :]):
        return RowFault("ragged_row", _other_width(row, len(names)))
    damaged = next((name for cell, name in zip(row, names, strict=False) if "\0" in cell), None)
    if damaged is None:
        return row
    return RowFault("nul_bytes", "the cell holds NUL bytes, as a damaged copy has: copy the file again.", damaged)


def is_ended(source: TextSource) -> bool:
    """Whether the last line of a text with anything in it has a line end, or the old mark of a file's end."""
    return source.data[-4096:].rstrip(b" \t")[-1:] in (b"\n", b"\r", b"\x1a", b"")


def text_rows(source: TextSource, delimiter: bytes, between: bytes = b"\n") -> Iterator[Row]:
    """Yield the rows of a text that have any cell, but a first line as `sep=;`.

    A cell in quotes may hold some lines, with `between` for their ends.
    """
    for number, _, content, _ in numbered_lines(source.data, source.start, delimiter, between, _MOST_QUOTED_LINES):
        if number == 1 and SEPARATOR_LINE.fullmatch(content):
            continue
        cells = split_cells(content.rstrip(b"\x1a"), delimiter) if content.strip() else []
        if cells is None:
            yield number, _QUOTES
        elif any(cells):
            yield number, [source.decode(cell).strip(_BLANKS) for cell in cells]


def head_rows(
    source: TextSource, most: int, delimiters: Iterable[bytes] = BETWEEN_CELLS, between: bytes = b"\n"
) -> Iterator[tuple[int, bytes, list[str] | RowFault]]:
    """Yield the first rows under each delimiter, `most` of each, as `text_rows` does, in the order of their lines."""

    def rows(delimiter: bytes) -> Iterator[tuple[int, bytes, list[str] | RowFault]]:
        for number, row in itertools.islice(text_rows(source.head, delimiter, between), most):
            yield number, delimiter, row

    return merge(*map(rows, delimiters), key=itemgetter(0))


_BLANKS = " \t\r\n\u00a0\u202f"
"""No others: a damaged digit may count as a blank."""


def _source(file: SheetFile) -> TextSource:
    page = file.page or DEFAULT_PAGE
    if not is_wide(page) and not is_text(file.data):
        raise InputRefused(f"{file.name} is neither text nor a workbook: save it as CSV in UTF-8, or as .xlsx.")
    source = open_text(file.data, page, FindingCollector())
    if source.encoding == "utf-8" and source.start == 0:
        return source  # has been decoded to find that out
    content = source.data[source.start :]
    try:
        content.decode(source.encoding)
    except UnicodeDecodeError as error:
        line = 1 + content.count(b"\n", 0, error.start)
        raise InputRefused(
            f"{file.name} is neither UTF-8 nor {page} text (line {line}): name its page with --encoding, or save it "
            "as CSV in UTF-8."
        ) from error
    return source


def _rows_of_workbook(file: SheetFile) -> list[Row]:
    try:
        sheets = workbook_sheets(file.data, DEFAULT_LIMITS)
    except ArchiveRefusedError as why:
        raise InputRefused(f"{file.name} is a workbook that is not read: {why}; save its sheet as CSV.") from why
    if len(sheets) > 1:
        named = ", ".join(name for name, _ in sheets)
        raise InputRefused(f"{file.name} has {len(sheets)} sheets with cells ({named}): keep one in the file.")
    rows = [[cell_text(cell).strip() for cell in row] for _, cells in sheets for row in cells]
    return [(line, row) for line, row in enumerate(rows, start=1) if any(row)]


def _rows_of_text(source: TextSource) -> tuple[bytes, list[Row]]:
    """Return the delimiter and the rows that it gives: of those under which all rows fit the header, or else of all,
    the one that gives the header most cells. A first line as `sep=;` says which it is.
    """
    first = next(iter(source.head_lines(1)), None)
    named = None if first is None else SEPARATOR_LINE.fullmatch(first.content)
    widths = {}
    for sign in BETWEEN_CELLS if named is None else (named[1],):
        header = next(text_rows(source, sign), None)
        if header is None:
            return b",", []  # nothing but delimiters
        widths[sign] = 0 if isinstance(header[1], RowFault) else len(header[1])
    widest, *others = sorted(widths, key=lambda sign: -widths[sign])
    rows = list(text_rows(source, widest))
    for sign in others if not _all_fit(rows, widths[widest]) else ():
        if widths[sign] > 1 and _all_fit(found := list(text_rows(source, sign)), widths[sign]):
            return sign, found
    return widest, rows


def _all_fit(rows: Iterable[Row], width: int) -> bool:
    return all(isinstance(cells, list) and len(cells) >= width and not any(cells[width:]) for _, cells in rows)


def _other_width(cells: Sequence[str], width: int) -> str:
    hint = "an empty cell needs its separator too."
    if any(a.isdecimal() and b.isdecimal() for a, b in itertools.pairwise(cells)):
        hint = "numbers with a decimal comma need quotes, or ; between the columns."
    return f"{len(cells)} cells where the header has {width}: {hint}"


def decimal_sign(sheet: Sheet, names: Collection[str]) -> str:
    """Return the sign with which the columns of these names write decimals; raises `UsageError` where what they write
    may be decimals or thousands.
    """
    declared = sheet.file.decimal
    if declared is not None:
        if declared not in (".", ","):
            raise UsageError(f"--decimal {declared!r} is no decimal sign: give . or ,")
        return declared
    columns = {name: [_hyphened(cell) for cell in sheet.columns[name]] for name in names}
    numbers = [cell for cells in columns.values() for cell in cells if is_number_text(cell)]
    sign, unclear = decimal_sign_of([number.encode() for number in numbers])
    signed = [number for number in numbers if "." in number or "," in number]
    by_comma = any("," in number and not may_group(number.encode()) for number in signed)
    if by_comma and all("," in number or may_group(number.encode()) for number in signed):
        return ","
    for cells in columns.values() if sheet.delimiter and not any("," in number for number in signed) else ():
        points = [cell for cell in cells if "." in cell and NUMBER.fullmatch(cell.encode())]
        # Three decimals everywhere are decimals; beside whole numbers of three digits they may be thousands.
        beside = any(map(_HUNDREDS.fullmatch, cells)) or sheet.delimiter == ";"
        if points and beside and all(may_group(cell.encode()) for cell in points):
            unclear = points[0].encode()
    if unclear is not None:
        number = unclear.decode()
        name = next(name for name, cells in columns.items() if number in cells)
        raise UsageError(
            f"{number!r} in column {name!r} of {sheet.file.name} could be a decimal or thousands: add --decimal , or "
            "--decimal ."
        )
    return sign.decode()


def number_in(cell: str, sign: str) -> float | CellFault | None:
    """Return the number in a cell, None where it is missing, or the fault; a typeset minus is one."""
    encoded = _hyphened(cell).encode("ascii", errors="replace")
    return None if is_missing(encoded.lower()) else parse_cell(encoded, sign.encode())


def lone_number(cell: str) -> float | None:
    """Return the number in a cell that stands for itself, with a point or a comma; None where it is none, or `1,200`,
    which may be two.
    """
    number = number_in(cell, "," if "," in cell and not may_group(cell.encode()) else ".")
    return None if isinstance(number, CellFault) else number


def numbers_of(
    sheet: Sheet, name: str, option: str, sign: str, places_asked: Sequence[int] | None = None
) -> list[float | None]:
    """Return a column's numbers in the rows at `places_asked` (all without it), None where a cell is empty or marks a
    missing value. `sign` is that of `decimal_sign`.

    Raises `SheetRefused` with each cell that is neither, or is infinite.
    """
    cells = sheet.cells(name, option)
    found: list[float | None] = []
    faults = []
    for place in range(len(cells)) if places_asked is None else places_asked:
        number = number_in(cells[place], sign)
        if isinstance(number, CellFault):
            sentence = f"{cells[place]!r} {_remedy(cells[place], sign, name)}."
            faults.append(SheetFault(sheet.lines[place], name, sentence, cells[place]))
        else:
            found.append(number)
    if faults:
        raise SheetRefused(sheet.file.name, faults)
    return found


def _remedy(cell: str, sign: str, name: str) -> str:
    """Say what to do with a cell that is no number: separators of thousands, a unit, or anything else."""
    plain = _hyphened(cell)
    with_unit = _WITH_UNIT.fullmatch(plain)
    if with_unit and not is_number_text(cell):
        number, unit = with_unit.groups()
        return (
            f"is a number and more: write {number} alone, and where {unit!r} is a unit, name the column as in "
            f"{f'{name} ({unit})'!r}"
        )
    if is_grouped(plain.encode("ascii", errors="replace")):
        return f"holds a separator of thousands: write it without, as 1234{sign}5"
    return f"is no number that can be used: write it as 12{sign}5, or leave it empty where it is missing"


def is_number_text(cell: str) -> bool:
    """Whether a cell is a number, with a point or a comma."""
    encoded = _hyphened(cell).encode()
    return bool(NUMBER.fullmatch(encoded) or COMMA_NUMBER.fullmatch(encoded))


def is_blank(cell: str) -> bool:
    """Whether a cell is empty, or one of the marks of a missing value."""
    return is_missing(_hyphened(cell).encode("ascii", errors="replace").lower())


def _hyphened(cell: str) -> str:
    return cell.replace(MINUS, "-")
