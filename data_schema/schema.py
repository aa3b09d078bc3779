"""The database as a whole: its tables, its views, and the number of their form.

Tables are never altered. A database of another number is made anew from the journal, `labbook rebuild`.
"""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables import METADATA
from data_schema.tables.journal import labbook
from data_schema.views import create_statements

SCHEMA = 13
"""Rises with every change of the tables, or of what is stored in them."""


def create_tables(connection: sa.Connection) -> None:
    """Make all tables and views in an empty database, in the transaction of `connection`."""
    METADATA.create_all(connection, checkfirst=False)
    for statement in create_statements():
        connection.exec_driver_sql(statement)
    connection.execute(labbook.insert(), {"schema": SCHEMA})


def schema_of(connection: sa.Connection) -> int | None:
    """Return the number of a database's form; None where labbook did not make it."""
    if not sa.inspect(connection).has_table(labbook.name):
        return None
    found: int | None = connection.scalar(sa.select(labbook.c.schema))
    return found


def count_rows(connection: sa.Connection) -> dict[str, int]:
    """Return the number of rows of every table."""
    return {
        table.name: connection.execute(sa.select(sa.func.count()).select_from(table)).scalar_one()
        for table in METADATA.sorted_tables
    }
