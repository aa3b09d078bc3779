"""Lines `name: value` that programs print beside, or instead of, a table: `Acceleration: 9.46`, `motor1: -2957986`."""

from __future__ import annotations

import re
from typing import NamedTuple

# A name begins with a letter, so that a row of numbers or clock times, cut anywhere, is none.
_NUMBER = re.compile(rb"[+-]?(?:\d+[.,]?\d*|\.\d+)(?:[eE][+-]?\d+)?(?:\s*[A-Za-z%/*^0-9]{1,8})?")
_DEBUG_LINE = re.compile(rb"\s*([A-Za-z_][\w ./\[\]()-]{0,60}?)\s*[:=]\s*(\S.*?)\s*")


class DebugLine(NamedTuple):
    """The name before the colon or equals sign, and the text after it, both stripped."""

    name: bytes
    value: bytes


def debug_line(content: bytes) -> DebugLine | None:
    """Return the parts of a line `name: value` or `name = value`, None for any other line."""
    match = _DEBUG_LINE.fullmatch(content)
    return None if match is None else DebugLine(match[1], match[2])


def is_single_number(line: DebugLine | None) -> bool:
    """Whether the text after the name is one number, a unit perhaps behind it: such a line is no row of a table."""
    return line is not None and _NUMBER.fullmatch(line.value) is not None
