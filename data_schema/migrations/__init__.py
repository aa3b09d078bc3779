"""How the database changes from one labbook to the next: Alembic, from the first table on.

`revision()` says where a database stands, `upgrade()` brings it to the newest; neither is ever called by opening.
"""

from __future__ import annotations

from pathlib import Path

import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory


def _configuration() -> Config:
    configuration = Config()
    configuration.set_main_option("script_location", str(Path(__file__).parent).replace("%", "%%"))
    configuration.set_main_option("path_separator", "os")
    return configuration


def newest() -> str:
    """Return the revision that this labbook writes."""
    revision = ScriptDirectory.from_config(_configuration()).get_current_head()
    assert revision is not None, "there is a first migration"  # noqa: S101
    return revision


def known(revision: str) -> bool:
    """Tell whether this labbook has the migration that a database says it has."""
    return revision in {script.revision for script in ScriptDirectory.from_config(_configuration()).walk_revisions()}


def current(connection: sa.Connection) -> str | None:
    """Return the revision that a database says it has; None when it says nothing."""
    return MigrationContext.configure(connection).get_current_revision()


def upgrade(connection: sa.Connection) -> None:
    """Run all migrations that are missing, inside the transaction of `connection`."""
    configuration = _configuration()
    configuration.attributes["connection"] = connection
    command.upgrade(configuration, "head")
