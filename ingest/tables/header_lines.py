"""The lines above the data of a table: the names of the columns, and a row of units."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from ingest.findings import FILE, FindingCollector
from ingest.model import Declarations
from ingest.tables.header_cells import is_unit
from ingest.text.cells import COMMENT_STARTS, is_number
from ingest.text.delimiters import Row, Split, row_of
from ingest.text.source import Line


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
        if row.data_like and len(row.cells) == split.width:
            break
        row = _without_doubled(row, split)
        if _fits(row, split) and any(row.cells) and not any(is_number(cell, comma=True) for cell in row.cells):
            above.append(row)
    if not above:
        return HeaderLines(None, None, _has_trailing(split, None))
    nearest_first = above[::-1] if split.width == 1 else above
    names = max(nearest_first, key=_looks_like_names)
    below = [row for row in above if row.line.start > names.line.start]
    units = next((row for row in below if _is_units_row(row.cells)), None)
    return HeaderLines(names, units, _has_trailing(split, names))


def _without_doubled(row: Row, split: Split) -> Row:
    """Return a line with doubled delimiters, which align names by eye, as one of as many cells as the rows have."""
    filled = [cell for cell in row.cells if cell]
    doubled = len(filled) == split.width < len(row.cells) and row.cells[0] and row.cells[-1]
    return dataclasses.replace(row, cells=filled) if doubled else row


def declared_header(above: Sequence[Line], split: Split, declared: Declarations) -> HeaderLines:
    """Return names and units from the lines that are declared to stand above the data."""
    rows = [_without_doubled(row_of(line, split.delimiter), split) for line in above]
    by_number = {row.line.number: row for row in rows}
    names = by_number.get(declared.header_row or 0)
    units = by_number.get(declared.units_row or 0)
    if declared.header_row is None:
        head = (*(row for row in rows if not row.data_like), *split.head)
        found = find_header(dataclasses.replace(split, head=head))
        names, units = found.names, units or found.units
    return HeaderLines(names, units, _has_trailing(split, names))


def _looks_like_names(row: Row) -> tuple[int, bool, bool]:
    comment = row.line.content.startswith(COMMENT_STARTS)
    return len(set(row.cells)), not comment, not _is_units_row(row.cells)


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


def report_other_width(header: Row, width: int, findings: FindingCollector) -> None:
    """Report that the line declared as header has more or fewer cells than the rows."""
    message = f"Line {header.line.number}, declared as the header, has {len(header.cells)} cells and the rows have "
    message += (
        f"{width}: correct `header_row` or `delimiter`, or say `header_row = 0` and name columns by their number."
    )
    findings.add(FILE, "header_mismatch", message, lines=[header.line.number])


def report_no_header(split: Split, findings: FindingCollector) -> None:
    """Report why no line names the columns: there is none, or it has another number of cells than the rows."""
    first_data = next((row.line.start for row in split.head if row.data_like), 0)
    above = (row for row in split.head if row.line.start < first_data)
    named = [row for row in above if len(row.cells) > 1 and row.share == 0.0]
    if not named:
        message = "The columns have no names: name each by its number, for example `--column 1=force_z:N`."
        findings.add(FILE, "header_missing", message)
        return
    names, width = len(named[-1].cells), split.width
    counted = f"The header names {names} columns and the rows have {width} cells: "
    if split.delimiter == b"," and names < width <= 2 * names:
        rule, advice = (
            "decimal_comma_unquoted",
            "a decimal comma is also the separator; export with semicolons between cells.",
        )
    else:
        rule, advice = "header_mismatch", "export again so that they agree."
    findings.add(FILE, rule, counted + advice, lines=[named[-1].line.number])
