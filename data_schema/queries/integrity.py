"""What the tables say that lies in the store, and how each file was read."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.files import LAST_READING, file, ingest
from data_schema.tables.signals import signal
from data_schema.vocabulary import IngestStatus


@dataclass(frozen=True, slots=True)
class KeptFile:
    """A file of the store that a row speaks of: its path there, and the SHA-256 of what it holds."""

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


def raw_copies(connection: sa.Connection) -> list[KeptFile]:
    """List the raw copies of all imported files, under the names that they came with."""
    query = (
        sa.select(file.c.store_path, file.c.sha256, ingest.c.original_name)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
        .order_by(file.c.id)
    )
    return [KeptFile(*row) for row in connection.execute(query)]


def signal_files(connection: sa.Connection) -> list[KeptFile]:
    """List the files of samples, under the names of the files that they were read from; each path once."""
    query = (
        sa.select(signal.c.store_path, signal.c.sha256, ingest.c.original_name)
        .join(ingest, ingest.c.id == signal.c.ingest)
        .order_by(signal.c.id.desc())
    )
    rows = [KeptFile(*row) for row in connection.execute(query)]
    return list({row.store_path: row for row in rows}.values())[::-1]


_COUNTED = ("rows_read", "rows_kept", "rows_rejected")


def readings(connection: sa.Connection) -> dict[str, Reading]:
    """Return what each reading of a file gave, also an earlier one, by the uid of its ingest; refused ones left out."""
    gave = ingest.c.status.not_in((str(IngestStatus.REFUSED), str(IngestStatus.WAITING)))
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
