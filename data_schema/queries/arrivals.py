"""By which entry of the journal each log and charge came to the run that it belongs to, and when reports were made."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.tables.files import file, ingest, run_file
from data_schema.tables.people import journal, person
from data_schema.tables.runs import charge, run
from data_schema.vocabulary import Action, FileRole, IngestStatus


@dataclass(frozen=True, slots=True)
class Arrival:
    """A log or a charge of a run, and the entry with which it came to belong to that.

    `uid` is a log's file or a charge; `file_sha256` and `name` are those of the file, None for a charge that was typed.
    `command` is the same for all entries of one command. `read_seq` is the entry that brought it into the book;
    `moved` tells whether it was taken from another run.
    """

    run_uid: str
    uid: str
    file_sha256: str | None
    name: str | None
    seq: int
    command: int
    at_utc: str
    person: str
    read_seq: int
    moved: bool


def log_arrivals(connection: sa.Connection) -> list[Arrival]:
    """Return the logs of runs in the order in which they came to them."""
    links = (
        sa.select(run.c.uid, file.c.uid, run_file.c.uid, file.c.uid)
        .join(run, run_file.c.run == run.c.id)
        .join(file, run_file.c.file == file.c.id)
        .where(run_file.c.role == str(FileRole.LOG))
    )
    return _arrivals(connection, [tuple(row) for row in connection.execute(links)])


def charge_arrivals(connection: sa.Connection) -> list[Arrival]:
    """Return the charges of runs in the order in which they came to them."""
    charges = (
        sa.select(run.c.uid, charge.c.uid, charge.c.uid, file.c.uid)
        .join(run, charge.c.run == run.c.id)
        .outerjoin(file, charge.c.file == file.c.id)
    )
    return _arrivals(connection, [tuple(row) for row in connection.execute(charges)])


def reports_made(connection: sa.Connection) -> list[int]:
    """Return the entries of reports, in order."""
    query = sa.select(journal.c.seq).where(journal.c.action == str(Action.REPORT)).order_by(journal.c.seq)
    return list(connection.execute(query).scalars())


def _arrivals(connection: sa.Connection, belong: list[tuple[Any, ...]]) -> list[Arrival]:
    """Find the entry for each (run, uid, the uid that entries may name beside the file's, file)."""
    explicit, read, declared = _explicit(connection), _read(connection), _declared(connection)
    found = []
    for run_uid, uid, named, file_uid in belong:
        came = [explicit[key] for key in ((named, run_uid), (file_uid, run_uid)) if key in explicit]
        in_book = read.get(file_uid)
        entry = max(came or [item for item in (in_book, declared.get(run_uid)) if item], key=lambda item: item["seq"])
        found.append(
            Arrival(
                run_uid=run_uid,
                uid=uid,
                file_sha256=None if in_book is None else in_book["sha256"],
                name=None if in_book is None else in_book["original_name"],
                seq=entry["seq"],
                command=entry["seq"] + entry["following"],
                at_utc=entry["at_utc"],
                person=entry["person"],
                read_seq=entry["seq"] if in_book is None else in_book["seq"],
                moved=bool(json.loads(entry.get("old_json") or "{}").get("run")),
            )
        )
    return sorted(dict.fromkeys(found), key=lambda item: item.seq)


_ENTRY = (journal.c.seq, journal.c.following, journal.c.at_utc, person.c.name.label("person"))


def _explicit(connection: sa.Connection) -> dict[tuple[str, str], sa.RowMapping]:
    """Return the last entry that named a file, a link or a charge together with a run, by both uids."""
    query = (
        sa.select(*_ENTRY, journal.c.entity_uid, journal.c.old_json, journal.c.new_json)
        .join(person, journal.c.person == person.c.id)
        .where(
            journal.c.entity_kind.in_(("file", "run_file", "charge")),
            journal.c.action.in_((str(Action.ASSIGN), str(Action.CORRECT), str(Action.DECLARE))),
        )
        .order_by(journal.c.seq)
    )
    found: dict[tuple[str, str], sa.RowMapping] = {}
    for row in connection.execute(query).mappings():
        run_uid = json.loads(row["new_json"] or "{}").get("run")
        if run_uid:
            found[row["entity_uid"], run_uid] = row
    return found


def _read(connection: sa.Connection) -> dict[str, sa.RowMapping]:
    """Return the entry with which each file was imported, by the file's uid."""
    query = (
        sa.select(*_ENTRY, file.c.uid, file.c.sha256, ingest.c.original_name)
        .join(person, journal.c.person == person.c.id)
        .join(ingest, ingest.c.uid == journal.c.entity_uid)
        .join(file, ingest.c.file == file.c.id)
        .where(journal.c.action == str(Action.INGEST), ingest.c.status == str(IngestStatus.IMPORTED))
    )
    return {row["uid"]: row for row in connection.execute(query).mappings()}


def _declared(connection: sa.Connection) -> dict[str, sa.RowMapping]:
    """Return the entry that declared each run, whose files may have waited for it."""
    query = (
        sa.select(*_ENTRY, journal.c.entity_uid)
        .join(person, journal.c.person == person.c.id)
        .where(journal.c.entity_kind == "run", journal.c.action == str(Action.DECLARE))
    )
    return {row["entity_uid"]: row for row in connection.execute(query).mappings()}
