"""How a delimited text is laid out: preamble, header, units row, where the data start, kinds of columns, decimal sign.

Header and data are decided apart: some instruments write a decimal comma above and a decimal point below. What follows
another header inside the data is another table, with columns of its own.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, pairwise, takewhile

import numpy as np

from ingest.channels.names import TIME_NAMES, channel_of, is_unit, parse_header, squash, strip_comment
from ingest.model import FILE, NOTE, Declarations, FindingCollector, TextShape
from ingest.spool import row_blocks
from ingest.tables.table import Block, CellKind, Column
from ingest.text import (
    COMMA_NUMBER,
    COMMENT_STARTS,
    NUMBER,
    ONE_COLUMN,
    Line,
    Row,
    Split,
    TextSource,
    best_split,
    debug_line,
    decimal_sign_of,
    integer_of,
    is_clock,
    is_clock_like,
    is_grouped,
    is_infinite,
    is_missing,
    is_number,
    is_single_number,
    may_group,
    row_of,
    too_wide,
)

_RULE = b" \t\r\v\f-=_+|*"
_LONG = 10**15
"""Of integers from here on float64 loses digits, at the latest when they are divided by ticks per second."""


@dataclass(frozen=True, slots=True)
class Layout:
    """The shape of one table in a text. Without a header the names are the columns' numbers, from 1.

    `trailing` is how many cells, all blank, the rows have behind the last column; `complete`: a last line without line
    end is whole where it has all cells; `fixed`: a maker's program wrote the table, with as many decimals in all rows.
    """

    delimiter: bytes
    decimal: bytes
    width: int
    trailing: int
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    kinds: tuple[CellKind, ...]
    data_start: int
    data_line: int
    last_cells: tuple[bytes, ...]
    preamble: tuple[str, ...] = ()
    header_cells: tuple[bytes, ...] = ()
    units_cells: tuple[bytes, ...] = ()
    header_line: int | None = None
    units_line: int | None = None
    complete: bool = False
    fixed: bool = False

    @property
    def shape(self) -> TextShape:
        """What a person sees of the layout."""
        delimiter = "" if self.delimiter == ONE_COLUMN else self.delimiter.decode("latin-1")
        return TextShape(delimiter, self.decimal.decode(), self.header_line, self.units_line, self.data_line)

    def is_debug(self, content: bytes) -> bool:
        """Whether a line is `name: value`, a program's debug output, among rows that begin with a number or a time.

        A line of words alone, as many as there are columns, may be a header and is none.
        """
        if self.width == 1 or self.kinds[0] is CellKind.TEXT or debug_line(content) is None:
            return False
        return content.count(self.delimiter) + 1 != self.width or any(byte in b"0123456789" for byte in content)


def find_layout(source: TextSource, declared: Declarations, findings: FindingCollector) -> Layout | None:
    """Return the layout of the table in `source`, or None, with a finding of severity file, when there is none."""
    head = source.head_lines()
    further = [*source.sample_lines(0.5), *source.sample_lines(0.95)]
    declared_above, below = _parted(head, declared)
    split = _likely_split(below, further, declared)
    if split is None:
        findings.add(
            FILE,
            "no_data_rows",
            "No line is a row of numbers, of `name: value` or a JSON object: export one sample a line, under a header.",
        )
        return None
    if too_wide(split.width, declared, findings):
        return None
    if declared_above or declared.header_row is not None:
        above_data = declared_header(declared_above, split, declared)
    else:
        above_data = find_header(split)
    header, units_row = above_data.names, above_data.units
    width = split.width - above_data.trailing
    if header is not None and declared.header_row is not None:
        blank_end = header.cells[-1:] == [b""] and len(header.cells) > 1
        if len(header.cells) != width + blank_end:
            report_other_width(header, width, split, findings)
            return None
    if not declared.header_row and _refuse_parted_decimals(split, declared, findings):
        return None
    named = {**declared.profile_columns, **declared.columns}
    if header is None and not any(name.isdigit() for name in named):
        report_no_header(split, findings)
        if "header_missing" not in findings:
            return None
    first = _first_data_line(split, header, units_row)
    above = [line for line in head if line.start < first.start]
    names = tuple(str(number + 1) for number in range(width))
    if header is not None:
        names = tuple(strip_comment(source.decode(cell)) for cell in header.cells[:width])
    units: tuple[str | None, ...] = (None,) * width
    if units_row is not None:
        units = (*(source.decode(cell) or None for cell in units_row.cells[:width]), *units)[:width]
    rows = [row.cells for row in split.rows]
    return Layout(
        split.delimiter,
        decimal_sign(rows, split.delimiter, declared, findings),
        width,
        int(above_data.trailing),
        names,
        units,
        tuple(kind_of([cells[column] for cells in rows]) for column in range(width)),
        first.start,
        first.number,
        tuple(row.cells[-1] for row in split.rows if row.line.ended),
        tuple(source.decode(line.content) for line in above if header is None or line.start != header.line.start),
        () if header is None else tuple(header.cells),
        () if units_row is None else tuple(units_row.cells),
        None if header is None else header.line.number,
        None if units_row is None else units_row.line.number,
        bool(declared.complete),
    )


def _parted(head: list[Line], declared: Declarations) -> tuple[list[Line], list[Line]]:
    """Part the first lines where declared line numbers put the data below; nothing is above where none is declared."""
    first = max(declared.first_row or 0, (declared.header_row or 0) + 1, (declared.units_row or 0) + 1)
    return [line for line in head if line.number < first], [line for line in head if line.number >= first]


def _likely_split(head: list[Line], further: list[Line], declared: Declarations) -> Split | None:
    """Return the sample under the declared delimiter, else under the most likely one.

    A comma that is declared to be the decimal sign stands between cells only where they are in quotes, or where a
    header names as many columns, or half as many: that each number has a comma, too, is then asked about.
    """
    if declared.delimiter is not None:
        return best_split(head, further, declared.delimiter.encode("latin-1"))
    split = best_split(head, further)
    if declared.decimal_sign != "," or split is None or split.delimiter != b",":
        return split
    if any(b'"' in row.line.content for row in split.rows) or parts_names(split):
        return split
    return best_split(head, further, ONE_COLUMN)


_DIGITS = re.compile(rb"\d{2,}")
_FIRST_ROWS = 256


def _refuse_parted_decimals(split: Split, declared: Declarations, findings: FindingCollector) -> bool:
    """Refuse columns without names that may be the two parts of decimals, `0,021`: the right one of as many digits in
    every row, with zeros in front.
    """
    signs = (declared.delimiter, declared.decimal_sign)
    if (any(signs) and signs != (",", ",")) or split.delimiter != b"," or parts_names(split):
        return False
    for left, right in pairwise(range(split.width)):
        parts = [row.cells[right] for row in split.rows]
        whole = all(integer_of(row.cells[left]) is not None for row in split.rows)
        digits = all(map(_DIGITS.fullmatch, parts)) and len(set(map(len, parts))) == 1
        if whole and digits and any(part.startswith(b"0") for part in parts):
            row = split.rows[0]
            number = b",".join(row.cells[left : right + 1]).decode("latin-1")
            way = "export with semicolons" if any(signs) else "say `--decimal ,` for one, `--delimiter ,` for two"
            message = f"{number!r} may be one number with a decimal comma, or two: {way}."
            findings.add(FILE, "decimal_comma_unquoted", message, lines=[row.line.number], value=number)
            return True
    return False


def _first_data_line(split: Split, header: Row | None, units_row: Row | None) -> Line:
    """Return the first line after header and units that is neither blank nor a comment nor a rule of dashes."""
    after = -1
    if header is not None:
        after = (units_row or header).line.start
    for row in split.head:
        content = row.line.content
        comment = content.startswith(COMMENT_STARTS) and not row.data_like
        if row.line.start > after and content.strip(_RULE) and not comment and (header is not None or row.data_like):
            return row.line
    return split.rows[0].line


def kind_of(cells: Sequence[bytes]) -> CellKind:
    """Return what the cells of one column hold, judged on a sample of them."""
    filled = [cell for cell in cells if not is_missing(cell.lower())]
    if not filled:
        return CellKind.EMPTY
    filled = [cell for cell in filled if not is_infinite(cell.lower())] or filled
    whole = [number for cell in filled if (number := integer_of(cell)) is not None]
    if len(whole) == len(filled) and 2 * sum(abs(number) >= _LONG for number in whole) >= len(whole):
        return CellKind.INTEGER
    if sum(is_number(cell, comma=True) or is_grouped(cell) for cell in filled) * 2 >= len(filled):
        return CellKind.NUMBER
    return CellKind.CLOCK if sum(map(is_clock_like, filled)) * 2 >= len(filled) else CellKind.TEXT


def decimal_sign(
    rows: Sequence[Sequence[bytes]], delimiter: bytes, declared: Declarations, findings: FindingCollector
) -> bytes:
    """Return the decimal sign of rows of cells; one that may as well group thousands refuses the file."""
    if declared.decimal_sign is not None:
        return declared.decimal_sign.encode()
    cells = [cell for row in rows for cell in row]
    sign, unclear = decimal_sign_of(cells)
    points = [cell for cell in cells if b"." in cell and NUMBER.fullmatch(cell)]
    commas = any(COMMA_NUMBER.fullmatch(cell) for cell in cells)
    if unclear is not None:
        _refuse_unclear(unclear.decode(), findings)
    elif sign == b",":
        findings.add(NOTE, "decimal_comma", "Numbers are written with a decimal comma; read as such.")
    elif delimiter == b";" and points and not commas and all(map(may_group, points)):
        _note_points(points[0].decode(), findings)
    return sign


def _refuse_unclear(number: str, findings: FindingCollector) -> None:
    """Refuse a file for a number whose decimal sign may as well group thousands."""
    sign = "," if "," in number else "."
    message = (
        f"{number!r} may be a decimal or a thousand: say `--decimal {sign}` if it is a decimal, else export without "
        "thousands separators."
    )
    findings.add(FILE, "decimal_sign_unclear", message, value=number)


def refuse_jumps_by_thousand(
    block: Block, shape: TextShape, declared: Declarations, findings: FindingCollector
) -> None:
    """Refuse columns of three decimals or fewer that jump between whole numbers below 1000 and a hundredth of them or
    less: `999` to `1.002`.

    A program that writes three decimals writes them of every number, one that groups thousands leaves 999 bare.
    """
    if declared.decimal_sign is not None or "decimal_sign_unclear" in findings:
        return
    for column in block.numbers.values():
        number = _grouped(column)
        if number is not None:
            _refuse_unclear(f"{number:.3f}".replace(".", shape.decimal), findings)
            return


def _grouped(column: Column) -> float | None:
    """Return a number of a column, shape (n_rows,), that groups thousands; None where it is one of decimals."""
    least, jumps = np.inf, False
    # The first rows show of most columns that they hold decimals.
    for rows in chain((slice(0, _FIRST_ROWS),), row_blocks(column)):
        values = np.abs(column[rows])
        values = values[np.isfinite(values)]
        decimals = values[values != np.rint(values)]
        thousandths = 1e3 * decimals
        if (values >= 1e3).any() or (decimals < 1).any() or (np.abs(thousandths - np.rint(thousandths)) > 1e-6).any():
            return None
        least = float(np.min(decimals, initial=least))
        large, small = np.maximum(values[:-1], values[1:]), np.minimum(values[:-1], values[1:])
        jumps |= bool(((small >= 1) & (large >= 100 * small) & (large == np.rint(large))).any())
    return least if jumps and least < np.inf else None


def _note_points(number: str, findings: FindingCollector) -> None:
    """Say how points before exactly three digits are read, where semicolons leave open what the decimal sign is."""
    findings.add(
        NOTE,
        "decimal_point_unclear",
        f"{number!r} is read as a decimal and may be a thousand: say `--decimal .`, or export without thousands.",
        value=number,
    )


_WORD = re.compile(r"[^\W\d][\w .:/°%()\[\]-]*")
_MOST_TITLE_LINES = 30
_FEWEST_ROWS = 3


class SecondHeader(Exception):
    """Another table begins at `offset`, which is line `line` of its source; its header is in line `header_line`."""

    def __init__(self, offset: int, line: int, header_line: int) -> None:
        super().__init__(f"another table begins in line {line}")
        self.offset, self.line, self.header_line = offset, line, header_line


def is_header(source: TextSource, content: bytes, cells: Sequence[bytes], layout: Layout) -> bool:
    """Whether a line among the rows names columns: no number, and half of its cells are names or bear units.

    Words alone, different ones and as many as there are columns, are names too where all columns hold numbers.
    """
    if any(is_number(cell, comma=True) for cell in cells):
        return False
    texts = [strip_comment(source.decode(cell)) for cell in cells if not is_missing(cell.lower())]
    if not layout.header_cells or len(texts) < min(2, layout.width):
        return False
    known = {squash(parse_header(name).base) for name in layout.names}
    named = sum(_is_column_name(text, known) for text in texts)
    if 2 * named >= len(texts):
        return True
    words = all(map(_WORD.fullmatch, texts)) and len(set(texts)) == len(texts) == layout.width > 1
    return words and not content.lstrip().startswith(COMMENT_STARTS) and "text" not in layout.kinds


def _is_column_name(text: str, known: set[str]) -> bool:
    cell = parse_header(text)
    base = squash(cell.base)
    return cell.unit is not None or base in known or base in TIME_NAMES or channel_of(cell.base) is not None


def check_above(source: TextSource, layout: Layout) -> None:
    """Raise `SecondHeader` where another table, a line of names and rows of as many numbers, stands above this one."""
    above = [row_of(line, layout.delimiter) for line in source.head_lines() if line.start < layout.data_start]
    own = next((row for row in reversed(above) if tuple(row.cells) == layout.header_cells), None)
    names, rows = 0, 0
    for row in above:
        if own is None or row.line.start >= own.line.start:
            break
        if row.data_like and row.share == 1.0 and len(row.cells) == names:
            rows += 1
        elif row.share == 0.0 and len(row.cells) > 1:
            names, rows = len(row.cells), 0
        if rows == _FEWEST_ROWS:
            whole_file = dataclasses.replace(layout, data_start=row.line.start)
            raise second_header(source, whole_file, own.line.start, own.line.number)


def second_header(source: TextSource, layout: Layout, position: int, line: int) -> SecondHeader:
    """Return where the table begins whose header is at `position`: at the first of the title lines above it."""
    header_line = line
    for _ in range(_MOST_TITLE_LINES):
        before = source.data.rfind(b"\n", 0, position - 1) + 1
        content = source.data[before:position].strip()
        cells = row_of(Line(line, before, content, True), layout.delimiter)
        if before <= layout.data_start or cells.data_like or (content and len(cells.cells) == layout.width > 1):
            break
        position, line = before, line - 1
    return SecondHeader(position, line, header_line)


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
    else:
        rule, advice = "decimal_comma_unquoted", "in numbers; export with semicolons between cells."
    findings.add(FILE, rule, counted + advice, lines=[header.line.number])
