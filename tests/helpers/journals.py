"""Journal entries for tests: one person's chain, of any length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import sqlalchemy as sa

from data_schema import journal
from data_schema.journal import GENESIS, JOURNAL_SCHEMA, Entry
from data_schema.tables.journal import person
from data_schema.vocabulary import Action

ADA = "Ada Nwosu"


def entry(seq: int, prev_hash: str, **said: Any) -> Entry:
    """One entry; what is not said is filled in."""
    values: dict[str, Any] = {
        "following": 0,
        "at_utc": "2021-06-14T13:30:00.000Z",
        "person": ADA,
        "action": Action.NOTE,
        "entity_kind": "note",
        "entity_uid": f"{seq:012x}",
        "old": None,
        "new": {"text": f"remark {seq}"},
        "reason": None,
        "schema": JOURNAL_SCHEMA if seq == 1 else None,
    }
    return Entry(seq=seq, prev_hash=prev_hash, **{**values, **said})


def chain(said: Sequence[dict[str, Any]]) -> list[Entry]:
    """Entries that follow each other from the first on."""
    entries: list[Entry] = []
    for seq, values in enumerate(said, start=1):
        entries.append(entry(seq, entries[-1].hash if entries else GENESIS, **values))
    return entries


def renumbered(entries: Sequence[Entry]) -> list[Entry]:
    """The same statements in the order given, numbered and chained anew: a forger's journal."""
    forged: list[Entry] = []
    for seq, one in enumerate(entries, start=1):
        forged.append(
            replace(
                one,
                seq=seq,
                prev_hash=forged[-1].hash if forged else GENESIS,
                schema=JOURNAL_SCHEMA if seq == 1 else one.schema if one.schema != JOURNAL_SCHEMA else None,
            )
        )
    return forged


def write_all(connection: sa.Connection, entries: Sequence[Entry]) -> None:
    """Write entries to the table, and their people before them."""
    for name in dict.fromkeys(one.person for one in entries):
        connection.execute(person.insert().values(uid=f"p-{name}", name=name, initials=name[:2]))
    journal.insert(connection, entries)
