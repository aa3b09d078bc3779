"""`labbook rebuild`: raw copies and journal are the truth, everything else follows from them.

Every entry is applied again, in order, by the functions that applied it the first time. The new database takes the
place of the old one only when it is complete, in one transaction and with nobody writing meanwhile; the old one is kept
under another name, never deleted.
"""

from __future__ import annotations

import contextlib
import secrets
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import exclusive_lock, stamp, sync, write_whole
from data_schema.engine import postgres_engine, reading, sqlite_engine, writing
from data_schema.errors import BookDamaged, BookError, UsageError
from data_schema.journal import Entry
from data_schema.journal_file import JournalFile, LeftOut
from data_schema.schema import SCHEMA, schema_of
from labbook.book.altered import AlteredRow, altered_rows, but_of_readings, with_reports
from labbook.book.differing import Differences, differences
from labbook.book.making import fill_sqlite
from labbook.book.opening import (
    CONFIGURATION,
    DATABASE,
    check_schema,
    engine_of,
    journal_path,
    read_configuration,
    store_of,
)
from labbook.book.replacing_postgres import replace_postgres
from labbook.book.replacing_sqlite import head_of_sqlite, remove_leftovers, replace_sqlite, set_aside
from labbook.book.replaying import Replay
from labbook.config.places import with_database

REBUILDING = "another program is rebuilding this book: wait until it has finished."
"""A second one would remove what the first has made so far."""


@dataclass(frozen=True, slots=True)
class Rebuilt:
    """How many entries were applied, where the old database is kept, and what differs from before.

    `left_out` is what stands at the end of the journal file and is no complete command. `altered` are the first of the
    `n_altered` rows of the old database that were not what labbook had written there.
    """

    entries: int
    old: str | None
    differences: Differences
    left_out: LeftOut
    n_altered: int = 0
    altered: tuple[AlteredRow, ...] = ()

    @property
    def sentences(self) -> list[str]:
        """Return sentences on what differs, what had been altered, and what does not count."""
        found = [*self.differences.sentences, *(rows.sentence for rows in self.altered)]
        if self.n_altered > len(self.altered):
            found.append(f"{self.n_altered - len(self.altered)} more were altered in the old database.")
        return [*found, *([self.left_out.sentence] if self.left_out.sentence else [])]


@dataclass(frozen=True, slots=True)
class Place:
    """Where the database of a book goes: to a PostgreSQL database of this address, or to labbook.db in the book."""

    url: str | None


def rebuild_database(folder: Path, step: Callable[[str], None], place: Place | None = None) -> Rebuilt:
    """Make the database anew, where it is or in another `place`; an interrupted rebuild leaves the old one in use.

    A book that goes to another place is there once its labbook.toml says so, which is written last.
    """
    configuration = read_configuration(folder)
    url = configuration.database.url if place is None else place.url
    moves = url != configuration.database.url
    moved = with_database(configuration.text, url) if moves else ""  # refused, if it is, before all the work
    mirror = JournalFile(journal_path(folder, configuration))
    if mirror.last() is None:
        raise UsageError(
            f"{mirror.path} holds no entry: there is nothing to rebuild from; `labbook init` makes a book."
        )
    replay = Replay(store_of(folder, configuration), mirror, step)
    with exclusive_lock(mirror.path, REBUILDING):
        old = _rebuild_sqlite(folder, replay) if url is None else replace_postgres(url, replay.apply_to, replay.finish)
        if moves:
            write_whole(folder / CONFIGURATION, moved.encode())
            if configuration.database.url is None:
                old = set_aside(folder) or old
    engine = engine_of(folder, read_configuration(folder))
    try:
        with reading(engine) as connection:
            found = differences(connection, journal.stored(connection), replay.without_rows)
            store = replay.store.root
            altered = (0, ()) if old is None or moves else _altered(folder, store, url, old, connection, found)
    finally:
        engine.dispose()
    return Rebuilt(len(replay.hashes), old, found, replay.left_out, *altered)


def _altered(
    folder: Path, store: Path, url: str | None, old: str, fresh: sa.Connection, found: Differences
) -> tuple[int, tuple[AlteredRow, ...]]:
    """Compare rows of the old database with the new ones; none where it is too damaged, or of another schema.

    Where other versions of readers made it, only what no reading gives.
    """
    engine = postgres_engine(url, schema=old) if url else sqlite_engine(folder / old)
    try:
        with reading(engine) as connection:
            if schema_of(connection) != SCHEMA:
                return 0, ()
            altered = altered_rows(connection, fresh)
            if found.other_versions:
                altered = but_of_readings(altered)
            return len(altered), tuple(with_reports(store, connection, fresh, altered))
    except (BookError, sa.exc.DBAPIError):
        return 0, ()
    finally:
        engine.dispose()


def _rebuild_sqlite(folder: Path, replay: Replay) -> str | None:
    remove_leftovers(folder)
    path, fresh = folder / DATABASE, folder / f".{DATABASE}.rebuild.{secrets.token_hex(4)}"
    try:
        fill_sqlite(fresh)
        engine = sqlite_engine(fresh, scratch=True)
        try:
            replay.apply_to(engine)
        finally:
            engine.dispose()  # which brings its write-ahead log into the one file

        def finish() -> None:
            last = sqlite_engine(fresh, scratch=True)
            try:
                replay.finish(last, head_of_sqlite(path))
            finally:
                last.dispose()
            sync(fresh)

        return replace_sqlite(folder, fresh, finish)
    finally:
        remove_leftovers(folder)


def rewrite_journal(folder: Path) -> int:
    """Write journal.jsonl anew from the database, where the file was lost, cut or damaged; returns how many entries.

    A file that was damaged is kept beside the new one, and so is what was cut off at the end of one that was not.
    """
    configuration = read_configuration(folder)
    path = journal_path(folder, configuration)
    engine = engine_of(folder, configuration)
    try:
        check_schema(engine)
        with writing(engine) as connection:  # alone, so that nobody appends to the old file meanwhile
            remedy = journal.MEND_BOTH if path.exists() and _known(path) is None else journal.MEND_TABLE
            entries = list(journal.verified_chain(journal.stored(connection), remedy=remedy))
            _replace_journal(path, entries)
    finally:
        engine.dispose()
    return len(entries)


def _replace_journal(path: Path, entries: list[Entry]) -> None:
    known = _known(path)
    beyond = 0 if known is not None else _readable_beyond(path, entries[-1].seq if entries else 0)
    if beyond:
        raise BookDamaged(
            f"{path} is damaged, and {beyond} of its entries that can be read are not in the database: restore a "
            "backup that has them, or move the file away, which gives them up, and give the command again."
        )
    if known is not None and known != [entry.hash for entry in entries[: len(known)]]:
        raise BookDamaged(
            f"{path} holds entries that the database does not have: the two belong to different books, or one is older "
            "than the other; put the right file there from a backup, or move this one away and give the command again."
        )
    fresh = JournalFile(path.with_name(f".{path.name}.{secrets.token_hex(4)}"))
    fresh.path.touch()
    fresh.append(entries)
    if path.exists():
        _copy_permissions(path, fresh.path)
    if known is None:
        damaged = path.with_name(f"{path.name}.before-rebuild.{stamp()}")
        shutil.copy2(path, damaged)
        sync(damaged)
        sync(damaged.parent)
    elif path.exists():
        JournalFile(path).keep_cut_off()
    fresh.path.replace(path)
    sync(path.parent)


def _copy_permissions(path: Path, fresh: Path) -> None:
    """Let a file that takes the place of another be read and written by the same people."""
    shutil.copymode(path, fresh)
    with contextlib.suppress(PermissionError):  # only its owner may give it to another group
        shutil.chown(fresh, group=path.stat().st_gid)


def _readable_beyond(path: Path, seq: int) -> int:
    """Return how many lines of a damaged journal are whole entries after number `seq`."""
    count = 0
    for line in path.read_bytes().splitlines():
        with contextlib.suppress(BookDamaged, UnicodeDecodeError):
            count += Entry.from_line(line.decode()).seq > seq
    return count


def _known(path: Path) -> list[str] | None:
    """Return the hashes in a journal file; None where it is damaged."""
    if not path.exists():
        return []
    try:
        return [entry.hash for entry in JournalFile(path).entries()]
    except BookDamaged:
        return None
