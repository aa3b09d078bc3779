"""One engine factory for both databases: settings are made, then read back.

SQLite: write-ahead log, `synchronous=FULL`, foreign keys and recursive triggers on, and our own BEGIN, because the
driver's legacy mode lets half a migration survive a rollback. A writing transaction starts with BEGIN IMMEDIATE: one
that only becomes a writer later fails at once when another has written meanwhile, whatever the busy timeout.
PostgreSQL: a writer takes a lock on the journal, so that the journal has one order on both.
"""

from __future__ import annotations

import contextlib
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy import event
from sqlalchemy.exc import DBAPIError, OperationalError

from data_schema.errors import BookBusy, BookDamaged, UsageError
from data_schema.mounts import refuse_network_drive

BUSY_TIMEOUT_S = 10.0
SQLITE_MINIMUM = (3, 37, 0)
_PRAGMAS = {"journal_mode": "wal", "synchronous": 2, "foreign_keys": 1, "recursive_triggers": 1}


def sqlite_engine(path: Path, *, busy_timeout_s: float = BUSY_TIMEOUT_S) -> sa.Engine:
    """Open an engine on a SQLite file that exists; a missing file is an error, never created here."""
    if sqlite3.sqlite_version_info < SQLITE_MINIMUM:
        raise UsageError(
            f"SQLite {sqlite3.sqlite_version} is too old: labbook needs 3.37 or newer (STRICT tables); "
            "install a newer Python."
        )
    refuse_network_drive(path)

    def connect() -> sqlite3.Connection:
        location = path.resolve().as_uri() + "?mode=rw"
        return sqlite3.connect(location, uri=True, isolation_level=None, timeout=busy_timeout_s)

    engine = sa.create_engine("sqlite+pysqlite://", creator=connect, poolclass=sa.pool.QueuePool)
    event.listen(engine, "connect", _set_pragmas)
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def postgres_engine(url: str, *, busy_timeout_s: float = BUSY_TIMEOUT_S) -> sa.Engine:
    """Open an engine on a PostgreSQL database given by its SQLAlchemy URL."""
    try:
        engine = sa.create_engine(url, connect_args={"connect_timeout": int(BUSY_TIMEOUT_S)})
    except (sa.exc.ArgumentError, ModuleNotFoundError) as error:
        raise UsageError(
            f"[database] url {url!r} cannot be used ({error}): give postgresql+psycopg://USER@HOST/NAME and "
            "install the extra with `pip install 'robot-labbook[postgres]'`."
        ) from error
    if engine.dialect.name != "postgresql":
        raise UsageError(
            f"[database] url {url!r} is not PostgreSQL: give postgresql+psycopg://USER@HOST/NAME, or leave "
            "the table out to use labbook.db in the book."
        )

    def wait_no_longer(connection: Any, _record: Any) -> None:
        with connection.cursor() as cursor:
            cursor.execute(f"SET lock_timeout = '{round(busy_timeout_s * 1000)}ms'")
        connection.commit()

    event.listen(engine, "connect", wait_no_longer)
    return engine


@contextlib.contextmanager
def writing(engine: sa.Engine) -> Iterator[sa.Connection]:
    """Run one writing transaction, alone; committed at the end, rolled back on any error."""
    with translated(), engine.connect().execution_options(labbook_writes=True) as connection, alone(connection):
        yield connection


@contextlib.contextmanager
def alone(connection: sa.Connection) -> Iterator[None]:
    """Begin a transaction in which nobody else writes; on SQLite the option `labbook_writes` sees to that."""
    with connection.begin():
        if connection.dialect.name == "postgresql":
            connection.execute(sa.text("LOCK TABLE journal IN SHARE ROW EXCLUSIVE MODE"))
        yield


@contextlib.contextmanager
def reading(engine: sa.Engine) -> Iterator[sa.Connection]:
    """Run one reading transaction: all queries in it see the same state of the book."""
    with translated(), engine.connect() as connection:
        if engine.dialect.name == "postgresql":  # its default shows each query what was committed meanwhile
            connection.execution_options(isolation_level="REPEATABLE READ")
        with connection.begin():
            yield connection


@contextlib.contextmanager
def translated() -> Iterator[None]:
    """Turn what a database says about locks, damage and absence into labbook's own errors."""
    try:
        yield
    except OperationalError as error:
        text = str(error.orig).lower()
        if "locked" in text or "busy" in text or "lock timeout" in text:
            raise BookBusy(
                "another program is writing to the book and did not finish in time: wait until it has finished, or "
                "close it, and try again."
            ) from error
        if "disk is full" in text or "disk i/o" in text:
            raise BookDamaged(f"the disk refused to write ({error.orig}): free space on it and try again.") from error
        if "readonly" in text or "unable to open" in text:
            raise BookDamaged(
                f"the database cannot be written ({error.orig}): check the permissions of the book's folder."
            ) from error
        if isinstance(error.orig, sqlite3.Error):
            raise BookDamaged(
                f"the database does not hold what labbook put there ({error.orig}): keep the file, and run `labbook "
                "rebuild` to make it anew from the raw copies and the journal."
            ) from error
        raise BookDamaged(f"the database did not answer: {str(error.orig).strip()}; check that it runs.") from error
    except DBAPIError as error:
        if isinstance(error.orig, sqlite3.DatabaseError) and _is_damage(str(error.orig)):
            raise BookDamaged(
                f"the database is damaged ({error.orig}): keep the file, and run `labbook rebuild` to make it "
                "anew from the raw copies and the journal."
            ) from error
        raise


def _is_damage(text: str) -> bool:
    return "malformed" in text or "not a database" in text


def _set_pragmas(connection: Any, _record: Any) -> None:
    cursor = connection.cursor()
    try:
        for name, wanted in _PRAGMAS.items():
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
