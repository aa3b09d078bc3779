"""Entries of the journal: of runs, charges, files and plans, of the first measurement and the configurations.

Also the reports of a book: when each was made, by whom, of which runs, and where its files are.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.journal import action_of, is_new
from data_schema.tables import FACTS
from data_schema.tables.base import columns_of, in_chunks
from data_schema.tables.files import IN_USE, LAST_READING, file, ingest, run_file
from data_schema.tables.journal import journal, person
from data_schema.tables.reports import report
from data_schema.tables.runs import charge, note, run
from data_schema.vocabulary import Action, ChargeState, IngestStatus


@dataclass(frozen=True, slots=True)
class RunFileRow:
    """A file that is linked to a run, or has a charge of it, and by which reader and settings it was read."""

    name: str
    role: str
    n_bytes: int
    sha256: str
    store_path: str
    reader: str
    reader_version: int
    settings: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class NoteRow:
    """A remark."""

    text: str
    person: str
    at_utc: str


def files_of_run(connection: sa.Connection, run_uid: str) -> list[RunFileRow]:
    """Return the files of a run: those assigned, and those with a charge of it."""
    of_run = sa.select(run.c.id).where(run.c.uid == run_uid).scalar_subquery()
    counted = charge.c.state == ChargeState.COUNTED
    linked = sa.union(
        sa.select(run_file.c.file).where(run_file.c.run == of_run),
        sa.select(charge.c.file).where(charge.c.run == of_run, charge.c.file.is_not(None), counted),
    )
    query = (
        sa.select(
            *columns_of(
                RunFileRow,
                ingest,
                name=ingest.c.original_name,
                n_bytes=file.c.n_bytes,
                sha256=file.c.sha256,
                store_path=file.c.store_path,
                settings=ingest.c.declared_json,
            )
        )
        .join(file, ingest.c.file == file.c.id)
        .where(file.c.id.in_(linked), IN_USE)
        .order_by(ingest.c.id)
    )
    rows: list[list[Any]] = [[*row[:-1], json.loads(row[-1])] for row in connection.execute(query)]
    return [RunFileRow(*row) for row in rows]


def notes_of(connection: sa.Connection, uid: str) -> list[NoteRow]:
    """Return the remarks on a thing, oldest first."""
    query = (
        sa.select(note.c.text, person.c.name, note.c.at_utc)
        .join(person, note.c.person == person.c.id)
        .where(note.c.target_uid == uid)
        .order_by(note.c.id)
    )
    return [NoteRow(*row) for row in connection.execute(query)]


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
    def makes(self) -> bool:
        """Whether a thing, or a file, first comes in with it."""
        return is_new(self.action, self.kind, self.old_json)

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


def entries_about_runs(connection: sa.Connection) -> list[EntryRow]:
    """Return the entries about runs, charges, files and jumps, in order."""
    return _entries(connection, journal.c.entity_kind.in_(_KINDS))


def entries_about_plans(connection: sa.Connection) -> list[EntryRow]:
    """Return the entries that state and withdraw plans, in order."""
    return _entries(connection, journal.c.entity_kind == "plan")


def history_of_run(connection: sa.Connection, run_uid: str, charge_uids: Sequence[str]) -> list[EntryRow]:
    """Return all statements about a run, its charges, and charges that were given to it or taken off, oldest first."""
    in_words = f'%"{run_uid}"%'
    of_run = sa.or_(journal.c.old_json.like(in_words), journal.c.new_json.like(in_words))
    about_charge = sa.or_(journal.c.entity_uid.in_(charge_uids), of_run)
    about = (journal.c.entity_uid == run_uid, sa.and_(journal.c.entity_kind == "charge", about_charge))
    return _entries(connection, sa.or_(*about))


def entries_between(connection: sa.Connection, after_seq: int, until_seq: int) -> list[EntryRow]:
    """Return the entries after one and up to another, in order."""
    return _entries(connection, sa.and_(journal.c.seq > after_seq, journal.c.seq <= until_seq))


def ends_of_commands(connection: sa.Connection, most: int, before: int | None = None) -> list[int]:
    """Return the numbers of the last entries of commands, the newest first, with `before` those below it."""
    query = sa.select(journal.c.seq).where(journal.c.following == 0).order_by(journal.c.seq.desc()).limit(most)
    return list(connection.execute(query if before is None else query.where(journal.c.seq < before)).scalars())


@dataclass(frozen=True, slots=True)
class CommandEnd:
    """The last entry of a command, its hash, and when the command was given."""

    seq: int
    hash: str
    at_utc: str


def command_ends(connection: sa.Connection) -> list[CommandEnd]:
    """Return the ends of all commands in their order; none was given before one that stands before it.

    What was merged has times of its own, and so have commands of a clock that was set back.
    """
    query = sa.select(journal.c.seq, journal.c.following, journal.c.hash, journal.c.at_utc).order_by(journal.c.seq)
    found, latest = [], ""
    for seq, following, found_hash, at_utc in connection.execute(query):
        latest = max(latest, at_utc)
        if following == 0:
            found.append(CommandEnd(seq, found_hash, latest))
    return found


def last_stated_utc(connection: sa.Connection) -> str | None:
    """Return when something was last stated in this book; what was merged has times of another."""
    query = sa.select(journal.c.at_utc).where(journal.c.origin_json.is_(None))
    return connection.execute(query.order_by(journal.c.seq.desc()).limit(1)).scalar()


def _entries(connection: sa.Connection, wanted: sa.ColumnElement[bool], most: int | None = None) -> list[EntryRow]:
    query = (
        sa.select(
            *columns_of(
                EntryRow,
                journal,
                command=journal.c.seq + journal.c.following,
                person=person.c.name,
                kind=journal.c.entity_kind,
                uid=journal.c.entity_uid,
            )
        )
        .join(person, journal.c.person == person.c.id)
        .where(wanted)
        .order_by(journal.c.seq)
        .limit(most)
    )
    return [
        EntryRow(seq, command, at_utc, name, action_of(action), *about)
        for seq, command, at_utc, name, action, *about in connection.execute(query)
    ]


def void_reasons(connection: sa.Connection, run_uids: Sequence[str]) -> dict[str, str]:
    """Return why these runs were declared void, by their uid, the last time that each was."""
    void = _entries(connection, sa.and_(journal.c.entity_uid.in_(run_uids), journal.c.action == Action.EXCLUDE))
    return {entry.uid: entry.reason or "" for entry in void}


def reports_made(connection: sa.Connection) -> list[int]:
    """Return the numbers of the entries that reports are of, in order."""
    query = sa.select(journal.c.seq, journal.c.new_json, journal.c.origin_json)
    made = connection.execute(query.where(journal.c.action == Action.REPORT))
    return sorted(report_as_of(seq, json.loads(new), origin is not None) for seq, new, origin in made)


def report_as_of(seq: int, new: Mapping[str, Any], elsewhere: bool) -> int:
    """Return the number of the last entry that a report, entry number `seq`, is of: it states one only where others
    wrote while it was made, and one of a book that was merged counts in that book.
    """
    return seq - 1 if elsewhere else int(new.get("as_of", seq - 1))


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
    """Return the values of a column for every row of a kind of fact, by the row's uid."""
    table = FACTS[kind]
    return {uid: str(word) for uid, word in connection.execute(sa.select(table.c.uid, table.c[column]))}


def first_measurement(connection: sa.Connection) -> EntryRow | None:
    """Return the entry with which the first measurement came into the book; None before it."""
    typed_charge = sa.and_(
        journal.c.action == Action.SET, journal.c.entity_kind == "charge", journal.c.old_json.is_(None)
    )
    read = journal.c.entity_uid.in_(sa.select(ingest.c.uid).where(ingest.c.file.is_not(None)))
    return next(iter(_entries(connection, sa.or_(typed_charge, read), most=1)), None)


def recorded_configurations(connection: sa.Connection) -> list[EntryRow]:
    """List the entries that took over a labbook.toml, whose `new` has its text, in the order of the journal."""
    return _entries(connection, journal.c.entity_kind == "config")


def statements_about(connection: sa.Connection, uid: str, action: Action | None = None) -> list[EntryRow]:
    """Return the statements about a thing, or those of one action, in order."""
    about = journal.c.entity_uid == uid
    return _entries(connection, about if action is None else sa.and_(about, journal.c.action == action))


def history_of_charges(connection: sa.Connection, uids: Sequence[str]) -> dict[str, list[EntryRow]]:
    """Return the statements about each of some charges, in order."""
    found: dict[str, list[EntryRow]] = {uid: [] for uid in uids}
    for some in in_chunks(uids):
        of_charges = sa.and_(journal.c.entity_kind == "charge", journal.c.entity_uid.in_(some))
        for entry in _entries(connection, of_charges):
            found[entry.uid].append(entry)
    return found


def reading_entries(connection: sa.Connection, sha256: str) -> list[Mapping[str, Any]]:
    """Return the content of the journal entry of each reading of an imported file, in order."""
    readings = sa.select(ingest.c.uid).where(ingest.c.sha256 == sha256, ingest.c.file.is_not(None))
    return [entry.new for entry in _entries(connection, journal.c.entity_uid.in_(readings))]


@dataclass(frozen=True, slots=True)
class ReportRow:
    """A report: its place among all from 1, the number of its entry, who made it when, of which runs, and with what.

    `as_of` is the number of the last entry that it is of.
    `selection` is "" for all runs, `versions` are those of the algorithms, `numbers` how many numbers it shows. Its
    `files` are in `folder`, as it counts from the book's, each with the hash of its bytes. Of a report made
    `elsewhere`, in a book that was merged into this one, they are there.
    """

    number: int
    uid: str
    seq: int
    as_of: int
    made_utc: str
    person: str
    selection: str
    versions: Mapping[str, int]
    numbers: int
    folder: str
    files: Mapping[str, str]
    elsewhere: bool

    @property
    def called(self) -> str:
        """The report as a message names it."""
        return f"{self.number} of {self.made_utc} ({self.selection or 'all runs'})"


def list_reports(connection: sa.Connection) -> list[ReportRow]:
    """List the reports in the order in which they were stated."""
    query = (
        sa.select(
            report.c.uid,
            journal.c.seq,
            report.c.made_utc,
            person.c.name,
            report.c.selection,
            report.c.versions_json,
            journal.c.new_json,
            journal.c.origin_json,
        )
        .join(report, sa.and_(journal.c.entity_uid == report.c.uid, journal.c.action == Action.REPORT))
        .join(person, journal.c.person == person.c.id)
        .order_by(journal.c.seq)
    )
    found = []
    for place, row in enumerate(connection.execute(query), start=1):
        new = json.loads(row.new_json)
        elsewhere = row.origin_json is not None
        about = (json.loads(row.versions_json), new["numbers"], new["folder"], new["files"], elsewhere)
        as_of = report_as_of(row.seq, new, elsewhere)
        found.append(ReportRow(place, row.uid, row.seq, as_of, row.made_utc, row.name, row.selection, *about))
    return found
