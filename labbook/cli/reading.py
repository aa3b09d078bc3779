"""Text files that a person names on the command line."""

from __future__ import annotations

from pathlib import Path

from data_schema.errors import InputRefused
from labbook.actions.files_meant import read_bytes


def read_text(path: Path) -> str:
    """Read a text file as UTF-8, with or without a byte order mark."""
    if path.is_dir():
        raise InputRefused(f"{path} is a folder: name the file in it.")
    data = read_bytes(path)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputRefused(
            f"{path} is not UTF-8 text (byte {error.start}): save it as CSV in UTF-8 and try again."
        ) from error
