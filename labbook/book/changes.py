"""What a statement changed, in words."""

from __future__ import annotations

import re
from collections.abc import Mapping

import sqlalchemy as sa

from data_schema.queries.facts import read_fact

_NAME_OF = {"condition": "key", "day": "date_local", "robot": "name", "battery": "name", "run": "name", "study": "name"}


def changes_in_words(connection: sa.Connection, old: Mapping[str, object], new: Mapping[str, object]) -> str:
    """Say what columns are now, and were where that is known; what they refer to is called by its name."""
    said = []
    for name, value in new.items():
        before = f"{_named(connection, name, old[name])} to " if name in old else ""
        if value is not None or before:
            said.append(f"{name} {before}{_named(connection, name, value)}")
    return ", ".join(said)


def _named(connection: sa.Connection, name: str, value: object) -> str:
    """Return what people call a thing that the journal names by its uid."""
    if value is None:
        return "none" if name == "run" else "unknown"
    if name in _NAME_OF and re.fullmatch("[0-9a-f]{12}", str(value)):
        return str(read_fact(connection, name, str(value), [_NAME_OF[name]])[_NAME_OF[name]])
    return f"{value:g}" if isinstance(value, float) else str(value)
