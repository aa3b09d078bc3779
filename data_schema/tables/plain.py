"""Statements that a replay gives thousands of times in a few shapes: SQLite's driver runs each, compiled once.

SQLAlchemy takes ten times as long for a statement as SQLite takes to carry it out. A statement is built once by the
module that gives it; what it takes is named, and none of it is a list.
"""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, TypeAlias

import sqlalchemy as sa
from sqlalchemy.dialects import sqlite

Values: TypeAlias = Mapping[str, Any]
_SQLITE = sqlite.dialect()
_AT_ONCE = 1000


def fetch(connection: sa.Connection, statement: sa.Executable, values: Values) -> Sequence[Sequence[Any]]:
    """Return all rows that a statement gives for these values."""
    return _run(connection, statement, values).fetchall()


def scan(connection: sa.Connection, query: sa.Executable) -> Iterator[Sequence[tuple[Any, ...]]]:
    """Give all rows of a long query, a thousand at once."""
    driver = _driver(connection)
    if driver is None:
        for rows in connection.execute(query, execution_options={"yield_per": _AT_ONCE}).partitions():
            yield [tuple(row) for row in rows]
    else:
        cursor = _run(connection, query, {})
        while rows := cursor.fetchmany(_AT_ONCE):
            yield rows


def change(connection: sa.Connection, statement: sa.Executable, values: Values) -> int:
    """Change or remove rows; returns how many."""
    return _run(connection, statement, values).rowcount


def insert(connection: sa.Connection, into: sa.Table | sa.Insert, values: Values) -> int:
    """Add a row; returns its private key."""
    done = _run(connection, _insert(into) if isinstance(into, sa.Table) else into, values)
    key: int = done.lastrowid if isinstance(done, sqlite3.Cursor) else done.inserted_primary_key[0]  # type: ignore
    return key


def insert_all(
    connection: sa.Connection, table: sa.Table, names: tuple[str, ...], rows: Sequence[Sequence[Any]]
) -> None:
    """Add rows, of each the values of the columns named, which stand in the order of the table."""
    driver = _driver(connection)
    if not rows:
        return
    if driver is None:
        connection.execute(table.insert(), [dict(zip(names, row, strict=True)) for row in rows])
    else:
        plain = _compiled(_insert(table), names)
        if tuple(plain.order) != names:
            raise ValueError(f"{names} stand in another order than the columns of {table.name}.")
        for row in rows:
            _refuse_not_finite(plain, row)
        _translated(driver.executemany, plain.text, rows)


def finite(number: float) -> float:
    """Return a number; raises `ValueError` for infinity and for NaN, which SQLite would silently store as NULL."""
    if not math.isfinite(number):
        raise ValueError(f"{number} cannot be stored: store NULL and a reason instead.")
    return float(number)


def _run(connection: sa.Connection, statement: sa.Executable, values: Values) -> sqlite3.Cursor | sa.CursorResult[Any]:
    driver = _driver(connection)
    if driver is None:
        return connection.execute(statement, values)
    plain = _compiled(statement, tuple(values))
    given = {**plain.fixed, **values} if plain.fixed else values
    ordered = [given[name] for name in plain.order]
    _refuse_not_finite(plain, ordered)
    return _translated(driver.execute, plain.text, ordered)


def _driver(connection: sa.Connection) -> sqlite3.Connection | None:
    """Return SQLite's own connection, in its open transaction; None on another database, or where none was begun."""
    if connection.dialect.name != "sqlite" or not connection.in_transaction():
        return None
    return connection.connection.driver_connection


@cache
def _insert(table: sa.Table) -> sa.Insert:
    return table.insert()


@dataclass(frozen=True, slots=True)
class _Plain:
    """A statement's text, the names of its values in their order, what it fixes of them, and the places of those that
    a NaN, which SQLite stores as NULL, or an infinity could get into.
    """

    text: str
    order: list[str]
    fixed: dict[str, Any]
    open: list[int]


@lru_cache(maxsize=1000)
def _compiled(statement: sa.Executable, names: tuple[str, ...]) -> _Plain:
    compiled: Any = statement.compile(dialect=_SQLITE, column_keys=names)  # type: ignore[attr-defined]
    fixed = {name: value for name, value in compiled.params.items() if name not in names}
    usual = {column.key: column.default.arg for column in compiled.insert_prefetch}
    order = compiled.positiontup
    columns: Any = statement.table.c if isinstance(statement, sa.Insert | sa.Update) else {}
    filled = {name for name in order if name in columns and not columns[name].nullable}
    closed = {name for name in filled if compiled.binds[name].type.python_type in (int, str)}
    return _Plain(
        str(compiled), order, fixed | usual, [place for place, name in enumerate(order) if name not in closed]
    )


def _refuse_not_finite(plain: _Plain, values: Sequence[Any]) -> None:
    for place in plain.open:
        value = values[place]
        if isinstance(value, float) and not math.isfinite(value):
            finite(value)


def _translated(work: Callable[..., sqlite3.Cursor], text: str, values: Sequence[Any]) -> sqlite3.Cursor:
    try:
        return work(text, values)
    except sqlite3.Error as error:
        raise sa.exc.DBAPIError.instance(text, None, error, sqlite3.Error, dialect=_SQLITE) from error
