"""`labbook db upgrade`: the most dangerous moment of a database, so nothing about it is silent.

Before: a backup through the database's own copy (never a file copy), and room on the disk for it and the rebuild.
During: foreign keys off, because a table that is rebuilt with them on empties its children. After: every table has the
rows that it had, every reference points somewhere, and the file is whole; otherwise all of it is rolled back.
"""

from __future__ import annotations

import contextlib
import shutil
import sqlite3
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa
from sqlalchemy.exc import DBAPIError

from data_schema import migrations
from data_schema.disk import partial_path, put_in_place, stamp
from data_schema.engine import exclusive_transaction, reading, translated_errors
from data_schema.errors import BookDamaged, BookVersion, UsageError
from labbook.book.opening import DATABASE, check_revision


@dataclass(frozen=True, slots=True)
class Upgrade:
    """What an upgrade did: revisions before and after, and where the backup lies (SQLite)."""

    before: str
    after: str
    backup: Path | None


def upgrade_database(folder: Path, engine: sa.Engine, versions: Path = migrations.VERSIONS) -> Upgrade:
    """Bring the database to this labbook's revision; does nothing when it is there already."""
    with reading(engine) as connection:
        before = migrations.current(connection)
    if before is None or not migrations.known(before, versions):
        check_revision(engine, versions)  # raises an error that names the database's revision and what to do
    assert before is not None  # noqa: S101 - or it would have been refused
    after = migrations.newest(versions)
    if before == after:
        return Upgrade(before, after, None)
    backup = back_up(folder, before) if engine.dialect.name == "sqlite" else None
    try:
        migrate_checked(engine, versions)
    except DBAPIError as error:
        raise BookVersion(
            f"the upgrade from {before} to {after} failed ({str(error.orig).strip()}) and nothing was changed: go on "
            "with the labbook that made the database, and report this."
        ) from error
    return Upgrade(before, after, backup)


def back_up(folder: Path, revision: str) -> Path:
    """Copy the SQLite database through its own backup; refuses when the disk has not twice its size free."""
    source = folder / DATABASE
    pieces = [source, source.with_name(f"{DATABASE}-wal")]
    size = sum(path.stat().st_size for path in pieces if path.exists())
    free = shutil.disk_usage(folder).free
    if free < 2 * size:
        raise UsageError(
            f"an upgrade needs {2 * size / 1e6:.0f} MB free beside {source}, there are {free / 1e6:.0f} MB: make room "
            "and try again."
        )
    target = folder / f"{DATABASE}.{revision}.{stamp()}.backup"
    part = partial_path(target)
    try:
        with contextlib.closing(sqlite3.connect(source)) as origin, contextlib.closing(sqlite3.connect(part)) as copy:
            origin.backup(copy)
            verdict = copy.execute("PRAGMA integrity_check").fetchone()[0]
        if verdict != "ok":
            raise BookDamaged(f"a copy of {source} is not whole ({verdict}): run `labbook rebuild` instead.")
        put_in_place(target)
    finally:
        part.unlink(missing_ok=True)
    return target


def migrate_checked(engine: sa.Engine, versions: Path = migrations.VERSIONS) -> None:
    """Run the missing migrations; rolls back when a row was lost or a reference broken."""
    sqlite = engine.dialect.name == "sqlite"
    with engine.connect().execution_options(labbook_writes=True) as connection:
        if sqlite:
            _foreign_keys(connection, "OFF")
        try:
            with contextlib.ExitStack() as transaction:
                with translated_errors():
                    transaction.enter_context(exclusive_transaction(connection))
                before = count_rows(connection)
                migrations.upgrade(connection, versions)
                _check(connection, before, sqlite)
        finally:
            if sqlite:
                _foreign_keys(connection, "ON")


def count_rows(connection: sa.Connection) -> dict[str, int]:
    """Return the number of rows of every table that the database has."""
    preparer = connection.dialect.identifier_preparer
    return {
        name: connection.exec_driver_sql(f"SELECT count(*) FROM {preparer.quote(name)}").scalar_one()  # noqa: S608
        for name in sa.inspect(connection).get_table_names()
        if name != "alembic_version"
    }


def _check(connection: sa.Connection, before: dict[str, int], sqlite: bool) -> None:
    after = count_rows(connection)
    lost = {name: count for name, count in before.items() if after.get(name, count) < count}
    broken = connection.exec_driver_sql("PRAGMA foreign_key_check").fetchall() if sqlite else []
    whole = connection.exec_driver_sql("PRAGMA integrity_check").scalar_one() if sqlite else "ok"
    if lost or broken or whole != "ok":
        raise BookDamaged(
            f"the upgrade would have lost rows of {sorted(lost)}, broken {len(broken)} references or left the file "
            f"{whole}: nothing was changed; report this with the output of `labbook db status`."
        )


def _foreign_keys(connection: sa.Connection, state: str) -> None:
    """Switch enforcement outside any transaction: inside one, SQLite ignores the order without a word."""
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)  # noqa: S101
    driver.execute(f"PRAGMA foreign_keys = {state}")
    if driver.execute("PRAGMA foreign_keys").fetchone()[0] != (state == "ON"):
        raise BookDamaged(f"SQLite did not switch foreign keys {state}: nothing was changed, try again.")
