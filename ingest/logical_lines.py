"""One line after the other, a quoted cell that runs over several lines counted as one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from ingest.cells import split_cells
from ingest.text import MOST_QUOTED_LINES

_LINE = re.compile(rb"([^\r\n]*)(?:\r\n|\n|\r|\Z)")


class LogicalLine(NamedTuple):
    """Content without line end, offset of the next line, number of physical lines."""

    content: bytes
    end: int
    spanned: int


def logical_line(data: bytes, position: int, stop: int, delimiter: bytes) -> LogicalLine:
    """Return the line at `position`, with those that an open quote takes in; a quote never closed takes none."""
    content, end = _physical(data, position, stop)
    if b'"' not in content:
        return LogicalLine(content, end, 1)
    joined, joined_end = content, end
    for spanned in range(1, MOST_QUOTED_LINES + 1):
        if split_cells(joined, delimiter) is not None:
            return LogicalLine(joined, joined_end, spanned)
        if joined_end >= stop:
            break
        following, joined_end = _physical(data, joined_end, stop)
        joined += b" " + following
    return LogicalLine(content, end, 1)


def numbered_lines(data: bytes, start: int, delimiter: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the number (from 1, counted from `start`) and the content of every line."""
    position, number = start, 1
    while position < len(data):
        line = logical_line(data, position, len(data), delimiter)
        yield number, line.content
        position, number = line.end, number + line.spanned


def _physical(data: bytes, position: int, stop: int) -> tuple[bytes, int]:
    match = _LINE.match(data, position, stop)
    if match is None:  # the pattern also matches nothing, at the end
        return b"", stop
    return match[1], match.end()
