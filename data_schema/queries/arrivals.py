"""From which entry of the journal each log and charge belonged to which run, and when reports were made."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.tables.files import IN_USE, LAST_READING, file, ingest, run_file
from data_schema.tables.people import journal, person
from data_schema.tables.runs import charge, run
from data_schema.tables.signals import channel, signal
from data_schema.vocabulary import Action, ChargeState, FileRole


@dataclass(frozen=True, slots=True)
class Arrival:
    """A log or a charge that belongs to a run, or did, and the entry with which it came to belong to that.

    `uid` is a log's file or a charge; `file_sha256` and `name` are those of the file, None for a charge that was typed.
    `stays` holds the entries with which it came and left, None where it has not left; what was taken off and put back
    before a report could miss it never left. The entry is that of the last stay; `command` is the same for all that one
    command stated. `read_seq` is the entry that brought it into the book; `moved` tells whether it
    was another run's before.
    """

    run_uid: str
    uid: str
    file_sha256: str | None
    name: str | None
    seq: int
    command: str
    at_utc: str
    person: str
    read_seq: int
    moved: bool
    stays: tuple[tuple[int, int | None], ...]

    @property
    def stayed(self) -> bool:
        """Whether it belongs to the run now."""
        return self.stays[-1][1] is None

    def belonged(self, seq: int) -> bool:
        """Tell whether it belonged to the run at an entry."""
        return any(came <= seq and (left is None or seq < left) for came, left in self.stays)


def log_arrivals(connection: sa.Connection, reports: Sequence[int]) -> list[Arrival]:
    """Return the logs that runs have or had in the order in which they came to them; `reports` as `reports_made`."""
    links = (
        sa.select(run.c.uid, file.c.uid, file.c.uid)
        .join(run, run_file.c.run == run.c.id)
        .join(file, run_file.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, IN_USE))
        .where(run_file.c.role == str(FileRole.LOG))
    )
    logs = (
        sa.select(file.c.uid, file.c.uid)
        .join(ingest, ingest.c.file == file.c.id)
        .where(ingest.c.role == str(FileRole.LOG), LAST_READING)
    )
    return _arrivals(connection, links, logs, reports)


def charge_arrivals(connection: sa.Connection, reports: Sequence[int]) -> list[Arrival]:
    """Return the charges that runs have or had in the order in which they came to them; `reports` as `reports_made`."""
    charges = sa.select(charge.c.uid, file.c.uid).outerjoin(file, charge.c.file == file.c.id)
    of_runs = (
        sa.select(run.c.uid, charge.c.uid, file.c.uid)
        .join(run, charge.c.run == run.c.id)
        .outerjoin(file, charge.c.file == file.c.id)
        .where(charge.c.state == str(ChargeState.COUNTED))
    )
    return _arrivals(connection, of_runs, charges, reports)


def reports_made(connection: sa.Connection) -> list[int]:
    """Return the entries of reports, in order."""
    query = sa.select(journal.c.seq).where(journal.c.action == str(Action.REPORT)).order_by(journal.c.seq)
    return list(connection.execute(query).scalars())


def samples_of_files(connection: sa.Connection, channel_name: str) -> dict[str, frozenset[str]]:
    """Return the SHA-256 of the signals with a channel by the uid of their file, which may belong to no run."""
    query = (
        sa.select(file.c.uid, signal.c.sha256)
        .join(signal, signal.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.id == signal.c.ingest, LAST_READING))
        .join(channel, channel.c.signal == signal.c.id)
        .where(channel.c.name == channel_name)
    )
    found: dict[str, set[str]] = {}
    for uid, sha256 in connection.execute(query):
        found.setdefault(uid, set()).add(sha256)
    return {uid: frozenset(samples) for uid, samples in found.items()}


def _arrivals(
    connection: sa.Connection, belong: sa.Select[Any], every: sa.Select[Any], reports: Sequence[int]
) -> list[Arrival]:
    """Find the entries for each (run, uid, file) that belongs, and each (uid, file) of `every` that was taken off."""
    named, read, declared = _named_with_runs(connection), _read(connection), _declared(connection)
    file_of: dict[str, str] = dict(tuple(row) for row in connection.execute(every))
    left = [(run_uid, uid, file_of[uid]) for uid, run_uid in named if uid in file_of]
    left_runs: dict[str, list[tuple[str, int]]] = {}
    for (uid, run_uid), entries in named.items():
        left_runs.setdefault(uid, []).extend((run_uid, item["seq"]) for item, came in entries if not came)
    found = []
    for run_uid, uid, file_uid in dict.fromkeys([*(tuple(row) for row in connection.execute(belong)), *left]):
        keys = dict.fromkeys([(uid, run_uid), (file_uid, run_uid)])
        said = sorted((item for key in keys for item in named.get(key, ())), key=lambda item: item[0]["seq"])
        in_book = read.get(file_uid)
        if not said or not said[0][1]:
            without = [item for item in (in_book, declared.get(run_uid)) if item]
            said.insert(0, (max(without, key=lambda item: item["seq"]), True))
        entry, stays = _stays(said, reports)
        found.append(
            Arrival(
                run_uid=run_uid,
                uid=uid,
                file_sha256=None if in_book is None else in_book["sha256"],
                name=None if in_book is None else in_book["original_name"],
                seq=entry["seq"],
                command=json.loads(entry["new_json"]).get("batch") or str(entry["seq"] + entry["following"]),
                at_utc=entry["at_utc"],
                person=entry["person"],
                read_seq=entry["seq"] if in_book is None else in_book["seq"],
                moved=any(seq <= entry["seq"] for other, seq in left_runs.get(uid, ()) if other != run_uid),
                stays=stays,
            )
        )
    return sorted(found, key=lambda item: item.seq)


_Said = tuple[sa.RowMapping, bool]
"""An entry that named something together with a run, and whether it gave it to that or took it off."""


def _stays(said: Sequence[_Said], reports: Sequence[int]) -> tuple[sa.RowMapping, tuple[tuple[int, int | None], ...]]:
    """Return the entry with which the last stay began, and all stays; absences that no report saw are left out."""
    entry = said[0][0]
    stays: list[tuple[int, int | None]] = [(entry["seq"], None)]
    for item, came in said[1:]:
        since, left = stays[-1]
        if not came and left is None:
            stays[-1] = (since, item["seq"])
        elif came and left is not None and not any(left < made < item["seq"] for made in reports):
            stays[-1] = (since, None)
        elif came and left is not None:
            entry = item
            stays.append((item["seq"], None))
    return entry, tuple(stays)


_ENTRY = (
    journal.c.seq,
    journal.c.following,
    journal.c.at_utc,
    person.c.name.label("person"),
    journal.c.old_json,
    journal.c.new_json,
)


_MOVING = (Action.ASSIGN, Action.CORRECT, Action.DECLARE, Action.WITHDRAW, Action.RESTORE)


def _named_with_runs(connection: sa.Connection) -> dict[tuple[str, str], list[_Said]]:
    """Return the entries that gave a file or a charge to a run or took it off, by both uids and in order."""
    files = sa.select(run_file.c.uid, file.c.uid).join(file, run_file.c.file == file.c.id)
    file_of: dict[str, str] = dict(tuple(row) for row in connection.execute(files))
    query = (
        sa.select(*_ENTRY, journal.c.entity_uid)
        .join(person, journal.c.person == person.c.id)
        .where(
            journal.c.entity_kind.in_(("file", "run_file", "charge")),
            journal.c.action.in_([str(action) for action in _MOVING]),
        )
        .order_by(journal.c.seq)
    )
    found: dict[tuple[str, str], list[_Said]] = {}
    for row in connection.execute(query).mappings():
        uid = file_of.get(row["entity_uid"], row["entity_uid"])
        old, new = json.loads(row["old_json"] or "{}"), json.loads(row["new_json"] or "{}")
        for words, came in ((old, False), (new, True)):
            for charge_uid, run_uid in words.get("charges", {}).items():
                found.setdefault((charge_uid, run_uid), []).append((row, came))
        for run_uid in old.get("runs", [old.get("run")]):
            if run_uid:
                found.setdefault((uid, run_uid), []).append((row, False))
        for run_uid in new.get("runs", [new.get("run")]):
            if run_uid:
                found.setdefault((uid, run_uid), []).append((row, True))
    return found


def _read(connection: sa.Connection) -> dict[str, sa.RowMapping]:
    """Return the entry with which each file was imported, by the file's uid."""
    query = (
        sa.select(*_ENTRY, file.c.uid, file.c.sha256, ingest.c.original_name)
        .join(person, journal.c.person == person.c.id)
        .join(ingest, ingest.c.uid == journal.c.entity_uid)
        .join(file, ingest.c.file == file.c.id)
        .where(journal.c.action == str(Action.INGEST))
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
