"""Column types and helpers that every table and query shares.

SQLite tables are STRICT, so only INTEGER, REAL and TEXT appear there; PostgreSQL gets BIGINT and DOUBLE PRECISION.
Every constraint is named, so that what it refuses can be put in words.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum
from functools import cache
from typing import Any, TypeVar

import sqlalchemy as sa
from sqlalchemy.engine import Dialect

from data_schema.tables.plain import finite

Item = TypeVar("Item")

CHUNK = 500
"""Values of one query: an engine takes a limited number at once (SQLite: 32766)."""

METADATA = sa.MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
    }
)

WHOLE = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
"""64-bit whole number on both engines (a SQLite INTEGER is 64 bits wide)."""

TEXT = sa.Text()


class Real(sa.types.TypeDecorator[float]):
    """Double precision that refuses NaN and infinity: SQLite would silently store NaN as NULL."""

    impl = sa.Double
    cache_ok = True

    def load_dialect_impl(self, dialect: Dialect) -> sa.types.TypeEngine[Any]:
        """REAL is 64 bits in SQLite, but 32 bits in PostgreSQL."""
        return dialect.type_descriptor(sa.REAL() if dialect.name == "sqlite" else sa.Double())

    def process_bind_param(self, value: float | None, dialect: Dialect) -> float | None:  # noqa: ARG002
        """Let only finite numbers and NULL through."""
        if value is None:
            return None
        return finite(float(value))


def uid_column() -> sa.Column[str]:
    """Build the name by which people and other rows outside the database cite a row."""
    return sa.Column("uid", TEXT, nullable=False, unique=True)


def key_column() -> sa.Column[int]:
    """Build the private integer key; it never appears in output."""
    return sa.Column("id", WHOLE, primary_key=True)


def reference(table: str, *, called: str | None = None, optional: bool = False, unique: bool = False) -> sa.Column[int]:
    """Build a foreign key to `table`, called after it unless otherwise; deleting what is referred to is refused."""
    return sa.Column(
        called or table,
        WHOLE,
        sa.ForeignKey(f"{table}.id", ondelete="RESTRICT", onupdate="RESTRICT"),
        nullable=optional,
        unique=unique or None,
    )


def text_column(
    name: str, *, optional: bool = False, unique: bool = False, usually: str | None = None
) -> sa.Column[str]:
    """Build a text column; a row without a value gets the default `usually`."""
    return sa.Column(name, TEXT, nullable=optional, unique=unique, default=usually)


def real_column(name: str, *, optional: bool = False) -> sa.Column[float]:
    """Build a double-precision column; NULL where optional and unknown."""
    return sa.Column(name, Real(), nullable=optional)


def whole_column(
    name: str, *, optional: bool = False, unique: bool = False, usually: int | None = None
) -> sa.Column[int]:
    """Build a 64-bit whole-number column; a row without a value gets the default `usually`."""
    return sa.Column(name, WHOLE, nullable=optional, unique=unique, default=usually)


def one_of(column: str, words: type[StrEnum], *, optional: bool = False) -> sa.CheckConstraint:
    """Build the check that a text column holds one word of a closed list."""
    listed = ", ".join(f"'{word}'" for word in words)
    test = f"{column} IN ({listed})"
    return sa.CheckConstraint(f"{column} IS NULL OR {test}" if optional else test, name=f"{column}_known")


def flag(column: str) -> sa.CheckConstraint:
    """Build the check that a whole-number column is 0 or 1."""
    return sa.CheckConstraint(f"{column} IN (0, 1)", name=f"{column}_flag")


def partial_index(name: str, column: str, where: str, *, unique: bool = False) -> sa.Index:
    """Build an index of the rows that meet a condition.

    PostgreSQL's option is set where tables are made: SQLAlchemy loads every driver for which an index has an option.
    """
    index = sa.Index(name, column, unique=unique, sqlite_where=sa.text(where))

    @sa.event.listens_for(METADATA, "before_create")
    def set_condition(_tables: sa.MetaData, connection: sa.Connection, **_options: Any) -> None:
        if connection.dialect.name == "postgresql":
            index.dialect_options["postgresql"]["where"] = sa.text(where)

    return index


def table(name: str, *parts: sa.schema.SchemaItem) -> sa.Table:
    """Declare a table, STRICT on SQLite; of its references those are indexed with which no unique key begins."""
    made = sa.Table(name, METADATA, *parts, sqlite_strict=True)
    keys = [rule for rule in made.constraints if isinstance(rule, sa.PrimaryKeyConstraint | sa.UniqueConstraint)]
    first = {next(iter(key.columns), None) for key in keys}
    for column in made.c:
        if column.foreign_keys and column not in first:
            sa.Index(None, column)
    return made


def columns_of(row: type[Any], source: sa.Table, **others: sa.ColumnElement[Any]) -> list[sa.Label[Any]]:
    """Return what fills the fields of a class of rows, in their order and under their names.

    It is the column of `source` that is called as the field, or what `others` give for it, which are fields all.
    """
    assert others.keys() <= row.__annotations__.keys(), others  # noqa: S101 - a misspelt field would be read elsewhere
    return [(others[name] if name in others else source.c[name]).label(name) for name in row.__annotations__]


def in_chunks(items: Sequence[Item]) -> Iterator[Sequence[Item]]:
    """Pass a list on in pieces that fit into a query, in order."""
    for start in range(0, len(items), CHUNK):
        yield items[start : start + CHUNK]


def private_keys(connection: sa.Connection, name: sa.Column[str], names: Sequence[str]) -> dict[str, int]:
    """Return the private keys of the rows with these values in a column, by value."""
    found: dict[str, int] = {}
    for some in in_chunks(names):
        found |= {row[0]: row[1] for row in connection.execute(_keys_by(name), {"names": list(some)})}
    return found


@cache
def _keys_by(name: sa.Column[str]) -> sa.Select[Any]:
    """Build the query once: an ingest of many files asks it for each."""
    return sa.select(name, name.table.c.id).where(name.in_(sa.bindparam("names", expanding=True)))
