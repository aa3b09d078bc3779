"""What was said about a run, and which files belong to it."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.files import IN_USE, file, ingest, run_file
from data_schema.tables.people import journal, person
from data_schema.tables.runs import charge, note, run
from data_schema.vocabulary import Action, ChargeState, RunState


@dataclass(frozen=True, slots=True)
class RunFileRow:
    """A file that says something about a run."""

    name: str
    role: str
    n_bytes: int
    sha256: str
    store_path: str


@dataclass(frozen=True, slots=True)
class NoteRow:
    """A remark."""

    text: str
    person: str
    at_utc: str


@dataclass(frozen=True, slots=True)
class HistoryRow:
    """A journal row about one thing."""

    seq: int
    at_utc: str
    person: str
    action: str
    old_json: str | None
    new_json: str | None
    reason: str | None


def files_of_run(connection: sa.Connection, run_uid: str) -> list[RunFileRow]:
    """Return the files of a run: those assigned, and those with a charge of it."""
    of_run = sa.select(run.c.id).where(run.c.uid == run_uid).scalar_subquery()
    counted = charge.c.state == str(ChargeState.COUNTED)
    linked = sa.union(
        sa.select(run_file.c.file).where(run_file.c.run == of_run),
        sa.select(charge.c.file).where(charge.c.run == of_run, charge.c.file.is_not(None), counted),
    )
    query = (
        sa.select(ingest.c.original_name, ingest.c.role, file.c.n_bytes, file.c.sha256, file.c.store_path)
        .join(file, ingest.c.file == file.c.id)
        .where(file.c.id.in_(linked), IN_USE)
        .order_by(ingest.c.id)
    )
    return [RunFileRow(*row) for row in connection.execute(query)]


def notes_of(connection: sa.Connection, uid: str) -> list[NoteRow]:
    """Return the remarks on a thing, oldest first."""
    query = (
        sa.select(note.c.text, person.c.name, note.c.at_utc)
        .join(person, note.c.person == person.c.id)
        .where(note.c.target_uid == uid)
        .order_by(note.c.id)
    )
    return [NoteRow(*row) for row in connection.execute(query)]


def history_of(connection: sa.Connection, uid: str) -> list[HistoryRow]:
    """Return all statements about a thing, oldest first."""
    query = (
        sa.select(
            journal.c.seq,
            journal.c.at_utc,
            person.c.name,
            journal.c.action,
            journal.c.old_json,
            journal.c.new_json,
            journal.c.reason,
        )
        .join(person, journal.c.person == person.c.id)
        .where(journal.c.entity_uid == uid)
        .order_by(journal.c.seq)
    )
    return [HistoryRow(*row) for row in connection.execute(query)]


def reasons_of_void_runs(connection: sa.Connection) -> dict[str, str]:
    """Return why runs that are void were declared so the last time, by their uids."""
    query = (
        sa.select(run.c.uid, journal.c.reason)
        .join(run, run.c.uid == journal.c.entity_uid)
        .where(
            journal.c.entity_kind == "run",
            journal.c.action == str(Action.VOID),
            run.c.state == str(RunState.VOID),
        )
        .order_by(journal.c.seq)
    )
    return {uid: reason or "" for uid, reason in connection.execute(query)}
