"""`labbook rebuild`: raw copies and journal are the truth, everything else follows from them.

Every entry is applied again, in order, by the functions that applied it the first time. The new database replaces the
old one only when it is complete; the old one is renamed, never deleted.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import sqlite3
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal, migrations
from data_schema.engine import reading, sqlite_engine, writing
from data_schema.errors import BookBusy, BookDamaged, UsageError
from data_schema.journal import Entry, JournalFile
from ingest.store import Store, sync_folder
from labbook.book.desk import apply
from labbook.book.making import make_database, make_sqlite
from labbook.book.opening import (
    DATABASE,
    check_revision,
    engine_of,
    journal_path,
    open_book,
    read_configuration,
    store_of,
)
from labbook.config.parsing import Configuration


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
    """Write journal.jsonl anew from the database, where the file was lost, cut or damaged; returns how many entries.

    A file that was damaged is kept beside the new one.
    """
    configuration = read_configuration(folder)
    path = journal_path(folder, configuration)
    engine = engine_of(folder, configuration)
    try:
        check_revision(engine)
        with writing(engine) as connection:  # alone, so that nobody appends to the old file meanwhile
            entries = list(journal.chained(journal.stored(connection)))
            _replace_journal(path, entries)
    finally:
        engine.dispose()
    return len(entries)


def _replace_journal(path: Path, entries: list[Entry]) -> None:
    known = _known(path)
    if known is not None and known != [entry.hash for entry in entries[: len(known)]]:
        raise BookDamaged(
            f"{path} holds entries that the database does not have: keep both, and restore the right one from a backup."
        )
    fresh = JournalFile(path.with_name(f".{path.name}.{secrets.token_hex(4)}"))
    fresh.path.touch()
    fresh.append(entries)
    if known is None:
        path.rename(path.with_name(f"{path.name}.before-rebuild.{_stamp()}"))
    fresh.path.rename(path)
    sync_folder(path.parent)


def replay(engine: sa.Engine, store: Store, entries: list[Entry], step: Callable[[str], None]) -> None:
    """Apply entries to an empty database, one transaction each, as they were first made."""
    for entry in entries:
        with writing(engine) as connection:
            apply(connection, store, entry)
        step(f"{entry.seq}/{entries[-1].seq} {entry.action} {entry.entity_kind}")


def _known(path: Path) -> list[str] | None:
    """Return the hashes in a journal file; None where it is damaged."""
    if not path.exists():
        return []
    try:
        return [entry.hash for entry in JournalFile(path).entries()]
    except BookDamaged:
        return None


def _stamp() -> str:
    return datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")


def _rebuild_sqlite(folder: Path, store: Store, entries: list[Entry], step: Callable[[str], None]) -> Rebuilt:
    _remove_leftovers(folder)
    _fold_in(folder / DATABASE)
    fresh = folder / f".{DATABASE}.rebuild.{secrets.token_hex(4)}"
    try:
        make_sqlite(fresh)
        engine = sqlite_engine(fresh)
        try:
            replay(engine, store, entries, step)
        finally:
            engine.dispose()
        _fold_in(folder / DATABASE)
        old = _set_aside(folder)
        fresh.rename(folder / DATABASE)
        sync_folder(folder)
    finally:
        _remove_leftovers(folder)
    open_book(folder).close()
    return Rebuilt(len(entries), old)


def _remove_leftovers(folder: Path) -> None:
    """Remove databases that were never finished, of this rebuild or of one that was interrupted."""
    for pattern in (f".{DATABASE}.*", f"..{DATABASE}.*"):
        for leftover in folder.glob(pattern):
            leftover.unlink()


def _fold_in(path: Path) -> None:
    """Bring the write-ahead log of the old database into its one file; refused while others have it open.

    A log that was left beside the new database would be read as belonging to it.
    """
    if not path.exists():
        return
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as connection:
        try:
            connection.execute("PRAGMA journal_mode = delete")
        except sqlite3.OperationalError as error:
            raise BookBusy(f"another program has {path} open: close it and run `labbook rebuild` again.") from error
        except sqlite3.DatabaseError:
            return  # damaged: what can be read of it does not matter, it is made anew


def _set_aside(folder: Path) -> str | None:
    """Give the old database another name; what is left of its log goes with it, also where the file itself is gone."""
    path = folder / DATABASE
    old = f"{DATABASE}.before-rebuild.{_stamp()}"
    for suffix in ("-wal", "-shm"):
        piece = folder / f"{DATABASE}{suffix}"
        if piece.exists():
            piece.rename(folder / f"{old}{suffix}")
    if not path.exists():
        return None
    try:
        os.link(path, folder / old)  # so that at no moment there is none
    except OSError:
        path.rename(folder / old)
    return old


def _rebuild_postgres(
    folder: Path, configuration: Configuration, store: Store, entries: list[Entry], step: Callable[[str], None]
) -> Rebuilt:
    """PostgreSQL: into an empty database, or one whose rebuild was interrupted; any other is its owner's business."""
    engine = engine_of(folder, configuration)
    try:
        done = _entries_there(engine, entries)
        if done is None:
            make_database(folder, configuration)
        replay(engine, store, entries[done or 0 :], step)
    finally:
        engine.dispose()
    return Rebuilt(len(entries), None)


def _entries_there(engine: sa.Engine, entries: list[Entry]) -> int | None:
    """Return how many entries an interrupted rebuild has applied; None for any other database."""
    with reading(engine) as connection:
        if migrations.current(connection) != migrations.newest():
            return None
        seq, last_hash = journal.head(connection)
    begun = seq < len(entries) and last_hash == (entries[seq - 1].hash if seq else journal.GENESIS)
    return seq if begun else None
