"""Where in `labbook.toml` a fact stands that was corrected in the book, and what to change there.

When a book moves, the places of its database and store in labbook.toml are written anew; all else stays as it was.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from data_schema.errors import UsageError
from labbook.config.model import Configuration

_TABLES = {"robot": "robots", "battery": "batteries", "instrument": "instruments", "factor": "factors"}


def toml_changes(configuration: Configuration, target: str, corrected: Mapping[str, Any]) -> list[str]:
    """Return a line for each field that labbook.toml should change; none where it agrees already or never had it.

    `target` is `study`, `robot:NAME`, `battery:NAME`, `instrument:NAME`, `factor:NAME` or `level:FACTOR=LABEL`;
    `corrected` holds the new values by field.
    """
    kind, _colon, name = target.partition(":")
    if kind == "level":
        return _of_level(configuration, name, corrected)
    if target == "study":
        table, settings = "study", configuration.study
    else:
        declared: Mapping[str, Any] = getattr(configuration, _TABLES[kind]) if kind in _TABLES else {}
        if name not in declared:
            return []
        table, settings = f"{_TABLES[kind]}.{name}", declared[name]
        if "name" in corrected:
            return [f"labbook.toml calls it [{table}]: rename that table to [{_TABLES[kind]}.{corrected['name']}]."]
    return [
        f"labbook.toml says {field} = {_toml(getattr(settings, field))} under [{table}]: {_change(value)}."
        for field, value in corrected.items()
        if hasattr(settings, field) and getattr(settings, field) != value
    ]


def _of_level(configuration: Configuration, name: str, corrected: Mapping[str, Any]) -> list[str]:
    factor, _equals, label = name.partition("=")
    levels = (
        {level.label: level for level in configuration.factors[factor].levels}
        if factor in configuration.factors
        else {}
    )
    attributes = json.loads(corrected.get("attributes_json", "null"))
    if label not in levels or attributes is None or dict(levels[label].attributes) == attributes:
        return []
    wanted = ", ".join(f"{key} = {_toml(value)}" for key, value in attributes.items()) or "nothing"
    return [f"labbook.toml says otherwise under [factors.{factor}.levels.{label}]: let it say {wanted}."]


def _change(value: Any) -> str:
    return "take it out" if value is None else f"change it to {_toml(value)}"


def _toml(value: Any) -> str:
    """Write a value as TOML has it; numbers and strings are written as in JSON."""
    return "nothing" if value is None else json.dumps(value, ensure_ascii=False)


_HEADER = re.compile(r"^\s*\[")
_OF_PLACE = re.compile(r"^\s*\[\s*(database|store)\s*\]")
PLACES = ("database", "store")


def without_places(text: str, database_url: str | None) -> str:
    """Return the text of a labbook.toml whose store is in the book itself, and whose database too, or has this address.

    Raises `UsageError` where `[database]` and `[store]` are not tables with a header of their own.
    """
    retained, leaving = [], False
    for line in text.splitlines(keepends=True):
        if _HEADER.match(line):
            leaving = _OF_PLACE.match(line) is not None
        if not leaving or not line.partition("#")[0].strip():  # comments at the end may belong to the next table
            retained.append(line)
    moved = with_places("".join(retained), database_url, None)
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


def with_places(text: str, database_url: str | None, store: Path | None) -> str:
    """Return the text of a labbook.toml that has no such tables with `[database]` and `[store]` added."""
    for table, key, value in (("database", "url", database_url), ("store", "path", store)):
        if value is not None:
            text = f"{text.rstrip()}\n\n[{table}]\n{key} = {json.dumps(str(value), ensure_ascii=False)}\n"
    return text
