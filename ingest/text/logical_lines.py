"""One line after the other, a quoted cell that runs over several lines counted as one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from ingest.text.source import MOST_QUOTED_LINES

_LINE = re.compile(rb"([^\r\n]*)(?:\r\n|\n|\r|\Z)")


class LogicalLine(NamedTuple):
    """Content without line end, offset of the next line, number of physical lines."""

    content: bytes
    end: int
    spanned: int


def logical_line(data: bytes, position: int, stop: int) -> LogicalLine:
    """Return the line at `position`, with those that an open quote takes in; a quote never closed takes none."""
    first = physical_line(data, position, stop)
    joined, joined_end = first.content, first.end
    for spanned in range(1, MOST_QUOTED_LINES + 1):
        if joined.count(b'"') % 2 == 0:
            return LogicalLine(joined, joined_end, spanned)
        if joined_end >= stop:
            break
        following = physical_line(data, joined_end, stop)
        joined, joined_end = joined + b" " + following.content, following.end
    return first


def numbered_lines(data: bytes, start: int) -> Iterator[tuple[int, bytes]]:
    """Yield the number (from 1, counted from `start`) and the content of every line."""
    position, number = start, 1
    while position < len(data):
        line = logical_line(data, position, len(data))
        yield number, line.content
        position, number = line.end, number + line.spanned


def physical_line(data: bytes, position: int, stop: int) -> LogicalLine:
    """Return the line at `position` whatever quotes it holds."""
    match = _LINE.match(data, position, stop)
    if match is None:  # the pattern also matches nothing, at the end
        return LogicalLine(b"", stop, 1)
    return LogicalLine(match[1], match.end(), 1)
