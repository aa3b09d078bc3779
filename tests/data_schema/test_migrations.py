"""The migrations make what the tables say, and what they make is on record, engine by engine.

After a change on purpose: LABBOOK_GOLDEN=write pytest tests/data_schema/test_migrations.py
"""

from __future__ import annotations

import hashlib
import os
import shutil
from pathlib import Path

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory

from data_schema import migrations
from data_schema.engine import reading, writing
from data_schema.tables import METADATA
from tests.helpers.databases import migrate
from tests.helpers.schemas import rules, schema_lines

GOLDEN = Path(__file__).with_name("golden")


def test_migrations_make_what_the_tables_say(engine: sa.Engine) -> None:
    with reading(engine) as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True, "compare_server_default": True})
        assert compare_metadata(context, METADATA) == []


def test_migrations_make_every_rule_that_the_tables_have(empty_engine: sa.Engine) -> None:
    """Checks too, which the comparison above does not see."""
    with empty_engine.begin() as connection:
        METADATA.create_all(connection)
        by_tables, partial = rules(connection), partial_indexes(connection)
        METADATA.drop_all(connection)
        migrations.upgrade(connection)
        assert rules(connection) == by_tables
        assert len(partial) == 2
        assert partial_indexes(connection) == partial


def partial_indexes(connection: sa.Connection) -> list[str]:
    """Those of rows that meet a condition, which SQLAlchemy does not see on every engine."""
    return [line for line in schema_lines(connection) if " INDEX " in line and " WHERE " in line]


def test_the_schema_is_the_one_on_record(engine: sa.Engine) -> None:
    record = GOLDEN / f"{engine.dialect.name}.sql"
    with reading(engine) as connection:
        found = "\n".join(schema_lines(connection)) + "\n"
    if os.environ.get("LABBOOK_GOLDEN") == "write":
        record.parent.mkdir(exist_ok=True)
        record.write_text(found, encoding="utf-8")
    assert found == record.read_text(encoding="utf-8"), f"the schema differs from {record.name}: see this file's head"


def test_the_newest_revision_is_known_and_reached(engine: sa.Engine) -> None:
    assert migrations.known(migrations.newest())
    assert not migrations.known("4711")
    with reading(engine) as connection:
        assert migrations.current(connection) == migrations.newest()


def test_files_are_named_after_the_revisions_that_alembic_finds_in_them() -> None:
    configuration = Config()
    configuration.set_main_option("script_location", str(migrations.VERSIONS.parent))
    scripts = ScriptDirectory.from_config(configuration)
    assert scripts.get_current_head() == migrations.newest()
    for script in scripts.walk_revisions():
        assert Path(script.path).name.startswith(f"m{script.revision}_")
        assert migrations.known(script.revision)


def test_an_empty_database_has_no_revision(empty_engine: sa.Engine) -> None:
    with reading(empty_engine) as connection:
        assert migrations.current(connection) is None


def test_running_all_migrations_again_changes_nothing(engine: sa.Engine) -> None:
    with reading(engine) as connection:
        before = schema_lines(connection)
    migrate(engine)
    with reading(engine) as connection:
        assert schema_lines(connection) == before


NEWEST = migrations.newest()
NEXT = f"{int(NEWEST) + 1:04d}"

BROKEN = f"""
import sqlalchemy as sa
from alembic import op

revision = "{NEXT}"
down_revision = "{NEWEST}"
branch_labels = None
depends_on = None


def upgrade():
    op.create_table("half", sa.Column("a", sa.Text()))
    op.add_column("person", sa.Column("b", sa.Text()))
    op.execute("INSERT INTO half VALUES ('x')")
    op.execute("SELECT * FROM there_is_no_such_table")
"""


def test_half_a_migration_never_survives(engine: sa.Engine, tmp_path: Path) -> None:
    versions = tmp_path / "versions"
    shutil.copytree(migrations.VERSIONS, versions)
    (versions / f"m{NEXT}_broken.py").write_text(BROKEN)
    assert migrations.newest(versions) == NEXT
    with reading(engine) as connection:
        before = schema_lines(connection)

    def run() -> None:
        with writing(engine) as connection:
            migrations.upgrade(connection, versions)

    with pytest.raises(Exception, match="there_is_no_such_table"):
        run()
    with reading(engine) as connection:
        assert schema_lines(connection) == before
        assert migrations.current(connection) == NEWEST


ON_RECORD = {"m0001_first_tables.py": "f537e655cb7e02ef7019befb930313779ab3c6b47cd9ec00f2d4a0a939118a9c"}
"""Migrations that books were made with, by the SHA-256 of their file."""


@pytest.mark.parametrize("name", sorted(ON_RECORD))
def test_migrations_are_only_added_to(name: str) -> None:
    content = (migrations.VERSIONS / name).read_bytes()
    assert hashlib.sha256(content).hexdigest() == ON_RECORD[name]  # migrations are only added to: write another one
