"""Rows that one ingested file leaves: the file, how it was read, what the checks found, signals and gaps.

And which files of the store they refer to.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.queries.imported_files import runs_of_file
from data_schema.tables.base import columns_of
from data_schema.tables.files import LAST_READING, file, finding, ingest
from data_schema.tables.journal import config, person
from data_schema.tables.signals import channel, gap, signal
from data_schema.vocabulary import IngestStatus

LEG = ("height_zero_doubtful", "no_stance_found")
"""Rules of a log whose heights do not fit the leg of its run's robot."""

ABOUT_RUNS = (
    "charge_known",
    "charge_contradicts",
    "correction_stands",
    "assignment_stands",
    "jumps_found_not_made",
    "run_contradicts",
    "log_day_differs",
    *LEG,
)
"""Rules of findings that only a book can make, because they compare a file with a run."""


@dataclass(frozen=True, slots=True)
class FirstImport:
    """When and as what the same bytes were imported before."""

    ingest_uid: str
    file_uid: str
    original_name: str
    person: str
    at_utc: str
    runs: tuple[str, ...]


def first_import(connection: sa.Connection, sha256: str) -> FirstImport | None:
    """Return the first import of these bytes, if they were imported."""
    row = connection.execute(
        sa.select(ingest.c.uid, file.c.uid.label("file_uid"), ingest.c.original_name, person.c.name, ingest.c.at_utc)
        .join(person, ingest.c.person == person.c.id)
        .join(file, ingest.c.file == file.c.id)
        .where(ingest.c.sha256 == sha256)
        .order_by(ingest.c.id)
    ).first()
    if row is None:
        return None
    return FirstImport(row.uid, row.file_uid, row.original_name, row.name, row.at_utc, runs_of_file(connection, sha256))


def refused_with(connection: sa.Connection, sha256: str, reader: str, options_json: str) -> list[Any]:
    """Return the settings of each refusal of these bytes by a reader under these options."""
    query = sa.select(ingest.c.declared_json).where(
        ingest.c.sha256 == sha256,
        ingest.c.status == IngestStatus.REFUSED,
        ingest.c.reader == reader,
        ingest.c.options_json == options_json,
    )
    return [json.loads(text) for text in connection.execute(query).scalars()]


def add_ingest(connection: sa.Connection, *, person_name: str, values: Mapping[str, Any]) -> int:
    """Add the row of a file's reading, under the configuration in force; returns its key."""
    done = connection.execute(_ADD_INGEST, {"person_name": person_name, **values})
    return _key(done)


_ADD_INGEST = ingest.insert().values(
    person=sa.select(person.c.id).where(person.c.name == sa.bindparam("person_name")).scalar_subquery(),
    config=sa.select(sa.func.max(config.c.id)).scalar_subquery(),
)
"""Built once: an ingest of many files asks for it for each."""


def add_findings(connection: sa.Connection, ingest_key: int, rows: Sequence[Mapping[str, Any]]) -> None:
    """Add what the checks found."""
    if rows:
        connection.execute(finding.insert(), [{"ingest": ingest_key, **row} for row in rows])


@dataclass(frozen=True, slots=True)
class FindingRow:
    """A finding as it is stored."""

    severity: str
    rule: str
    message: str
    line: int | None
    column_name: str | None
    value: str | None
    n: int
    more_lines: tuple[int, ...]


def findings_of(connection: sa.Connection, ingest_uid: str, rules: Sequence[str] | None = None) -> list[FindingRow]:
    """Return what a reading of a file found, all of it or by some rules."""
    query = (
        sa.select(*columns_of(FindingRow, finding, more_lines=finding.c.more_lines_json))
        .join(ingest, finding.c.ingest == ingest.c.id)
        .where(ingest.c.uid == ingest_uid)
        .order_by(finding.c.id)
    )
    if rules is not None:
        query = query.where(finding.c.rule.in_(rules))
    return [FindingRow(*[*row[:-1], tuple(json.loads(row[-1]))]) for row in connection.execute(query)]


def add_signal(
    connection: sa.Connection,
    values: Mapping[str, Any],
    channels: Sequence[Mapping[str, Any]],
    gaps: Sequence[Mapping[str, Any]],
) -> int:
    """Add a signal of the reading that the transaction adds, with its channels and gaps; returns its key."""
    key = _key(connection.execute(signal.insert(), values))
    connection.execute(channel.insert(), [{"signal": key, **row} for row in channels])
    if gaps:
        connection.execute(gap.insert(), [{"signal": key, **row} for row in gaps])
    return key


def _key(done: sa.CursorResult[Any]) -> int:
    key = done.inserted_primary_key
    assert key is not None  # noqa: S101 - these tables have a private key
    return int(key[0])


@dataclass(frozen=True, slots=True)
class StoredFile:
    """A file of the store that a row refers to: its path there, and the SHA-256 of its content."""

    store_path: str
    sha256: str
    name: str


@dataclass(frozen=True, slots=True)
class Reading:
    """What one reading of a file gave: by which reader, how many rows, and the hashes of its signals."""

    reader: str
    reader_version: int
    rows: dict[str, int]
    signals: list[str]


def raw_copies(connection: sa.Connection) -> list[StoredFile]:
    """List the raw copies of all imported files, under the names that they came with."""
    query = (
        sa.select(file.c.store_path, file.c.sha256, ingest.c.original_name)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
        .order_by(file.c.id)
    )
    return [StoredFile(*row) for row in connection.execute(query)]


def signal_files(connection: sa.Connection) -> list[StoredFile]:
    """List the files of samples, under the names of the files that they were read from; each path once."""
    query = (
        sa.select(signal.c.store_path, signal.c.sha256, ingest.c.original_name)
        .join(ingest, ingest.c.id == signal.c.ingest)
        .order_by(signal.c.id.desc())
    )
    rows = [StoredFile(*row) for row in connection.execute(query)]
    return list({row.store_path: row for row in rows}.values())[::-1]


_COUNTED = ("rows_read", "rows_kept", "rows_rejected")


def readings(connection: sa.Connection) -> dict[str, Reading]:
    """Return what each reading of a file gave, also an earlier one, by the uid of its ingest; refused ones left out."""
    gave = ingest.c.status.not_in((IngestStatus.REFUSED, IngestStatus.WAITING))
    columns = [ingest.c[name] for name in ("id", "uid", "reader", "reader_version", *_COUNTED)]
    heads = connection.execute(sa.select(*columns).where(gave).order_by(ingest.c.id)).all()
    signals: dict[int, list[str]] = {row.id: [] for row in heads}
    for owner, sha256 in connection.execute(sa.select(signal.c.ingest, signal.c.sha256).order_by(signal.c.id)):
        signals[owner].append(sha256)
    return {
        row.uid: Reading(
            row.reader,
            row.reader_version,
            {"read": row.rows_read, "kept": row.rows_kept, "rejected": row.rows_rejected},
            signals[row.id],
        )
        for row in heads
    }
