"""Whether the last bytes of a file show that it was written to its end, where its format says so."""

from __future__ import annotations

import os
import struct
from enum import StrEnum
from pathlib import Path

from ingest.text.source import is_text

_HEAD_BYTES = 4096
_ZIP, _ZIP_END = b"PK\3\4", b"PK\5\6"
_ZIP_END_BYTES = 22
"""Length of the record that ends an archive, without its comment."""
_LONGEST_COMMENT = 65_535
_UNKNOWN_HERE = 0xFFFFFFFF
"""Stands for a place or length that a larger record has, in archives beyond 4 GB."""
_WIDE_LINE_ENDS = {b"\xff\xfe": (b"\n\0", b"\r\0"), b"\xfe\xff": (b"\0\n", b"\0\r")}
"""Of UTF-16 text, by its byte order mark."""


class End(StrEnum):
    """Whether the end of a file is there, by its own bytes; of most formats only that nothing more comes tells."""

    THERE = "there"
    MISSING = "missing"
    UNKNOWN = "unknown"


def end_of(path: Path) -> End:
    """Look at the first and the last bytes of a file; raises `OSError` where it cannot be read.

    An archive (.zip, .xlsx, .ods) ends with a record that says where the one before it lies, so that its end is
    certain. Text lacks its end where its last line has none; where it has one, more lines may follow.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        size = file.seek(0, os.SEEK_END)
        if head.startswith(_ZIP):
            file.seek(max(0, size - _ZIP_END_BYTES - _LONGEST_COMMENT))
            return _end_of_archive(file.read(), size)
        file.seek(max(0, size - 2))
        last = file.read()
    if not head or not is_text(head):
        return End.UNKNOWN
    ends = _WIDE_LINE_ENDS.get(head[:2], (b"\n", b"\r"))
    return End.UNKNOWN if last.endswith(ends) else End.MISSING


def _end_of_archive(tail: bytes, size: int) -> End:
    """Look for the record that ends an archive, `size` bytes long: what it lists must end where it begins."""
    at = tail.rfind(_ZIP_END)
    if at < 0 or len(tail) - at < _ZIP_END_BYTES:
        return End.MISSING
    length, start, comment = struct.unpack_from("<IIH", tail, at + 12)
    if at + _ZIP_END_BYTES + comment != len(tail):
        return End.MISSING
    if _UNKNOWN_HERE not in (length, start) and start + length != size - len(tail) + at:
        return End.MISSING
    return End.UNKNOWN if comment else End.THERE  # a remark of NULs may be one that is still to be written
