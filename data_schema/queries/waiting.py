"""Files and charges whose run is not known: the inbox, and what waits for a run of some name."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.files import IN_USE, file, ingest, run_file
from data_schema.tables.runs import charge
from data_schema.tables.signals import signal
from data_schema.vocabulary import ChargeState, FileRole


@dataclass(frozen=True, slots=True)
class InboxItem:
    """A file, or a row of a charger sheet, that belongs to no run yet."""

    what: str
    name: str
    stated_run: str | None
    detail: str


def inbox(connection: sa.Connection) -> list[InboxItem]:
    """List the imported files and charge rows whose run is unknown, oldest first; a charger's file is its charges."""
    with_run = sa.select(run_file.c.file)
    files = connection.execute(
        sa.select(ingest.c.original_name, ingest.c.stated_run, file.c.uid, ingest.c.reader, ingest.c.rows_kept)
        .join(file, ingest.c.file == file.c.id)
        .where(IN_USE)
        .where(file.c.id.not_in(with_run), ingest.c.role != str(FileRole.CHARGE))
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
        .where(charge.c.run.is_(None), charge.c.state == str(ChargeState.COUNTED))
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
        .where(ingest.c.role != str(FileRole.CHARGE))
        .order_by(signal.c.id)
    )
    return [
        InboxItem("part", f"{row.original_name}#{row.part}", None, f"{row.reader}, {row.n_samples} rows, {row.uid}")
        for row in rows
    ]


def waiting_for_run(connection: sa.Connection, run_name: str) -> tuple[list[tuple[str, str]], list[tuple[str, bool]]]:
    """Return the unassigned files (uid, role) and charges that were said to belong to a run of this name.

    Charges are (uid, whether it may be the second of its run): earlier labbooks gave a run all that named it.
    """
    files = connection.execute(_WAITING_FILES, {"named": run_name}).all()
    charges = connection.execute(_WAITING_CHARGES, {"named": run_name}).all()
    return [(row.uid, row.role) for row in files], [(row.uid, row.declared_json is None) for row in charges]


# Built once: a sheet states thousands of runs, and each is asked for what waits for it.
_WAITING_FILES = (
    sa.select(file.c.uid, ingest.c.role)
    .join(ingest, ingest.c.file == file.c.id)
    .where(ingest.c.stated_run == sa.bindparam("named"), IN_USE)
    .where(file.c.id.not_in(sa.select(run_file.c.file)))
    .order_by(file.c.id)
)

_WAITING_CHARGES = (
    sa.select(charge.c.uid, ingest.c.declared_json)
    .outerjoin(ingest, sa.and_(ingest.c.file == charge.c.file, IN_USE))
    .where(
        charge.c.stated_run == sa.bindparam("named"),
        charge.c.run.is_(None),
        charge.c.state == str(ChargeState.COUNTED),
    )
    .order_by(charge.c.id)
)
