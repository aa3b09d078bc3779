"""Databases below the level of a book: making them, and reading all that they hold."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from data_schema.engine import POSTGRES_SCHEMA
from data_schema.schema import create_tables
from data_schema.tables import METADATA

ENGINES = ("sqlite", "postgresql")


def server_in_a_soak(fixture: str) -> pytest.MarkDecorator:
    """Have a test's book, engine or address on SQLite in the usual run, and on PostgreSQL too in a soak."""
    on_server = pytest.param("postgresql", marks=pytest.mark.soak)
    return pytest.mark.parametrize(fixture, ["sqlite", on_server], indirect=True)


Rows = list[tuple[Any, ...]]


def make_empty_sqlite(path: Path) -> None:
    """Make a SQLite file without tables."""
    with closing(sqlite3.connect(path)) as fresh:
        fresh.execute("PRAGMA journal_mode = wal")


def make_all_tables(engine: sa.Engine) -> None:
    """Make the tables in an empty database."""
    with engine.connect().execution_options(labbook_writes=True) as connection, connection.begin():
        if engine.dialect.name == "postgresql":
            connection.exec_driver_sql(f"CREATE SCHEMA IF NOT EXISTS {POSTGRES_SCHEMA}")
        create_tables(connection)


def all_rows(engine: sa.Engine) -> dict[str, Rows]:
    """Every row of every table, private keys included, in the order of their keys."""
    found = {}
    with engine.connect() as connection:
        for table in METADATA.sorted_tables:
            found[table.name] = [tuple(row) for row in connection.execute(_in_order(table))]
    return found


def all_rows_by_name(engine: sa.Engine) -> dict[str, Rows]:
    """Every row of every table without private keys: references are uids; in an order that knows no keys either."""
    found = {}
    with engine.connect() as connection:
        names = {table.name: _names(connection, table) for table in METADATA.sorted_tables if "id" in table.c}
        for table in METADATA.sorted_tables:
            rows = connection.execute(_in_order(table)).mappings()
            outside = [
                tuple(_outside(column, row[column.name], names) for column in table.c if column.name != "id")
                for row in rows
            ]
            found[table.name] = sorted(outside, key=repr)
    return found


def _in_order(table: sa.Table) -> sa.Select[Any]:
    return sa.select(table).order_by(*table.primary_key.columns)


def _names(connection: sa.Connection, table: sa.Table) -> Mapping[int, str]:
    if "uid" not in table.c:
        return {}
    return {row.id: row.uid for row in connection.execute(sa.select(table.c.id, table.c.uid))}


def _outside(column: sa.Column[Any], value: Any, names: Mapping[str, Mapping[int, str]]) -> Any:
    for foreign in column.foreign_keys:
        return None if value is None else names[foreign.column.table.name][value]
    return value
