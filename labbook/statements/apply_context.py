"""What a statement acts on: the open transaction and the store."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UnknownName
from data_schema.journal import Entry
from data_schema.queries.facts import find_uid
from data_schema.queries.study import person_uid
from ingest.store import Store


@dataclass(frozen=True, slots=True)
class ApplyContext:
    """The open transaction and the store of files.

    `without_rows` is None while a person makes statements; on replaying the journal it collects the statements about
    charges and links that no reading of their file gives now. Files with a SHA-256 among the `lost` are not read: they
    wait for their raw copy.
    """

    connection: sa.Connection
    store: Store
    without_rows: list[Entry] | None = None
    lost: frozenset[str] = frozenset()


def with_author(context: ApplyContext, entry: Entry, values: Mapping[str, Any]) -> dict[str, Any]:
    """Add person and time of the statement to the columns of a row that has these two."""
    return {**values, "person": person_uid(context.connection, entry.person), "at_utc": entry.at_utc}


def run_named(context: ApplyContext, name: str | None) -> str | None:
    """Return the uid of the run of this name, if there is one."""
    return find_uid(context.connection, "run", name=name) if name else None


def missing_row(context: ApplyContext, entry: Entry) -> None:
    """Collect a statement about a missing row where the journal is replayed, which nothing may stop.

    A newer reader may give fewer rows than an earlier one, and a file may wait for a declaration. A statement about a
    charge takes effect when a reading gives it. Raises `UnknownName` for a statement that is being made now.
    """
    if context.without_rows is None:
        raise UnknownName(
            f"there is no {entry.entity_kind} with uid {entry.entity_uid!r}: list what there is and use a name from "
            "there."
        )
    context.without_rows.append(entry)


def derived_uid(*parts: object) -> str:
    """Name a row after what it was derived from, so that deriving it again gives the same name."""
    return hashlib.sha256("\n".join(str(part) for part in parts).encode()).hexdigest()[:16]
