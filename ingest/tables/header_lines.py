"""The lines above the data of a table, the names of its columns and a row of units."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile

from ingest.channels.names import TIME_NAMES, channel_of, is_unit, parse_header, squash, strip_comment
from ingest.findings import FILE, FindingCollector
from ingest.model import Declarations
from ingest.text.cells import (
    COMMENT_STARTS,
    Row,
    Split,
    debug_line,
    is_clock,
    is_number,
    is_single_number,
    row_of,
)
from ingest.text.source import Line

_UNIT_ALONE = re.compile(rb"[\[(][^\])]*[\])]")


@dataclass(frozen=True, slots=True)
class HeaderLines:
    """The line of names and the row of units, where there are any; `trailing` when every row ends in a delimiter."""

    names: Row | None
    units: Row | None
    trailing: bool


def find_header(split: Split) -> HeaderLines:
    """Find names and units above the data.

    Among the lines that have as many cells as the data and no number, the names are those that differ most among
    themselves (a line of run titles repeats one word); of one column, the line next to the data that is no comment.
    """
    above: list[Row] = []
    for row in split.head:
        if _is_row(row, split):
            break
        row = _whole_row(row, split)
        if is_single_number(debug_line(row.line.content)):
            continue  # `Duration: 2,5 s` is a fact about the file
        if _fits(row, split) and any(row.cells) and not any(is_number(cell, comma=True) for cell in row.cells):
            above.append(row)
    if not above:
        return HeaderLines(None, None, _has_trailing(split, None))
    nearest_first = above[::-1] if split.width == 1 else above
    names = max(nearest_first, key=_looks_like_names)
    below = [row for row in above if row.line.start > names.line.start]
    units = next((row for row in below if _is_units_row(row.cells)), None)
    return HeaderLines(names, units, _has_trailing(split, names))


def parts_names(split: Split) -> bool:
    """Whether a line above the data names as many columns as the rows have cells, or half as many."""
    names = find_header(split).names
    if names is not None and any(_is_name(cell.decode("latin-1")) for cell in names.cells):
        return True
    above = takewhile(lambda row: not _is_row(row, split), split.head)
    counts = [sum(map(bool, row.cells)) for row in above if _has_names(row)]
    return any(count < split.width <= 2 * count + 1 for count in counts)


def with_units_joined(cells: list[bytes], width: int) -> list[bytes]:
    """Return the cells of a header between blanks, `time [s] height [m]`, with each unit in the cell of its name.

    A cell without a unit may be the first word of a name, `body height [m]`: it counts as a name of its own only
    where it is known. Else a name is all that stands before its unit, where that makes `width` cells.
    """
    if len(cells) <= width or not any(map(_UNIT_ALONE.fullmatch, cells)):
        return cells
    pairs: list[bytes] = []
    names: list[list[bytes]] = [[]]
    for cell in cells:
        unit = _UNIT_ALONE.fullmatch(cell) is not None
        if unit and pairs:
            pairs[-1] += b" " + cell
        else:
            pairs.append(cell)
        names[-1].append(cell)
        if unit:
            names.append([])
    whole = [b" ".join(name) for name in names if name]
    possible = [pairs, whole] if all(_is_name(name.decode("latin-1")) for name in pairs) else [whole]
    return next((joined for joined in possible if len(joined) == width), cells)


def _whole_row(row: Row, split: Split) -> Row:
    """Return a line above the data as one of as many cells as the rows have, where blanks or doubled delimiters, which
    align names by eye, part it into more.
    """
    if split.delimiter == b" ":
        return dataclasses.replace(row, cells=with_units_joined(row.cells, split.width))
    filled = [cell for cell in row.cells if cell]
    doubled = len(filled) == split.width < len(row.cells) and row.cells[0] and row.cells[-1]
    return dataclasses.replace(row, cells=filled) if doubled else row


def declared_header(above: Sequence[Line], split: Split, declared: Declarations) -> HeaderLines:
    """Return names and units from the lines that are declared to stand above the data."""
    rows = [_whole_row(row_of(line, split.delimiter), split) for line in above]
    by_number = {row.line.number: row for row in rows}
    names = by_number.get(declared.header_row or 0)
    units = by_number.get(declared.units_row or 0)
    if declared.header_row is None:
        head = (*(row for row in rows if not row.data_like), *split.head)
        found = find_header(dataclasses.replace(split, head=head))
        names, units = found.names, units or found.units
    return HeaderLines(names, units, _has_trailing(split, names))


def _looks_like_names(row: Row) -> tuple[int, int, bool, bool]:
    comment = row.line.content.startswith(COMMENT_STARTS)
    texts = [cell.decode("latin-1") for cell in row.cells if cell]
    return len(set(texts)), sum(map(_is_name, texts)), not comment, not _is_units_row(row.cells)


def _is_name(text: str) -> bool:
    """Whether a cell is a name with a unit, or one that is known."""
    cell = parse_header(strip_comment(text))
    known = squash(cell.base) in TIME_NAMES or channel_of(cell.base) is not None
    return bool(cell.base) and (cell.unit is not None or known)


def _is_row(row: Row, split: Split) -> bool:
    return row.data_like and len(row.cells) == split.width


def _has_names(row: Row) -> bool:
    """Whether a line holds words and no number or time."""
    filled = [cell for cell in row.cells if cell]
    return len(filled) > 1 and not any(is_number(cell, comma=True) or is_clock(cell) for cell in filled)


def _fits(row: Row, split: Split) -> bool:
    """Whether a line has a cell for every column; either it or the rows may end in one delimiter more."""
    cells, width = row.cells, split.width
    longer = len(cells) == width + 1 and not cells[-1]
    shorter = len(cells) == width - 1 and all(not data.cells[-1] for data in split.rows)
    return len(cells) == width or longer or shorter


def _is_units_row(cells: Sequence[bytes]) -> bool:
    texts = [cell.decode("latin-1") for cell in cells if cell]
    return sum(is_unit(text) for text in texts) * 2 >= len(texts)


def _has_trailing(split: Split, names: Row | None) -> bool:
    unnamed = names is None or len(names.cells) < split.width or not names.cells[-1]
    return split.width > 1 and unnamed and all(not row.cells[-1] for row in split.rows)


def report_other_width(header: Row, width: int, split: Split, findings: FindingCollector) -> None:
    """Report that the line that names the columns has more or fewer cells than the rows."""
    first = next((row.line.number for row in split.head if _is_row(row, split)), header.line.number + 1)
    message = (
        f"The header in line {header.line.number} has {len(header.cells)} cells and the rows have {width}: correct "
        "`header_row` or `delimiter` in a [profiles.NAME] table of labbook.toml, or say `header_row = 0` and "
        f"`first_row = {first}` there, and name the columns by their number, for example `--column 1=CHANNEL:UNIT`."
    )
    findings.add(FILE, "header_mismatch", message, lines=[header.line.number])


def report_no_header(split: Split, findings: FindingCollector) -> None:
    """Report why no line names the columns: there is none, or it has another number of cells than the rows."""
    first_data = next((row.line.start for row in split.head if _is_row(row, split)), 0)
    named = [row for row in split.head if row.line.start < first_data and len(row.cells) > 1 and _has_names(row)]
    if not named:
        message = "The columns have no names: name each by its number, for example `--column 1=CHANNEL:UNIT`"
        below = next((row for row in split.head if len(row.cells) == split.width > 1 and _has_names(row)), None)
        if below is not None:
            message += (
                f", or, if line {below.line.number} names them, say `header_row = {below.line.number}` in a "
                "[profiles.NAME] table of labbook.toml"
            )
        findings.add(FILE, "header_missing", f"{message}.")
        return
    header, width = named[-1], split.width
    blank_end = header.cells[-1:] == [b""] and all(not row.cells[-1] for row in split.rows)
    names, numbers = len(header.cells) - blank_end, width - blank_end
    if split.delimiter != b"," or not names < numbers <= 2 * names:
        report_other_width(header, width, split, findings)
        return
    counted = f"The header names {names} columns and the rows have {numbers} cells: a comma stands between cells and "
    if any(b"." in cell and is_number(cell, comma=False) for row in split.rows for cell in row.cells):
        rule, advice = "thousands_separator", "between thousands; export without thousands separators."
    elif numbers == 2 * names:
        rule = "decimal_comma_unquoted"
        advice = "in each number; say so with `--decimal , --delimiter ,`, or export with semicolons between cells."
    else:
        rule, advice = (
            "decimal_comma_unquoted",
            "in some numbers, and which cannot be told; export with semicolons between cells.",
        )
    findings.add(FILE, rule, counted + advice, lines=[header.line.number])
