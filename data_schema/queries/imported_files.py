"""Imported files as people name them, what belongs to each (runs, charges, signals, parts), and what has no run yet."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.queries.charges import SheetRow, rows_of_file
from data_schema.queries.history import reading_entries
from data_schema.tables.files import IN_USE, LAST_READING, file, ingest, run_file
from data_schema.tables.runs import charge, run
from data_schema.tables.signals import signal
from data_schema.vocabulary import ChargeState, FileRole, IngestStatus


def runs_of_file(connection: sa.Connection, sha256: str) -> tuple[str, ...]:
    """Return the names of all runs of a file, by assignment or by charge rows."""
    counted = charge.c.state == ChargeState.COUNTED
    assigned = sa.select(run.c.name).join(run_file, run_file.c.run == run.c.id).join(file, run_file.c.file == file.c.id)
    charged = sa.select(run.c.name).join(charge, charge.c.run == run.c.id).join(file, charge.c.file == file.c.id)
    both = sa.union(assigned.where(file.c.sha256 == sha256), charged.where(file.c.sha256 == sha256, counted))
    return tuple(sorted(connection.execute(both).scalars()))


def file_keys(connection: sa.Connection) -> dict[str, int]:
    """Return the key of every file by its SHA-256."""
    return {sha256: key for key, sha256 in connection.execute(sa.select(file.c.id, file.c.sha256))}


def runs_by_file(connection: sa.Connection) -> dict[int, tuple[str, ...]]:
    """Return the same for every file of which there are runs, by the file's key."""
    counted = sa.and_(charge.c.run == run.c.id, charge.c.state == ChargeState.COUNTED)
    found: dict[int, list[str]] = {}
    for query in (
        sa.select(run_file.c.file, run.c.name).join(run, run_file.c.run == run.c.id),
        sa.select(charge.c.file, run.c.name).join(run, counted),
    ):
        for key, name in connection.execute(query).all():
            if key in found:
                found[key].append(name)
            else:
                found[key] = [name]
    return {key: tuple(names if len(names) == 1 else sorted({*names})) for key, names in found.items()}


@dataclass(frozen=True, slots=True)
class FileRow:
    """An imported file as people name it; `status` is that of its last reading."""

    uid: str
    name: str
    role: str
    at_utc: str
    sha256: str
    status: IngestStatus


@dataclass(frozen=True, slots=True)
class Link:
    """A part of a file that belongs to a run."""

    uid: str
    file_uid: str
    run_uid: str
    run_name: str
    part: str
    role: str


def _imported() -> sa.Select[Any]:
    return (
        sa.select(file.c.uid, ingest.c.original_name, ingest.c.role, ingest.c.at_utc, file.c.sha256, ingest.c.status)
        .join(file, ingest.c.file == file.c.id)
        .where(LAST_READING)
        .order_by(ingest.c.id)
    )


def find_files(connection: sa.Connection, name: str) -> list[FileRow]:
    """Return the imported files of this name, uid or SHA-256, of which 8 digits will do; withdrawn ones too."""
    matches = [ingest.c.original_name == name, ingest.c.file.in_(sa.select(file.c.id).where(file.c.uid == name))]
    if _BEGINNING.fullmatch(name):
        matches.append(sa.and_(ingest.c.sha256 >= name, ingest.c.sha256 < f"{name}g"))
    rows = [list(row) for row in connection.execute(_imported().where(sa.or_(*matches)))]
    return [FileRow(*[*row[:-1], IngestStatus(row[-1])]) for row in rows]


_BEGINNING = re.compile("[0-9a-f]{8,64}")
"""Enough of a SHA-256 to name a file."""


def imported_names(connection: sa.Connection) -> list[str]:
    """Return the names of all imported files."""
    return [row.original_name for row in connection.execute(_imported())]


def links_of_file(connection: sa.Connection, file_uid: str) -> list[Link]:
    """Return which runs the parts of a file belong to."""
    return _links(connection, _LINKS_OF_FILE, file_uid)


def links_of_run(connection: sa.Connection, run_uid: str) -> list[Link]:
    """Return the parts of files that belong to a run."""
    return _links(connection, _LINKS_OF_RUN, run_uid)


def logs_by_run(connection: sa.Connection) -> dict[str, list[Link]]:
    """Return the logs in use that belong to runs, by the run's uid."""
    found: dict[str, list[Link]] = {}
    for row in connection.execute(_LINKS.join(ingest, sa.and_(ingest.c.file == file.c.id, IN_USE)).where(_IS_LOG)):
        found.setdefault(row[2], []).append(Link(*row))
    return found


def _links(connection: sa.Connection, query: sa.Select[Any], uid: str) -> list[Link]:
    return [Link(*row) for row in connection.execute(query, {"of": uid})]


# Built once: an ingest of many files asks them for each, and building one takes longer than asking it.
_LINKS = (
    sa.select(run_file.c.uid, file.c.uid, run.c.uid, run.c.name, run_file.c.part, run_file.c.role)
    .join(run, run_file.c.run == run.c.id)
    .join(file, run_file.c.file == file.c.id)
    .order_by(run_file.c.id)
)
_LINKS_OF_FILE = _LINKS.where(file.c.uid == sa.bindparam("of"))
_LINKS_OF_RUN = _LINKS.where(run.c.uid == sa.bindparam("of"))
_IS_LOG = run_file.c.role == FileRole.LOG


def charges_of_file(connection: sa.Connection, file_uid: str) -> list[SheetRow]:
    """Return the charges that a file holds, by row, but for those that are gone."""
    return [row for row in rows_of_file(connection, file_uid) if row.state is not ChargeState.GONE]


def place_of_charge(connection: sa.Connection, uid: str) -> str | None:
    """Return the file's name and the row of a charge as NAME#ROW; None where it was typed in."""
    query = (
        sa.select(ingest.c.original_name, charge.c.row_number)
        .join(file, charge.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
        .where(charge.c.uid == uid)
    )
    row = connection.execute(query).first()
    return None if row is None else f"{row.original_name}#{row.row_number}"


def signals_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the SHA-256 of the samples that a file holds, by part."""
    query = (
        sa.select(signal.c.sha256)
        .join(file, signal.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.id == signal.c.ingest, IN_USE))
        .where(file.c.uid == file_uid)
        .order_by(signal.c.part)
    )
    return list(connection.execute(query).scalars())


def unlink_file(connection: sa.Connection, file_uid: str, part: str | None = None) -> None:
    """Let a file, or a part of it, belong to no run; which one it belonged to stands in the journal."""
    connection.execute(_UNLINK_PART if part is not None else _UNLINK, {"file_uid": file_uid, "of": part})


_OF_FILE = run_file.c.file == sa.select(file.c.id).where(file.c.uid == sa.bindparam("file_uid")).scalar_subquery()
_UNLINK = run_file.delete().where(_OF_FILE)
_UNLINK_PART = _UNLINK.where(run_file.c.part == sa.bindparam("of"))


def parts_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the parts of a file's reading that were sampled apart; one without signals has one part, ''.

    Those of a file that waits for a declaration are the ones that the entry of its reading names.
    """
    waiting = sa.and_(ingest.c.file == file.c.id, ingest.c.status == IngestStatus.WAITING)
    sha256 = connection.execute(sa.select(file.c.sha256).join(ingest, waiting).where(file.c.uid == file_uid)).scalar()
    if sha256 is not None:
        return reading_entries(connection, sha256)[-1]["parts"] or [""]
    query = (
        sa.select(signal.c.part)
        .join(file, signal.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.id == signal.c.ingest, IN_USE))
        .where(file.c.uid == file_uid)
        .distinct()
        .order_by(signal.c.part)
    )
    return list(connection.execute(query).scalars()) or [""]


def recorded_parts(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the parts of all readings of a file, as the journal recorded them."""
    sha256 = connection.execute(sa.select(file.c.sha256).where(file.c.uid == file_uid)).scalar_one()
    return list(dict.fromkeys(part for new in reading_entries(connection, sha256) for part in new["parts"] or [""]))


def unassigned_charges_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the uids of a file's charges that belong to no run yet."""
    query = (
        sa.select(charge.c.uid)
        .join(file, charge.c.file == file.c.id)
        .where(file.c.uid == file_uid, charge.c.run.is_(None), charge.c.state == ChargeState.COUNTED)
        .order_by(charge.c.row_number)
    )
    return list(connection.execute(query).scalars())


@dataclass(frozen=True, slots=True)
class InboxItem:
    """A file, or a row of a charger sheet, that belongs to no run yet."""

    what: str
    name: str
    stated_run: str | None
    detail: str


_NEVER_WAITING = (FileRole.CHARGE, FileRole.SHEET)


def inbox(connection: sa.Connection) -> list[InboxItem]:
    """List the imported files and charge rows whose run is unknown, oldest first; a charger's file is its charges.

    Sheets of studies belong to no run.
    """
    linked = sa.select(run_file.c.id).where(run_file.c.file == file.c.id)  # asked by its index, file by file
    files = connection.execute(
        sa.select(ingest.c.original_name, ingest.c.stated_run, file.c.uid, ingest.c.reader, ingest.c.rows_kept)
        .join(file, ingest.c.file == file.c.id)
        .where(IN_USE)
        .where(~linked.exists(), ingest.c.role.not_in(_NEVER_WAITING))
        .order_by(ingest.c.id)
    )
    items = [
        InboxItem("file", row.original_name, row.stated_run, f"{row.reader}, {row.rows_kept} rows, {row.uid}")
        for row in files
    ]
    items += _loose_parts(connection)
    charges = connection.execute(
        sa.select(charge.c.uid, charge.c.row_number, charge.c.stated_run, charge.c.charge_mah, ingest.c.original_name)
        .join(file, charge.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, IN_USE))
        .where(charge.c.run.is_(None), charge.c.state == ChargeState.COUNTED)
        .order_by(charge.c.id)
    )
    items += [
        InboxItem(
            "charge", f"{row.original_name}#{row.row_number}", row.stated_run, f"{row.charge_mah:g} mAh, {row.uid}"
        )
        for row in charges
    ]
    return items


def _loose_parts(connection: sa.Connection) -> list[InboxItem]:
    """List the parts without a run of files whose other parts have one."""
    linked = sa.select(run_file.c.id).where(run_file.c.file == file.c.id, run_file.c.part == signal.c.part)
    rows = connection.execute(
        sa.select(ingest.c.original_name, signal.c.part, signal.c.n_samples, file.c.uid, ingest.c.reader)
        .join(file, signal.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.id == signal.c.ingest, IN_USE))
        .where(file.c.id.in_(sa.select(run_file.c.file)), ~linked.exists())
        .where(ingest.c.role != FileRole.CHARGE)
        .order_by(signal.c.id)
    )
    return [
        InboxItem("part", f"{row.original_name}#{row.part}", None, f"{row.reader}, {row.n_samples} rows, {row.uid}")
        for row in rows
    ]


def files_naming(connection: sa.Connection, run_name: str) -> list[tuple[str, str]]:
    """Return the unassigned files that name a run of this name, each with its role."""
    return [(row.uid, row.role) for row in connection.execute(_WAITING_FILES, {"named": run_name})]


# Built once: a sheet states thousands of runs, and each is asked for what waits for it.
_WAITING_FILES = (
    sa.select(file.c.uid, ingest.c.role)
    .join(ingest, ingest.c.file == file.c.id)
    .where(ingest.c.stated_run == sa.bindparam("named"), IN_USE)
    .where(file.c.id.not_in(sa.select(run_file.c.file)))
    .order_by(file.c.id)
)
