"""How the database changes from one labbook to the next: Alembic, from the first table on.

`current()` returns a database's revision, `upgrade()` brings it to the newest; neither is ever called by opening.
`versions` names another folder of migrations than labbook's own. A migration is a file `m0001_what_it_does.py`, named
after its revision, one after the other: every command asks for the newest, and only an upgrade needs to load Alembic.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import sqlalchemy as sa

if TYPE_CHECKING:
    from alembic.config import Config

VERSIONS = Path(__file__).parent / "versions"
_FILE = re.compile(r"m([0-9]{4})_\w+\.py")


def newest(versions: Path = VERSIONS) -> str:
    """Return the revision that this labbook writes."""
    return max(_revisions(versions))


def known(revision: str, versions: Path = VERSIONS) -> bool:
    """Tell whether this labbook has the migration of a database's recorded revision."""
    return revision in _revisions(versions)


def current(connection: sa.Connection) -> str | None:
    """Return the revision recorded in a database; None when there is none."""
    if not sa.inspect(connection).has_table("alembic_version"):
        return None
    revision: str | None = connection.scalar(sa.text("SELECT version_num FROM alembic_version"))
    return revision


def upgrade(connection: sa.Connection, versions: Path = VERSIONS) -> None:
    """Run all migrations that are missing, inside the transaction of `connection`.

    On SQLite a table that is rebuilt loses its triggers without a word; those are made again.
    """
    from alembic import command

    configuration = _configuration(versions)
    configuration.attributes["connection"] = connection
    before = _triggers(connection)
    command.upgrade(configuration, "head")
    after, tables = _triggers(connection), sa.inspect(connection).get_table_names()
    for name, (table, statement) in before.items():
        if name not in after and table in tables:
            connection.exec_driver_sql(statement)


def _revisions(versions: Path) -> set[str]:
    return {match[1] for path in versions.iterdir() for match in [_FILE.fullmatch(path.name)] if match}


def _configuration(versions: Path) -> Config:
    from alembic.config import Config

    configuration = Config()
    configuration.set_main_option("script_location", _literal(Path(__file__).parent))
    configuration.set_main_option("path_separator", "newline")
    configuration.set_main_option("version_locations", _literal(versions))
    return configuration


def _literal(path: Path) -> str:
    return str(path).replace("%", "%%")


def _triggers(connection: sa.Connection) -> dict[str, tuple[str, str]]:
    """Return table and SQL of every trigger by name; on PostgreSQL none, where no table is ever rebuilt."""
    if connection.dialect.name != "sqlite":
        return {}
    rows = connection.exec_driver_sql("SELECT name, tbl_name, sql FROM sqlite_master WHERE type = 'trigger'")
    return {row.name: (row.tbl_name, row.sql) for row in rows}
