"""One engine factory for both databases: settings are made, then read back.

SQLite: write-ahead log, `synchronous=FULL`, foreign keys and recursive triggers on, and our own BEGIN, because the
driver's legacy mode lets new tables survive a rollback. A writing transaction starts with BEGIN IMMEDIATE: one
that only becomes a writer later fails at once when another has written meanwhile, whatever the busy timeout.
Who may only read a book opens its file for reading. SQLite would keep its notes for readers in files beside it, which
that person cannot make; where none are there, nobody writes, and the file is read as one that does not change. That it
did not is looked at when the reading is over.
PostgreSQL: a writer takes a lock on the journal, so that the journal has one order on both.
"""

from __future__ import annotations

import contextlib
import logging
import os
import sqlite3
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy import event
from sqlalchemy.exc import DBAPIError, OperationalError

from data_schema.disk import refuse_network_drive
from data_schema.errors import BookBusy, BookDamaged, BookReadOnly, UsageError, disk_full

BUSY_TIMEOUT_S = 10.0
POSTGRES_SCHEMA = "labbook"
"""Where a book's tables are on PostgreSQL: a rebuild makes others in another schema and exchanges the two names."""
SQLITE_MINIMUM = (3, 37, 0)
_PRAGMAS: dict[str, str | int] = {"journal_mode": "wal", "synchronous": 2, "foreign_keys": 1, "recursive_triggers": 1}
_SCRATCH: dict[str, str | int] = {**_PRAGMAS, "journal_mode": "memory", "synchronous": 0, "cache_size": -(2**16)}
"""Settings for a file that is of no use until it is complete, and is synced then: a page is written once, not first to
a log, and stays in memory, up to 64 MiB of them, while rows go on being added to it.
"""
NOT_ALLOWED = ("42501", "25006")
"""PostgreSQL's codes: the role lacks a right, or its transactions only read."""
_POOL_LOG = logging.getLogger("sqlalchemy.pool.impl.QueuePool")
_SEEN = "labbook_seen"
"""Under this name a connection keeps what a file looked like that is read as one that does not change."""


def _is_interrupt(record: logging.LogRecord) -> bool:
    """Whether a log message is of a Ctrl-C while a connection went back to the pool: it is raised and reported too."""
    return record.exc_info is not None and record.exc_info[0] is KeyboardInterrupt


_POOL_LOG.addFilter(lambda record: not _is_interrupt(record))


def sqlite_engine(path: Path, *, busy_timeout_s: float = BUSY_TIMEOUT_S, scratch: bool = False) -> sa.Engine:
    """Open an engine on a SQLite file that exists; a missing file is an error, never created here.

    For who may not write to the file and its folder, the engine only reads. What is committed to a `scratch` file need
    not survive a power cut.
    """
    if sqlite3.sqlite_version_info < SQLITE_MINIMUM:
        raise UsageError(
            f"SQLite {sqlite3.sqlite_version} is too old: labbook needs 3.37 or newer (STRICT tables); "
            "install a newer Python."
        )
    refuse_network_drive(path)

    writable = _may_write(path)

    def connect(options: str) -> sqlite3.Connection:
        location = f"{path.resolve().as_uri()}?{options}"
        # The pool gives a connection to one thread at a time, not always to that which made it.
        return sqlite3.connect(
            location, uri=True, isolation_level=None, timeout=busy_timeout_s, check_same_thread=False
        )

    still = not writable and _at_rest(path)
    options = "mode=rw" if writable else "mode=ro&immutable=1" if still else "mode=ro"
    seen = (path, _look(path)) if still else None  # before it is opened
    engine = sa.create_engine("sqlite+pysqlite://", creator=lambda: connect(options), poolclass=sa.pool.QueuePool)
    if writable:
        event.listen(engine, "connect", partial(_set_pragmas, _SCRATCH if scratch else _PRAGMAS))
    if still:
        event.listen(engine, "connect", lambda _connection, record: record.info.update({_SEEN: seen}))
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def postgres_engine(url: str, *, busy_timeout_s: float = BUSY_TIMEOUT_S, schema: str = POSTGRES_SCHEMA) -> sa.Engine:
    """Open an engine on a PostgreSQL database given by its SQLAlchemy URL, in the book's schema or in another."""
    if "://" in url and not url.startswith("postgresql"):
        raise UsageError(
            f"[database] url {url!r} is not PostgreSQL: give postgresql+psycopg://USER@HOST/NAME, or leave the "
            "table out to use labbook.db in the book."
        )
    try:
        engine = sa.create_engine(url, connect_args={"connect_timeout": int(BUSY_TIMEOUT_S)})
    except (sa.exc.ArgumentError, ModuleNotFoundError, ValueError) as error:  # the last for a port of letters
        raise UsageError(
            f"[database] url {url!r} cannot be used ({error}): give postgresql+psycopg://USER@HOST/NAME and "
            "install the extra with `pip install 'robot-labbook[postgres]'`."
        ) from error

    def wait_no_longer(connection: Any, _record: Any) -> None:
        with connection.cursor() as cursor:
            cursor.execute(f"SET lock_timeout = '{round(busy_timeout_s * 1000)}ms'")
            cursor.execute(f'SET search_path TO "{schema}"')
        connection.commit()

    event.listen(engine, "connect", wait_no_longer, insert=True)  # before SQLAlchemy asks for the schema
    return engine


@contextlib.contextmanager
def writing(engine: sa.Engine) -> Iterator[sa.Connection]:
    """Run one writing transaction, alone; it is committed at the end, or rolled back."""
    with (
        translated_errors(),
        engine.connect().execution_options(labbook_writes=True) as connection,
        exclusive_transaction(connection),
    ):
        yield connection


@contextlib.contextmanager
def exclusive_transaction(connection: sa.Connection) -> Iterator[None]:
    """Begin a transaction in which nobody else writes; on SQLite the option `labbook_writes` sees to that."""
    with connection.begin():
        if connection.dialect.name == "postgresql":
            connection.execute(sa.text("LOCK TABLE journal IN SHARE ROW EXCLUSIVE MODE"))
        yield


@contextlib.contextmanager
def reading(engine: sa.Engine) -> Iterator[sa.Connection]:
    """Run one reading transaction: all queries in it see the same state of the book."""
    with translated_errors(), engine.connect() as connection:
        if engine.dialect.name == "postgresql":  # its default shows each query what was committed meanwhile
            connection.execution_options(isolation_level="REPEATABLE READ")
        try:
            with connection.begin():
                yield connection
        finally:
            _refuse_changed(connection)


@contextlib.contextmanager
def translated_errors() -> Iterator[None]:
    """Turn a database's errors about locks, damage and absence into labbook's own."""
    try:
        yield
    except (DBAPIError, sqlite3.DatabaseError) as error:
        original = error.orig if isinstance(error, DBAPIError) else error
        text = str(original).lower()
        if isinstance(original, sqlite3.DatabaseError) and ("malformed" in text or "not a database" in text):
            raise BookDamaged(
                f"the database is damaged ({original}): keep the file, and run `labbook rebuild` to make it "
                "anew from the raw copies and the journal."
            ) from error
        if getattr(original, "sqlstate", None) in NOT_ALLOWED:
            first_line = str(original).strip().partition("\n")[0]
            raise BookReadOnly(
                f"this role of the database may not do that ({first_line}): ask who owns its tables "
                "for the right, or give the command as a role that has it."
            ) from error
        if not isinstance(error, OperationalError | sqlite3.OperationalError):
            raise
        if any(word in text for word in ("locked", "busy", "lock timeout", "deadlock")):
            raise BookBusy(
                "another program is writing to the book and did not finish in time: wait until it has finished, or "
                "close it, and try again."
            ) from error
        if "disk is full" in text:
            raise BookDamaged(disk_full()) from error
        if "disk i/o" in text:
            raise BookDamaged(
                f"the disk did not write or read the database ({original}): check it, and give the command again."
            ) from error
        if "readonly" in text or "unable to open" in text:
            kind, what = (BookReadOnly, "written") if "readonly" in text else (BookDamaged, "opened")
            raise kind(
                f"the database cannot be {what} ({original}): check the permissions of the book's folder."
            ) from error
        if isinstance(original, sqlite3.Error):
            raise BookDamaged(
                f"the database does not hold what labbook put there ({original}): keep the file, and run `labbook "
                "rebuild` to make it anew from the raw copies and the journal."
            ) from error
        message = " ".join(str(original).split())
        raise BookDamaged(f"the database did not answer: {message}; check that it runs.") from error


def _may_write(path: Path) -> bool:
    """Tell whether this process may write to a file and make others beside it; what is missing is for others to say."""
    return not path.exists() or all(os.access(place, os.W_OK, effective_ids=True) for place in (path, path.parent))


def _at_rest(path: Path) -> bool:
    """Tell whether nobody has the database open and nothing was left in its write-ahead log."""
    return not any(path.with_name(path.name + suffix).exists() for suffix in ("-wal", "-shm"))


def refuse_unfinished(path: Path) -> None:
    """Raise `BookDamaged` where the log of a closed database was not brought into its file, which SQLite does not tell.

    The file would lose it with the next name that it gets.
    """
    if not _at_rest(path):
        raise BookDamaged(f"the disk failed while the database {path} was made: check it and try again.")


def _look(path: Path) -> tuple[int, int, int]:
    """Return inode, size and modification time of a file, by which a change of it is seen."""
    found = path.stat()
    return found.st_ino, found.st_size, found.st_mtime_ns


def _refuse_changed(connection: sa.Connection) -> None:
    """Raise `BookBusy` when a file was changed that was read as one that does not: what was read may not fit."""
    seen = connection.info.get(_SEEN)
    if seen is not None and _look(seen[0]) != seen[1]:
        raise BookBusy("somebody wrote to the book while it was read: give the command again.")


def _set_pragmas(pragmas: dict[str, str | int], connection: Any, _record: Any) -> None:
    cursor = connection.cursor()
    try:
        for name, wanted in pragmas.items():
            cursor.execute(f"PRAGMA {name} = {wanted}")
            found = cursor.execute(f"PRAGMA {name}").fetchone()[0]
            if found != wanted:
                raise BookDamaged(
                    f"SQLite did not accept {name}={wanted} (it stays {found!r}): keep the book on a local disk."
                )
    finally:
        cursor.close()


def _begin_sqlite(connection: sa.Connection) -> None:
    writes = connection.get_execution_options().get("labbook_writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
