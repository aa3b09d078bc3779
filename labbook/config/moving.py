"""labbook.toml of a book that moves: where database and store are is said anew, all else stays as it was written."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

from data_schema.errors import UsageError

_HEADER = re.compile(r"^\s*\[")
_OF_PLACE = re.compile(r"^\s*\[\s*(database|store)\s*\]")
PLACES = ("database", "store")


def in_one_folder(text: str, database_url: str | None) -> str:
    """Return the text of a labbook.toml whose store is in the book itself, and whose database too, or has this address.

    Raises `UsageError` where `[database]` and `[store]` are not tables with a header of their own.
    """
    kept, leaving = [], False
    for line in text.splitlines(keepends=True):
        if _HEADER.match(line):
            leaving = _OF_PLACE.match(line) is not None
        if not leaving or not line.partition("#")[0].strip():  # what is remarked below may be of the next table
            kept.append(line)
    moved = placed("".join(kept), database_url, None)
    wanted = {key: value for key, value in tomllib.loads(text).items() if key not in PLACES}
    if database_url is not None:
        wanted["database"] = {"url": database_url}
    try:
        if tomllib.loads(moved) == wanted:
            return moved
    except tomllib.TOMLDecodeError:
        pass
    raise UsageError(
        "labbook.toml says where its database or its store is in a form that cannot be changed by itself: write them "
        "as tables [database] and [store] with a line each for url and path, and try again."
    )


def placed(text: str, database_url: str | None, store: Path | None) -> str:
    """Return the text of a labbook.toml that says nothing of these places with what it is to say of them."""
    for table, key, value in (("database", "url", database_url), ("store", "path", store)):
        if value is not None:
            text = f"{text.rstrip()}\n\n[{table}]\n{key} = {json.dumps(str(value), ensure_ascii=False)}\n"
    return text
