"""Where in `labbook.toml` a fact stands that was corrected in the book, and what to change there.

When a book moves, the places of its database and store in labbook.toml are written anew; all else stays as it was.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from msgspec import to_builtins

from data_schema.errors import UsageError
from labbook.config.model import Configuration

_TABLES = {
    "study": "study",
    "robot": "robots",
    "battery": "batteries",
    "instrument": "instruments",
    "factor": "factors",
}


def toml_changes(configuration: Configuration, target: str, corrected: Mapping[str, Any]) -> list[str]:
    """Return a line for each field that labbook.toml should change; none where it agrees already or never had it.

    `target` is `study`, `robot:NAME`, `battery:NAME`, `instrument:NAME`, `factor:NAME` or `level:FACTOR=LABEL`;
    `corrected` holds the new values by field.
    """
    kind, _colon, name = target.partition(":")
    path = [_TABLES.get(kind, ""), *filter(None, [name])]
    if kind == "level":
        factor, _equals, label = name.partition("=")
        path, corrected = ["factors", factor, "levels", label], json.loads(corrected.get("attributes_json", "{}"))
    table = to_builtins(configuration)
    for key in path:
        table = table.get(key) if isinstance(table, dict) else None
    if not isinstance(table, dict):
        return []
    where = f"[{'.'.join(path)}]"
    if "name" in corrected and kind != "study":
        return [f"labbook.toml calls it {where}: rename that table to [{path[0]}.{corrected['name']}]."]
    fields = {field: value for field, value in corrected.items() if field in table or kind == "level"}
    return [
        f"labbook.toml says {_toml(field, table.get(field))} under {where}: let it say {_toml(field, value)}."
        for field, value in fields.items()
        if value != table.get(field)
    ]


def _toml(key: str, value: Any) -> str:
    """Write a key as TOML has it; numbers and strings are written as in JSON."""
    return f"no {key}" if value is None else f"{key} = {json.dumps(value, ensure_ascii=False)}"


_HEADER = re.compile(r"^\s*\[")
_OF_PLACE = re.compile(r"^\s*\[\s*(database|store)\s*\]")
PLACES = ("database", "store")


def with_database(text: str, database_url: str | None, *, without: Collection[str] = ("database",)) -> str:
    """Return the text of a labbook.toml whose database has this address, or is in the book itself.

    With "store" among the tables `without`, its store is in the book, too. Raises `UsageError` where these tables have
    no header of their own.
    """
    retained, leaving = [], False
    for line in text.splitlines(keepends=True):
        if _HEADER.match(line):
            found = _OF_PLACE.match(line)
            leaving = found is not None and found[1] in without
        if not leaving or not line.partition("#")[0].strip():  # comments at the end may belong to the next table
            retained.append(line)
    moved = with_places("".join(retained), database_url, None)
    wanted = {key: value for key, value in tomllib.loads(text).items() if key not in without}
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


def with_places(text: str, database_url: str | None, store: Path | None) -> str:
    """Return the text of a labbook.toml that has no such tables with `[database]` and `[store]` added."""
    for table, key, value in (("database", "url", database_url), ("store", "path", store)):
        if value is not None:
            text = f"{text.rstrip()}\n\n[{table}]\n{key} = {json.dumps(str(value), ensure_ascii=False)}\n"
    return text
