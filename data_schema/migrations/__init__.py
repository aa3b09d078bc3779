"""How the database changes from one labbook to the next: Alembic, from the first table on.

`current()` says where a database stands, `upgrade()` brings it to the newest; neither is ever called by opening.
`versions` names another folder of migrations than labbook's own.
"""

from __future__ import annotations

from pathlib import Path

import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory

VERSIONS = Path(__file__).parent / "versions"


def newest(versions: Path = VERSIONS) -> str:
    """Return the revision that this labbook writes."""
    revision = ScriptDirectory.from_config(_configuration(versions)).get_current_head()
    assert revision is not None, "there is a first migration"  # noqa: S101
    return revision


def known(revision: str, versions: Path = VERSIONS) -> bool:
    """Tell whether this labbook has the migration that a database says it has."""
    scripts = ScriptDirectory.from_config(_configuration(versions)).walk_revisions()
    return revision in {script.revision for script in scripts}


def current(connection: sa.Connection) -> str | None:
    """Return the revision that a database says it has; None when it says nothing."""
    return MigrationContext.configure(connection).get_current_revision()


def upgrade(connection: sa.Connection, versions: Path = VERSIONS) -> None:
    """Run all migrations that are missing, inside the transaction of `connection`.

    On SQLite a table that is rebuilt loses its triggers without a word; those are made again.
    """
    configuration = _configuration(versions)
    configuration.attributes["connection"] = connection
    before = _triggers(connection)
    command.upgrade(configuration, "head")
    after, tables = _triggers(connection), sa.inspect(connection).get_table_names()
    for name, (table, statement) in before.items():
        if name not in after and table in tables:
            connection.exec_driver_sql(statement)


def _configuration(versions: Path) -> Config:
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
