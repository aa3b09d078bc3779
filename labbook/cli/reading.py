"""Text files that a person names on the command line."""

from __future__ import annotations

import codecs
from pathlib import Path

from data_schema.errors import InputRefused
from labbook.actions.files_meant import read_bytes


def read_text(path: Path, *, marked_utf_16: bool = False) -> str:
    """Read a text file as UTF-8, with or without a byte order mark, or where asked for as UTF-16 with such a mark."""
    if path.is_dir():
        raise InputRefused(f"{path} is a folder: name the file in it.")
    data = read_bytes(path)
    marked = marked_utf_16 and data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if marked else "utf-8-sig")
    except UnicodeDecodeError as error:
        nor = ", nor UTF-16 with a byte order mark" if marked_utf_16 else ""
        raise InputRefused(
            f"{path} is not UTF-8 text (byte {error.start}){nor}; other pages, such as Windows-1252, are not read: "
            "save it as CSV in UTF-8 and try again."
        ) from error
