"""`labbook db copy`: all rows of a book's database into an empty one, from SQLite to PostgreSQL or back.

Others may write meanwhile: what is copied is the book at one moment, and what is stated later stands in journal.jsonl,
from where the first command on the new database applies it. The copy is there when every row was read back and is the
same, or it is not there at all.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from data_schema.disk import move_to_new_name, sync
from data_schema.engine import postgres_engine, reading, sqlite_engine, translated_errors
from data_schema.errors import BookDamaged, UsageError
from data_schema.schema import create_tables
from data_schema.tables import METADATA
from data_schema.tables.journal import labbook
from labbook.book.making import fill_sqlite
from labbook.book.opening import (
    CONFIGURATION,
    DATABASE,
    check_schema,
    engine_of,
    find_folder,
    read_configuration,
    shown,
)

ROWS_AT_ONCE = 1000
_SERVER, _ADDRESS = "postgresql", "://"


@dataclass(frozen=True, slots=True)
class CopiedDatabase:
    """The new database, the rows of each of its tables, and the change to labbook.toml that puts it in use."""

    database: str
    rows: dict[str, int]
    to_do: str


def copy_database(source: str, target: str, step: Callable[[str], None]) -> CopiedDatabase:
    """Copy the database of a book's folder, or of a PostgreSQL address, into an empty one, or into labbook.db there."""
    old = _source(source)
    try:
        check_schema(old)
        if _ADDRESS in target:
            return _into_postgres(old, target, step)
        return _into_sqlite(old, Path(target), step)
    finally:
        old.dispose()


def _source(given: str) -> sa.Engine:
    if _ADDRESS in given:
        return postgres_engine(given)
    folder = find_folder(Path(given))
    return engine_of(folder, read_configuration(folder))


def _into_postgres(old: sa.Engine, url: str, step: Callable[[str], None]) -> CopiedDatabase:
    engine = postgres_engine(url)
    try:
        with translated_errors(), engine.begin() as connection:
            tables = sorted(sa.inspect(connection).get_table_names())
            if tables:
                raise UsageError(
                    f"the database {shown(engine)} is not empty (it holds {', '.join(tables[:3])}): name an empty one."
                )
            create_tables(connection)
            rows = _copy_rows(old, connection, step)
            for table in METADATA.sorted_tables:
                if "id" in table.c:
                    _set_sequence(connection, table)
        to_do = f'to use it, let labbook.toml say [database] url = "{shown(engine)}"; then `labbook db check`.'
        return CopiedDatabase(shown(engine), rows, to_do)
    finally:
        engine.dispose()


def _set_sequence(connection: sa.Connection, table: sa.Table) -> None:
    """Let the next row get the key after the highest; copied rows brought theirs."""
    sequence = sa.func.pg_get_serial_sequence(connection.dialect.identifier_preparer.format_table(table), "id")
    following = sa.select(sa.func.coalesce(sa.func.max(table.c.id), 0) + 1).scalar_subquery()
    connection.execute(sa.select(sa.func.setval(sequence, following, sa.false())))


def _into_sqlite(old: sa.Engine, folder: Path, step: Callable[[str], None]) -> CopiedDatabase:
    path = folder / DATABASE
    if path.exists() or not folder.is_dir():
        what = (
            "is there already: move it away"
            if path.exists()
            else "cannot be made, for its folder is not there: make the folder"
        )
        raise UsageError(f"{path} {what}, or name another folder in which labbook.db is to be made.")
    fresh = folder / f".{DATABASE}.copy.{secrets.token_hex(4)}"
    try:
        fill_sqlite(fresh)
        engine = sqlite_engine(fresh)
        try:
            with translated_errors(), engine.connect().execution_options(labbook_writes=True) as to, to.begin():
                rows = _copy_rows(old, to, step)
        finally:
            engine.dispose()  # which brings its write-ahead log into the one file
        sync(fresh)
        try:
            move_to_new_name(fresh, path)
        except FileExistsError as error:
            raise UsageError(f"{path} was made meanwhile by another program: name another folder.") from error
    finally:
        for piece in folder.glob(f"{fresh.name}*"):
            piece.unlink()
    toml = "the labbook.toml" if (folder / CONFIGURATION).exists() else "a copy of the book's labbook.toml"
    to_do = (
        f"to use it, take [database] out of {toml} beside {path} (its [store] says where the files are); then `labbook "
        "db check`."
    )
    return CopiedDatabase(str(path), rows, to_do)


def _copy_rows(old: sa.Engine, to: sa.Connection, step: Callable[[str], None]) -> dict[str, int]:
    counts = {}
    with reading(old) as connection:
        for table in METADATA.sorted_tables:
            if table is labbook:  # which the new database has
                continue
            step(f"copying {table.name}")
            counts[table.name] = 0
            for some in _rows(connection, table).mappings().partitions(ROWS_AT_ONCE):
                to.execute(table.insert(), [dict(row) for row in some])
                counts[table.name] += len(some)
        for table in METADATA.sorted_tables:
            step(f"comparing {table.name}")
            for row, copy in zip_longest(_rows(connection, table), _rows(to, table)):
                if row != copy:
                    raise BookDamaged(f"a row of {table.name} did not arrive as it was: {row} became {copy}.")
    return counts


def _rows(connection: sa.Connection, table: sa.Table) -> sa.CursorResult[Any]:
    """Read a table in the order of its keys, which is the same on both engines."""
    server = connection.dialect.name == _SERVER
    order = [
        column.collate("C") if server and isinstance(column.type, sa.Text) else column
        for column in table.primary_key.columns
    ]
    query = sa.select(table).order_by(*order)
    return connection.execute(query, execution_options={"yield_per": ROWS_AT_ONCE})
