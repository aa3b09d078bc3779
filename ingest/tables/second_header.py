"""A header inside the data that is not the one above: what follows is another table, with columns of its own."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

from ingest.channels.synonyms import TIME_NAMES, channel_of
from ingest.tables.header_cells import parse_header, squash, strip_comment
from ingest.tables.layout import Layout
from ingest.text.cells import COMMENT_STARTS, is_missing, is_number
from ingest.text.delimiters import row_of
from ingest.text.source import Line, TextSource

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
    named = sum(_is_name(text, known) for text in texts)
    if 2 * named >= len(texts):
        return True
    words = all(map(_WORD.fullmatch, texts)) and len(set(texts)) == len(texts) == layout.width > 1
    return words and not content.lstrip().startswith(COMMENT_STARTS) and "text" not in layout.kinds


def _is_name(text: str, known: set[str]) -> bool:
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
