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

from data_schema.errors import InputRefused, unknown_name
from ingest.text.cells import CellFault
from labbook.actions.stats.cells import decimal_sign, number_in, what_to_write

DELIMITERS = (",", ";", "\t", "|")
_SEPARATOR_LINE = re.compile(r'"?sep=([,;\t|])"?', re.IGNORECASE)
_EXAMPLE = "a header such as controller,energy_J and one value a row"


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


def read_table(text: str, file: str) -> LongTable:
    """Read delimited text; raises `InputRefused` for rows of different width, names that repeat, or no rows.

    A first line such as `sep=;`, which Excel writes, names the delimiter. Columns without a name cannot be asked for
    and are left out.
    """
    if "\0" in text:
        raise InputRefused(f"{file} holds bytes that no text has: save it as CSV in UTF-8 and try again.")
    first, _end, rest = text.partition("\n")
    named = _SEPARATOR_LINE.fullmatch(first.strip())
    delimiters, text = (named[1], f"\n{rest}") if named else (DELIMITERS, text)
    read = {delimiter: _rows(text, delimiter) for delimiter in delimiters}
    even = {
        delimiter: rows
        for delimiter, rows in read.items()
        if rows and len(rows[0][1]) > 1 and len({len(cells) for _line, cells in rows}) == 1
    }
    if not even:
        raise InputRefused(_why_uneven(max(read.values(), key=lambda rows: len(rows[0][1]) if rows else 0), file))
    delimiter, ((_line, header), *rows) = max(even.items(), key=lambda found: len(found[1][0][1]))
    repeated = sorted({name for name in header if name and header.count(name) > 1})
    if repeated:
        raise InputRefused(f"{file} has several columns named {repeated[0]!r}: give each a name of its own.")
    if not rows:
        raise InputRefused(f"{file} has a header and no rows: give {_EXAMPLE}.")
    columns = {name: tuple(cells[place] for _number, cells in rows) for place, name in enumerate(header) if name}
    return LongTable(file, columns, tuple(number for number, _cells in rows), delimiter)


def _rows(text: str, delimiter: str) -> list[tuple[int, list[str]]]:
    reader = csv.reader(text.splitlines(keepends=True), delimiter=delimiter, skipinitialspace=True)
    return [
        (reader.line_num, [cell.strip() for cell in cells]) for cells in reader if any(cell.strip() for cell in cells)
    ]


def _why_uneven(rows: Sequence[tuple[int, Sequence[str]]], file: str) -> str:
    if not rows or len(rows[0][1]) < 2:
        return f"{file} is no table of several columns: give {_EXAMPLE}."
    width = len(rows[0][1])
    line, cells = next((line, cells) for line, cells in rows if len(cells) != width)
    hint = ""
    if any(a.isdecimal() and b.isdecimal() for a, b in itertools.pairwise(cells)):
        hint = "; numbers with a decimal comma need quotes, or ; between the columns"
    return (
        f"line {line} of {file} has {len(cells)} cells and the header {width}: give every row as many cells as "
        f"names{hint}."
    )


def numbers_of(
    table: LongTable, name: str, option: str, declared: str | None = None, kept: Sequence[int] | None = None
) -> list[Decimal | None]:
    """Return a column's numbers in the rows `kept` (places, all without it), None where a cell is empty or says that a
    value is missing.

    Raises `InputRefused`, with the line, for a cell that is neither, or is infinite.
    """
    cells = table.cells(name, option)
    places = range(len(cells)) if kept is None else kept
    sign = decimal_sign([cells[place] for place in places], name, declared)
    found: list[Decimal | None] = []
    for place in places:
        number = number_in(cells[place], sign, declared)
        if isinstance(number, CellFault):
            raise InputRefused(
                f"{cells[place]!r} in column {name!r}, line {table.lines[place]} of {table.file}, "
                f"{what_to_write(cells[place], sign, name)}."
            )
        found.append(number)
    return found
