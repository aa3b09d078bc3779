"""Rows that one ingested file leaves: the file, how it was read, findings, signals, gaps, charges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.tables.files import file, finding, ingest, run_file
from data_schema.tables.people import config, person
from data_schema.tables.runs import charge, run
from data_schema.tables.signals import channel, gap, signal
from data_schema.vocabulary import FileRole, FileState, IngestStatus

ABOUT_RUNS = ("charge_known", "charge_contradicts", "jumps_found_not_made")
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


@dataclass(frozen=True, slots=True)
class InboxItem:
    """A file, or a row of a charger sheet, that belongs to no run yet."""

    what: str
    name: str
    stated_run: str | None
    detail: str


def first_import(connection: sa.Connection, sha256: str) -> FirstImport | None:
    """Return the import of these bytes, if they were imported."""
    row = connection.execute(
        sa.select(ingest.c.uid, file.c.uid.label("file_uid"), ingest.c.original_name, person.c.name, ingest.c.at_utc)
        .join(person, ingest.c.person == person.c.id)
        .join(file, ingest.c.file == file.c.id)
        .where(ingest.c.sha256 == sha256, ingest.c.status == str(IngestStatus.IMPORTED))
    ).first()
    if row is None:
        return None
    return FirstImport(row.uid, row.file_uid, row.original_name, row.name, row.at_utc, runs_of_file(connection, sha256))


def runs_of_file(connection: sa.Connection, sha256: str) -> tuple[str, ...]:
    """Return the names of all runs that a file says something about, by assignment or by charge rows."""
    assigned = sa.select(run.c.name).join(run_file, run_file.c.run == run.c.id).join(file, run_file.c.file == file.c.id)
    charged = sa.select(run.c.name).join(charge, charge.c.run == run.c.id).join(file, charge.c.file == file.c.id)
    both = sa.union(assigned.where(file.c.sha256 == sha256), charged.where(file.c.sha256 == sha256))
    return tuple(sorted(connection.execute(both).scalars()))


def refused_before(connection: sa.Connection, sha256: str, reader: str, options_json: str) -> bool:
    """Tell whether the same bytes were refused by the same reader and options before."""
    query = sa.select(sa.func.count()).where(
        ingest.c.sha256 == sha256,
        ingest.c.status == str(IngestStatus.REFUSED),
        ingest.c.reader == reader,
        ingest.c.options_json == options_json,
    )
    return bool(connection.execute(query).scalar_one())


def add_file(connection: sa.Connection, *, uid: str, sha256: str, n_bytes: int, store_path: str) -> int:
    """Add the row of a raw copy; returns its key."""
    done = connection.execute(
        file.insert().values(uid=uid, sha256=sha256, n_bytes=n_bytes, store_path=store_path, state=str(FileState.KEPT))
    )
    return _key(done)


def add_ingest(connection: sa.Connection, *, person_name: str, values: Mapping[str, Any]) -> int:
    """Add the row that says how a file was read, under the configuration in force; returns its key."""
    newest_config = sa.select(sa.func.max(config.c.id)).scalar_subquery()
    speaker = sa.select(person.c.id).where(person.c.name == person_name).scalar_subquery()
    done = connection.execute(ingest.insert().values(person=speaker, config=newest_config, **values))
    return _key(done)


def add_findings(connection: sa.Connection, ingest_key: int, rows: Sequence[Mapping[str, Any]]) -> None:
    """Add what the checks found."""
    if rows:
        connection.execute(finding.insert(), [{"ingest": ingest_key, **row} for row in rows])


def findings_about_runs(connection: sa.Connection, ingest_uid: str) -> list[tuple[str, str, str | None]]:
    """Return (rule, message, value) of what a file says against or beside the facts of its runs."""
    query = (
        sa.select(finding.c.rule, finding.c.message, finding.c.value)
        .join(ingest, finding.c.ingest == ingest.c.id)
        .where(ingest.c.uid == ingest_uid, finding.c.rule.in_(ABOUT_RUNS))
        .order_by(finding.c.id)
    )
    return [(row.rule, row.message, row.value) for row in connection.execute(query)]


def add_signal(
    connection: sa.Connection,
    values: Mapping[str, Any],
    channels: Sequence[Mapping[str, Any]],
    gaps: Sequence[Mapping[str, Any]],
) -> int:
    """Add a signal with its channels and gaps; returns its key."""
    key = _key(connection.execute(signal.insert().values(**values)))
    connection.execute(channel.insert(), [{"signal": key, **row} for row in channels])
    if gaps:
        connection.execute(gap.insert(), [{"signal": key, **row} for row in gaps])
    return key


@dataclass(frozen=True, slots=True)
class FileRow:
    """An imported file as people name it."""

    uid: str
    name: str
    role: str
    at_utc: str


@dataclass(frozen=True, slots=True)
class Link:
    """A part of a file that belongs to a run."""

    uid: str
    run_uid: str
    run_name: str


@dataclass(frozen=True, slots=True)
class ChargeRef:
    """A charge of a file and the run it belongs to."""

    uid: str
    run_uid: str | None
    run_name: str | None
    row_number: int


def _imported() -> sa.Select[Any]:
    return (
        sa.select(file.c.uid, ingest.c.original_name, ingest.c.role, ingest.c.at_utc)
        .join(file, ingest.c.file == file.c.id)
        .where(ingest.c.status == str(IngestStatus.IMPORTED))
        .order_by(ingest.c.id)
    )


def find_files(connection: sa.Connection, name: str) -> list[FileRow]:
    """Return the imported files of this name, uid or SHA-256."""
    matches = sa.or_(ingest.c.original_name == name, file.c.uid == name, file.c.sha256 == name)
    return [FileRow(*row) for row in connection.execute(_imported().where(matches))]


def imported_names(connection: sa.Connection) -> list[str]:
    """Return the names of all imported files."""
    return [row.original_name for row in connection.execute(_imported())]


def links_of_file(connection: sa.Connection, file_uid: str) -> list[Link]:
    """Return which runs the parts of a file belong to."""
    query = (
        sa.select(run_file.c.uid, run.c.uid, run.c.name)
        .join(run, run_file.c.run == run.c.id)
        .join(file, run_file.c.file == file.c.id)
        .where(file.c.uid == file_uid)
        .order_by(run_file.c.id)
    )
    return [Link(*row) for row in connection.execute(query)]


def charges_of_file(connection: sa.Connection, file_uid: str) -> list[ChargeRef]:
    """Return the charges that a file holds, by row."""
    query = (
        sa.select(charge.c.uid, run.c.uid, run.c.name, charge.c.row_number)
        .join(file, charge.c.file == file.c.id)
        .outerjoin(run, charge.c.run == run.c.id)
        .where(file.c.uid == file_uid)
        .order_by(charge.c.row_number)
    )
    return [ChargeRef(*row) for row in connection.execute(query)]


def signals_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the SHA-256 of the samples that a file holds, by part."""
    query = (
        sa.select(signal.c.sha256)
        .join(file, signal.c.file == file.c.id)
        .where(file.c.uid == file_uid)
        .order_by(signal.c.part)
    )
    return list(connection.execute(query).scalars())


def unlink_file(connection: sa.Connection, file_uid: str) -> None:
    """Let a file belong to no run; which one it belonged to stands in the journal."""
    of_file = sa.select(file.c.id).where(file.c.uid == file_uid).scalar_subquery()
    connection.execute(run_file.delete().where(run_file.c.file == of_file))


def inbox(connection: sa.Connection) -> list[InboxItem]:
    """List the imported files and charge rows whose run is unknown, oldest first; a charger's file is its charges."""
    with_run = sa.select(run_file.c.file)
    files = connection.execute(
        sa.select(ingest.c.original_name, ingest.c.stated_run, file.c.uid, ingest.c.reader, ingest.c.rows_kept)
        .join(file, ingest.c.file == file.c.id)
        .where(ingest.c.status == str(IngestStatus.IMPORTED))
        .where(file.c.id.not_in(with_run), ingest.c.role != str(FileRole.CHARGE))
        .order_by(ingest.c.id)
    )
    items = [
        InboxItem("file", row.original_name, row.stated_run, f"{row.reader}, {row.rows_kept} rows, {row.uid}")
        for row in files
    ]
    charges = connection.execute(
        sa.select(charge.c.uid, charge.c.row_number, charge.c.stated_run, charge.c.charge_mah, ingest.c.original_name)
        .join(file, charge.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, ingest.c.status == str(IngestStatus.IMPORTED)))
        .where(charge.c.run.is_(None))
        .order_by(charge.c.id)
    )
    items += [
        InboxItem(
            "charge", f"{row.original_name}#{row.row_number}", row.stated_run, f"{row.charge_mah:g} mAh, {row.uid}"
        )
        for row in charges
    ]
    return items


def waiting_for_run(connection: sa.Connection, run_name: str) -> tuple[list[tuple[str, str]], list[str]]:
    """Return the unassigned files (uid, role) and charges (uid) that were said to belong to a run of this name."""
    files = connection.execute(_WAITING_FILES, {"named": run_name}).all()
    charges = connection.execute(_WAITING_CHARGES, {"named": run_name}).scalars()
    return [(row.uid, row.role) for row in files], list(charges)


# Built once: a sheet states thousands of runs, and each is asked for what waits for it.
_WAITING_FILES = (
    sa.select(file.c.uid, ingest.c.role)
    .join(ingest, ingest.c.file == file.c.id)
    .where(ingest.c.stated_run == sa.bindparam("named"), ingest.c.status == str(IngestStatus.IMPORTED))
    .where(file.c.id.not_in(sa.select(run_file.c.file)))
    .order_by(file.c.id)
)
_WAITING_CHARGES = (
    sa.select(charge.c.uid)
    .where(charge.c.stated_run == sa.bindparam("named"), charge.c.run.is_(None))
    .order_by(charge.c.id)
)


def parts_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the parts of a file that were sampled apart; a file without signals has one part, ''."""
    query = (
        sa.select(signal.c.part)
        .join(file, signal.c.file == file.c.id)
        .where(file.c.uid == file_uid)
        .distinct()
        .order_by(signal.c.part)
    )
    return list(connection.execute(query).scalars()) or [""]


def unassigned_charges_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the uids of a file's charges that belong to no run yet."""
    query = (
        sa.select(charge.c.uid)
        .join(file, charge.c.file == file.c.id)
        .where(file.c.uid == file_uid, charge.c.run.is_(None))
        .order_by(charge.c.row_number)
    )
    return list(connection.execute(query).scalars())


def _key(done: sa.CursorResult[Any]) -> int:
    key = done.inserted_primary_key
    assert key is not None  # noqa: S101 - these tables have a private key
    return int(key[0])
