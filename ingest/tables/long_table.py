"""A table in long format, one value a row, as text with a header: its columns by name, its numbers as they are written.

Numbers stay decimals: 0.1 is a tenth, and an offset of 1e12 costs no digit.
"""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal

from data_schema.errors import InputRefused, UsageError, unknown_name
from ingest.text.cells import COMMA_NUMBER, NUMBER, CellFault, is_grouped, is_missing, may_group, parse_cell

MINUS = "\N{MINUS SIGN}"
"""The typeset minus, which word processors write in place of the hyphen."""
_POINT_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+(,\d*)?")
_HUNDREDS = re.compile(r"[+-]?[1-9]\d\d")
_WITH_UNIT = re.compile(r"([+-]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?)\s*([^\W\d_]\S*|[%°]\S*)")
DELIMITERS = (",", ";", "\t", "|")
_SEPARATOR_LINE = re.compile(r'"?sep=([,;\t|])"?', re.IGNORECASE)
_EXAMPLE = "a header such as controller,energy_J and one value a row"


class LineRefused(InputRefused):
    """A line of a table cannot be used; `line` is its number in the file, from 1."""

    def __init__(self, line: int, sentence: str) -> None:
        """Take the sentence, which names the line too."""
        super().__init__(sentence)
        self.line = line


@dataclass(frozen=True, slots=True)
class LongTable:
    """Cells by column, stripped, one a row; `lines` are the rows' lines in the file, from 1.

    `delimiter` stands between its columns.
    """

    file: str
    columns: Mapping[str, tuple[str, ...]]
    lines: tuple[int, ...]
    delimiter: str = ","

    def cells(self, name: str, option: str) -> tuple[str, ...]:
        """Return a column; raises `UnknownName` with the nearest name that there is."""
        if name not in self.columns:
            raise unknown_name(f"column of {self.file} (for {option})", name, self.columns)
        return self.columns[name]


def read_table(text: str, file: str, example: str = _EXAMPLE) -> LongTable:
    """Read delimited text; raises `InputRefused` for rows of different width, names that repeat, or no rows.

    A first line such as `sep=;`, which Excel writes, names the delimiter. Columns without a name cannot be asked for
    and are left out.
    """
    if "\0" in text:
        raise InputRefused(f"{file} holds bytes that no text has: save it as CSV in UTF-8 and try again.")
    first, _end, rest = text.partition("\n")
    named = _SEPARATOR_LINE.fullmatch(first.strip())
    delimiters, text = (named[1], f"\n{rest}") if named else (DELIMITERS, text)
    try:
        read = {delimiter: _rows(text, delimiter) for delimiter in delimiters}
    except csv.Error as error:  # a cell beyond what the module takes
        raise InputRefused(f"{file} is no table of cells ({error}): give {example}.") from error
    even = {
        delimiter: rows
        for delimiter, rows in read.items()
        if rows and len(rows[0][1]) > 1 and len({len(cells) for _line, cells in rows}) == 1
    }
    if not even:
        longest = max(read.values(), key=lambda rows: len(rows[0][1]) if rows else 0)
        raise _uneven(longest, file, example)
    delimiter, ((_line, header), *rows) = max(even.items(), key=lambda found: len(found[1][0][1]))
    repeated = sorted({name for name in header if name and header.count(name) > 1})
    if repeated:
        raise InputRefused(f"{file} has several columns named {repeated[0]!r}: give each a name of its own.")
    if not rows:
        raise InputRefused(f"{file} has a header and no rows: give {example}.")
    columns = {name: tuple(cells[place] for _number, cells in rows) for place, name in enumerate(header) if name}
    return LongTable(file, columns, tuple(number for number, _cells in rows), delimiter)


def _rows(text: str, delimiter: str) -> list[tuple[int, list[str]]]:
    reader = csv.reader(text.splitlines(keepends=True), delimiter=delimiter, skipinitialspace=True)
    return [
        (reader.line_num, [cell.strip() for cell in cells]) for cells in reader if any(cell.strip() for cell in cells)
    ]


def _uneven(rows: Sequence[tuple[int, Sequence[str]]], file: str, example: str) -> InputRefused:
    if not rows or len(rows[0][1]) < 2:
        return InputRefused(f"{file} is no table of several columns: give {example}.")
    width = len(rows[0][1])
    line, cells = next((line, cells) for line, cells in rows if len(cells) != width)
    hint = ""
    if any(a.isdecimal() and b.isdecimal() for a, b in itertools.pairwise(cells)):
        hint = "; numbers with a decimal comma need quotes, or ; between the columns"
    return LineRefused(
        line,
        f"line {line} of {file} has {len(cells)} cells and the header {width}: give every row as many cells as "
        f"names{hint}.",
    )


def numbers_of(
    table: LongTable, name: str, option: str, declared: str | None = None, places_asked: Sequence[int] | None = None
) -> list[Decimal | None]:
    """Return a column's numbers in the rows at `places_asked` (all without it), None where a cell is empty or marks a
    missing value.

    Raises `InputRefused`, with the line, for a cell that is neither, or is infinite.
    """
    cells = table.cells(name, option)
    places = range(len(cells)) if places_asked is None else places_asked
    sign = decimal_sign([cells[place] for place in places], name, declared)
    found: list[Decimal | None] = []
    for place in places:
        number = number_in(cells[place], sign, declared)
        if isinstance(number, CellFault):
            raise LineRefused(
                table.lines[place],
                f"{cells[place]!r} in column {name!r}, line {table.lines[place]} of {table.file}, "
                f"{cell_remedy(cells[place], sign, name)}.",
            )
        found.append(number)
    return found


def decimal_sign(cells: Sequence[str], name: str, declared: str | None) -> str:
    """Return the sign that the numbers of a column have; raises `UsageError` where it could be thousands."""
    if declared is not None:
        if declared not in (".", ","):
            raise UsageError(f"--decimal {declared!r} is no decimal sign: give . or ,")
        return declared
    plain = [_hyphened(cell) for cell in cells]
    with_comma = [cell for cell in plain if COMMA_NUMBER.fullmatch(cell.encode())]
    with_point = [cell for cell in plain if "." in cell]
    unclear = with_comma if with_comma and all(may_group(cell.encode()) for cell in with_comma) else []
    # Three decimals everywhere are decimals; beside whole numbers of three digits they may be thousands.
    if not with_comma and with_point and all(map(_POINT_THOUSANDS.fullmatch, with_point)):
        unclear = with_point if any(map(_HUNDREDS.fullmatch, plain)) else []
    if unclear:
        raise UsageError(
            f"{unclear[0]!r} in column {name!r} could be a decimal or thousands: add --decimal , or --decimal ."
        )
    return "," if with_comma else "."


def number_in(cell: str, sign: str, declared: str | None) -> Decimal | CellFault | None:
    """Return the number in a cell, None where it is missing, or the fault.

    A typeset minus is one. Where `--decimal ,` was given, points before groups of three digits are thousands.
    """
    plain = _hyphened(cell)
    if has_thousands(cell, declared):
        plain = plain.replace(".", "")
    encoded = plain.encode("ascii", errors="replace")
    if is_missing(encoded.lower()):
        return None
    parsed = parse_cell(encoded, sign.encode())
    if isinstance(parsed, CellFault):
        return parsed
    return Decimal(plain.replace(",", ".").lower().replace("d", "e"))


def has_thousands(cell: str, declared: str | None) -> bool:
    """Whether the points of a cell are thousands, as they can only be where `--decimal ,` was given."""
    return declared == "," and bool(_POINT_THOUSANDS.fullmatch(_hyphened(cell)))


def maybe_thousands(cells: Sequence[str], delimiter: str, declared: str | None) -> str | None:
    """Return a number whose point is read as a decimal and could mark thousands, None where there is none.

    So it is where nothing was declared, all points stand before exactly three digits, and semicolons between the
    columns leave open whether the decimal sign is a comma.
    """
    with_point = [plain for plain in map(_hyphened, cells) if "." in plain and is_number_text(plain)]
    unclear = declared is None and delimiter == ";" and all(may_group(cell.encode()) for cell in with_point)
    return with_point[0] if unclear and with_point and not any("," in cell for cell in cells) else None


def cell_remedy(cell: str, sign: str, name: str) -> str:
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
        how = "add --decimal , where its points are thousands, or " if _POINT_THOUSANDS.fullmatch(plain) else ""
        return f"holds a separator of thousands: {how if sign == '.' else ''}write it without, as 1234{sign}5"
    return f"is no number that can be used: write it as 12{sign}5, or leave it empty where it is missing"


def column_for_where(cells: Sequence[str], name: str = "", declared: str | None = None) -> list[str | Decimal | None]:
    """Return a column as `--where` compares it: numbers where all that is filled in are numbers.

    Raises `UsageError` where their commas could be decimals or thousands.
    """
    filled = [cell for cell in cells if not _lacks(cell)]
    if not filled or not all(is_number_text(cell) or has_thousands(cell, declared) for cell in filled):
        return [cell or None for cell in cells]
    sign = decimal_sign(filled, name, declared)
    found = [number_in(cell, sign, declared) for cell in cells]
    numbers = [None if isinstance(number, CellFault) else number for number in found]
    return [cell or None for cell in cells] if any(isinstance(one, CellFault) for one in found) else [*numbers]


def _hyphened(cell: str) -> str:
    return cell.replace(MINUS, "-")


def _lacks(cell: str) -> bool:
    return is_missing(_hyphened(cell).encode("ascii", errors="replace").lower())


def is_number_text(cell: str) -> bool:
    """Whether a cell is a number, with a point or a comma."""
    encoded = _hyphened(cell).encode()
    return bool(NUMBER.fullmatch(encoded) or COMMA_NUMBER.fullmatch(encoded))
