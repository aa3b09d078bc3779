"""`labbook rebuild`: raw copies and journal are the truth, everything else follows from them.

Every entry is applied again, in order, by the functions that applied it the first time. The new database replaces the
old one only when it is complete; the old one is renamed, never deleted.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import reading, sqlite_engine, writing
from data_schema.errors import BookDamaged, UsageError
from data_schema.journal import Entry, JournalFile
from ingest.store import Store, sync_folder
from labbook.book import DATABASE, engine_of, journal_path, open_book, read_configuration, store_of
from labbook.config import Configuration
from labbook.desk import apply
from labbook.making import make_database, make_sqlite


@dataclass(frozen=True, slots=True)
class Rebuilt:
    """How many entries were applied, and what the old database is called now."""

    entries: int
    old: str | None


def rebuild_database(folder: Path, step: Callable[[str], None]) -> Rebuilt:
    """Make the database anew; an interrupted rebuild leaves the old one in place."""
    configuration = read_configuration(folder)
    mirror = JournalFile(journal_path(folder, configuration))
    entries = list(mirror.entries())
    if not entries:
        raise UsageError(
            f"{mirror.path} holds no entry: there is nothing to rebuild from; `labbook init` makes a book."
        )
    store = store_of(folder, configuration)
    if configuration.database_url:
        return _rebuild_postgres(folder, configuration, store, entries, step)
    return _rebuild_sqlite(folder, store, entries, step)


def rewrite_journal(folder: Path) -> int:
    """Write journal.jsonl anew from the database, where the file was lost or cut; returns the number of entries."""
    configuration = read_configuration(folder)
    path = journal_path(folder, configuration)
    engine = engine_of(folder, configuration)
    try:
        with reading(engine) as connection:
            entries = list(journal.chained(journal.stored(connection)))
    finally:
        engine.dispose()
    known = _known(path)
    if len(known) > len(entries) or known != [entry.hash for entry in entries[: len(known)]]:
        raise BookDamaged(
            f"{path} holds entries that the database does not have: keep both, and restore the right one from a backup."
        )
    fresh = JournalFile(path.with_name(f".{path.name}.{secrets.token_hex(4)}"))
    fresh.path.touch()
    fresh.append(entries)
    fresh.path.rename(path)
    sync_folder(path.parent)
    return len(entries)


def replay(engine: sa.Engine, store: Store, entries: list[Entry], step: Callable[[str], None]) -> None:
    """Apply entries to an empty database, one transaction each, as they were first made."""
    for entry in entries:
        with writing(engine) as connection:
            apply(connection, store, entry)
        step(f"{entry.seq}/{len(entries)} {entry.action} {entry.entity_kind}")


def _known(path: Path) -> list[str]:
    if not path.exists():
        return []
    try:
        return [entry.hash for entry in JournalFile(path).entries()]
    except BookDamaged:
        return []


def _rebuild_sqlite(folder: Path, store: Store, entries: list[Entry], step: Callable[[str], None]) -> Rebuilt:
    fresh = folder / f".{DATABASE}.rebuild.{secrets.token_hex(4)}"
    try:
        make_sqlite(fresh)
        engine = sqlite_engine(fresh)
        try:
            replay(engine, store, entries, step)
            with engine.connect() as connection:
                connection.exec_driver_sql("COMMIT")
                connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
        finally:
            engine.dispose()
        old = _set_aside(folder)
        fresh.rename(folder / DATABASE)
        sync_folder(folder)
    finally:
        for leftover in folder.glob(f"{fresh.name}*"):
            leftover.unlink()
    open_book(folder).close()
    return Rebuilt(len(entries), old)


def _set_aside(folder: Path) -> str | None:
    path = folder / DATABASE
    if not path.exists():
        return None
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    old = f"{DATABASE}.before-rebuild.{stamp}"
    for suffix in ("-wal", "-shm", ""):
        piece = folder / f"{DATABASE}{suffix}"
        if piece.exists():
            piece.rename(folder / f"{old}{suffix}")
    return old


def _rebuild_postgres(
    folder: Path, configuration: Configuration, store: Store, entries: list[Entry], step: Callable[[str], None]
) -> Rebuilt:
    """PostgreSQL: into an empty database only; dropping a shared one is its owner's business."""
    make_database(folder, configuration)
    engine = engine_of(folder, configuration)
    try:
        replay(engine, store, entries, step)
    finally:
        engine.dispose()
    return Rebuilt(len(entries), None)
