"""What was stated otherwise from some entry of the journal on: corrections, and files and charges taken off runs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.tables import FACTS
from data_schema.tables.files import IN_USE, LAST_READING, file, ingest, run_file
from data_schema.tables.people import journal, person
from data_schema.tables.runs import run
from data_schema.vocabulary import Action


@dataclass(frozen=True, slots=True)
class Change:
    """An entry that changed what the book held; `old` and `new` as the journal keeps them."""

    at_utc: str
    person: str
    kind: str
    uid: str
    old: Mapping[str, Any]
    new: Mapping[str, Any]
    seq: int


@dataclass(frozen=True, slots=True)
class FileLink:
    """That a file belongs to a run now."""

    uid: str
    file_uid: str
    run_uid: str


def changes_after(connection: sa.Connection, seq: int) -> list[Change]:
    """List what changed runs, charges and files after an entry, in order; a first assignment changes nothing."""
    query = (
        sa.select(
            journal.c.at_utc,
            person.c.name,
            journal.c.entity_kind,
            journal.c.entity_uid,
            journal.c.old_json,
            journal.c.new_json,
            journal.c.seq,
        )
        .join(person, journal.c.person == person.c.id)
        .where(
            journal.c.seq > seq,
            journal.c.entity_kind.in_(("run", "charge", "run_file", "file")),
            journal.c.action.in_((str(Action.CORRECT), str(Action.ASSIGN), str(Action.WITHDRAW))),
        )
        .order_by(journal.c.seq)
    )
    found = [
        Change(*row[:4], old=json.loads(row[4] or "{}"), new=json.loads(row[5] or "{}"), seq=row[6])
        for row in connection.execute(query)
    ]
    return [change for change in found if change.new or change.old.get("runs")]  # withdrawing what had no run is none


def file_links(connection: sa.Connection) -> list[FileLink]:
    """List which files that are in use belong to which runs."""
    query = (
        sa.select(run_file.c.uid, file.c.uid, run.c.uid)
        .join(file, run_file.c.file == file.c.id)
        .join(run, run_file.c.run == run.c.id)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, IN_USE))
        .order_by(run_file.c.id)
    )
    return [FileLink(*row) for row in connection.execute(query)]


def roles_and_names_of_files(connection: sa.Connection) -> dict[str, tuple[str | None, str]]:
    """Return the role and the name under which each file was imported, by the file's uid."""
    query = (
        sa.select(file.c.uid, ingest.c.role, ingest.c.original_name)
        .join(ingest, ingest.c.file == file.c.id)
        .where(LAST_READING)
    )
    return {uid: (role, name) for uid, role, name in connection.execute(query)}


def words_by_uid(connection: sa.Connection, kind: str, column: str) -> dict[str, str]:
    """Return what a column says of every row of a kind of fact, by the row's uid."""
    table = FACTS[kind]
    return {uid: str(word) for uid, word in connection.execute(sa.select(table.c.uid, table.c[column]))}
