"""The entries of the journal about runs, charges and files, and the rows that the book's state at one follows from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.tables import FACTS
from data_schema.tables.files import LAST_READING, file, ingest, run_file
from data_schema.tables.people import journal, person
from data_schema.tables.runs import charge, run
from data_schema.vocabulary import Action, ChargeState, IngestStatus


@dataclass(frozen=True, slots=True)
class EntryRow:
    """An entry of the journal; `command` is the number of the last entry of its command.

    Most entries are never looked into, so that `old` and `new` are read from their JSON when they are asked for.
    """

    seq: int
    command: int
    at_utc: str
    person: str
    action: Action
    kind: str
    uid: str
    old_json: str | None
    new_json: str | None
    reason: str | None

    @property
    def old(self) -> Mapping[str, Any]:
        """The columns as they were before, by name."""
        return json.loads(self.old_json) if self.old_json else {}

    @property
    def new(self) -> Mapping[str, Any]:
        """The columns as the entry states them, by name."""
        return json.loads(self.new_json) if self.new_json else {}


@dataclass(frozen=True, slots=True)
class FileLink:
    """That a part of a file belongs to a run, or would if the file were in use; `part` is the file's uid and a name."""

    uid: str
    part: tuple[str, str]
    run_uid: str
    in_use: bool


_KINDS = ("run", "charge", "run_file", "file", "ingest", "decision")
_ACTIONS = {
    str(action): action
    for action in (
        *(Action.DECLARE, Action.CORRECT, Action.VOID, Action.ASSIGN),
        *(Action.DECIDE, Action.INGEST, Action.WITHDRAW, Action.RESTORE),
    )
}


def entries_about_runs(connection: sa.Connection) -> list[EntryRow]:
    """Return the entries that declare, import, assign, correct, judge and void runs, charges and files, in order."""
    query = (
        sa.select(
            journal.c.seq,
            journal.c.seq + journal.c.following,
            journal.c.at_utc,
            person.c.name,
            journal.c.action,
            journal.c.entity_kind,
            journal.c.entity_uid,
            journal.c.old_json,
            journal.c.new_json,
            journal.c.reason,
        )
        .join(person, journal.c.person == person.c.id)
        .where(journal.c.entity_kind.in_(_KINDS), journal.c.action.in_(list(_ACTIONS)))
        .order_by(journal.c.seq)
    )
    return [
        EntryRow(seq, command, at_utc, name, _ACTIONS[action], *about)
        for seq, command, at_utc, name, action, *about in connection.execute(query)
    ]


def reports_made(connection: sa.Connection) -> list[int]:
    """Return the numbers of the entries of reports, in order."""
    query = sa.select(journal.c.seq).where(journal.c.action == str(Action.REPORT)).order_by(journal.c.seq)
    return list(connection.execute(query).scalars())


def files_read(connection: sa.Connection) -> list[tuple[str, str, str]]:
    """Return the uid of each reading, that of its file and the file's name, the last reading of a file last."""
    query = (
        sa.select(ingest.c.uid, file.c.uid, ingest.c.original_name)
        .join(file, ingest.c.file == file.c.id)
        .order_by(ingest.c.id)
    )
    return [(uid, file_uid, name) for uid, file_uid, name in connection.execute(query)]


def file_links(connection: sa.Connection) -> list[FileLink]:
    """Return which parts of files belong to which runs; those of withdrawn files as they were."""
    query = (
        sa.select(run_file.c.uid, file.c.uid, run_file.c.part, run.c.uid, ingest.c.status)
        .join(file, run_file.c.file == file.c.id)
        .join(run, run_file.c.run == run.c.id)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
        .order_by(run_file.c.id)
    )
    return [
        FileLink(uid, (file_uid, part), run_uid, status != IngestStatus.WITHDRAWN)
        for uid, file_uid, part, run_uid, status in connection.execute(query)
    ]


def files_of_charges(connection: sa.Connection) -> dict[str, tuple[str | None, bool]]:
    """Return the file of each charge by its uid, None where it was typed, and whether the charge counts."""
    query = sa.select(charge.c.uid, file.c.uid, charge.c.state).outerjoin(file, charge.c.file == file.c.id)
    return {uid: (file_uid, state == ChargeState.COUNTED) for uid, file_uid, state in connection.execute(query)}


def words_by_uid(connection: sa.Connection, kind: str, column: str) -> dict[str, str]:
    """Return what a column says of every row of a kind of fact, by the row's uid."""
    table = FACTS[kind]
    return {uid: str(word) for uid, word in connection.execute(sa.select(table.c.uid, table.c[column]))}
