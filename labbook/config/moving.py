"""labbook.toml of a book that moves: where database and store are is said anew, all else stays as it was written."""

from __future__ import annotations

import json
import re
import tomllib

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
    moved = "".join(kept)
    if database_url is not None:
        moved = f"{moved.rstrip()}\n\n[database]\nurl = {json.dumps(database_url)}\n"
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
