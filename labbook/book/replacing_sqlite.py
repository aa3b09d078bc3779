"""Putting a rebuilt SQLite database in the place of the old one, whoever else has it open.

The new content is copied into the file that is there, in one transaction, by SQLite's own backup. A file that is
renamed over one in use would leave programs that write to the old one beside those that write to the new one, and a
write-ahead log that belongs to neither. Only a file that is no database any more is set aside by name.

A copy of the old database has its lasting name, and is synced, before any page of the new one is committed: from then
on nothing removes it. Where the replacing is cut off after that, there is a copy too many, never one too few.
"""

from __future__ import annotations

import contextlib
import secrets
import sqlite3
from collections.abc import Callable
from pathlib import Path

from data_schema.disk import stamp, sync
from data_schema.engine import BUSY_TIMEOUT_S
from data_schema.errors import BookBusy, BookDamaged
from data_schema.journal import GENESIS
from labbook.book.opening import DATABASE

PAGES_A_STEP = 8
"""Fewer than the smallest book has, so that the first step locks the file and does not finish."""

_RUBBISH = (sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT)


def replace_sqlite(
    folder: Path, fresh: Path, finish: Callable[[], None], busy_timeout_s: float = BUSY_TIMEOUT_S
) -> str | None:
    """Put `fresh` in the place of the book's database; returns under which name the old one is kept.

    `finish` brings `fresh` up to date; nobody else can write to the book while it runs, nor until all is done.
    """
    path = folder / DATABASE
    if path.exists():
        try:
            return _overwrite(path, fresh, finish, busy_timeout_s)
        except sqlite3.DatabaseError as error:
            _explain(path, error)
    finish()
    old = set_aside(folder)
    fresh.rename(path)
    sync(folder)
    return old


def remove_leftovers(folder: Path) -> None:
    """Remove databases that were never finished, of this rebuild or of one that was interrupted."""
    for leftover in folder.glob(f".{DATABASE}.*"):
        leftover.unlink()


def head_of_sqlite(path: Path) -> tuple[int, str] | None:
    """Return number and hash of the last journal entry in a database; None where none can be read."""
    if not path.exists():
        return None
    try:
        with contextlib.closing(_connect(path)) as connection:
            row = connection.execute("SELECT seq, hash FROM journal ORDER BY seq DESC LIMIT 1").fetchone()
    except sqlite3.DatabaseError:
        return None
    return (0, GENESIS) if row is None else (row[0], row[1])


def _overwrite(path: Path, fresh: Path, finish: Callable[[], None], busy_timeout_s: float) -> str:
    copy = path.with_name(f".{DATABASE}.rebuild.{secrets.token_hex(4)}")
    old = path.with_name(f"{DATABASE}.before-rebuild.{stamp()}")
    locked = False

    def between_steps(status: int, _left: int, _all: int) -> None:
        nonlocal locked
        if status in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            raise BookBusy(f"another program is writing to {path}: close it and run `labbook rebuild` again.")
        if not locked:  # the first step has locked the old database for writing; what it has copied is not committed
            locked = True
            finish()
            _copy(path, copy)
            sync(copy)
            copy.rename(old)
            sync(path.parent)

    with (
        contextlib.closing(_connect(path, busy_timeout_s)) as target,
        contextlib.closing(_connect(fresh)) as source,
    ):
        target.execute("PRAGMA journal_mode = wal")  # readers do not stop the copying, and it does not stop them
        source.backup(target, pages=PAGES_A_STEP, progress=between_steps)
    return old.name


def _copy(path: Path, to: Path) -> None:
    to.touch()
    with contextlib.closing(_connect(path)) as source, contextlib.closing(_connect(to)) as target:
        source.backup(target)


def _connect(path: Path, timeout_s: float = BUSY_TIMEOUT_S) -> sqlite3.Connection:
    """Connect to a file that exists."""
    return sqlite3.connect(path.resolve().as_uri() + "?mode=rw", uri=True, isolation_level=None, timeout=timeout_s)


def _explain(path: Path, error: sqlite3.DatabaseError) -> None:
    """Raise a readable form of an error; returns where the error means that the file is no database any more."""
    code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF
    if code in _RUBBISH:
        return
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        raise BookBusy(f"another program is writing to {path}: close it and run `labbook rebuild` again.") from error
    raise BookDamaged(
        f"{path} cannot be replaced ({error}): check the permissions of the book's folder and the space on its disk."
    ) from error


def set_aside(folder: Path) -> str | None:
    """Give what there is of the old database another name; its log too, also where the file itself is gone.

    A log that was left beside the new database would be read as belonging to it.
    """
    path = folder / DATABASE
    old = f"{DATABASE}.before-rebuild.{stamp()}"
    for suffix in ("-wal", "-shm"):
        piece = folder / f"{DATABASE}{suffix}"
        if piece.exists():
            piece.rename(folder / f"{old}{suffix}")
    if not path.exists():
        return None
    path.rename(folder / old)
    return old
