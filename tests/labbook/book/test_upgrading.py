"""`labbook db upgrade`: the most dangerous moment. Real migrations run on a book with data in all of its tables."""

from __future__ import annotations

import os
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pytest
import sqlalchemy as sa
from sqlalchemy.exc import DBAPIError

from data_schema import migrations
from data_schema.engine import reading, sqlite_engine, writing
from data_schema.errors import BookBusy, BookDamaged, BookVersion, UsageError
from data_schema.tables import METADATA
from labbook.book.opening import check_revision, engine_of, read_configuration
from labbook.book.upgrading import Upgrade, back_up, count_rows, migrate_checked, upgrade_database
from tests.helpers.books import SmallBook, small_book
from tests.helpers.databases import Rows, all_rows
from tests.helpers.schemas import schema_lines
from tests.helpers.wording import refuses

NEWEST = migrations.newest()
NEXT = f"{int(NEWEST) + 1:04d}"
HEAD = f"""
import sqlalchemy as sa
from alembic import op

revision = "{NEXT}"
down_revision = "{NEWEST}"
branch_labels = None
depends_on = None


def upgrade():
"""

REBUILDS_PARENTS = """
    rebuilt = "always" if op.get_bind().dialect.name == "sqlite" else "auto"
    for table in ("run", "person", "study", "file", "journal"):  # what most other tables refer to
        with op.batch_alter_table(table, recreate=rebuilt) as batch:
            batch.add_column(sa.Column("remark", sa.Text(), nullable=True))
            batch.create_check_constraint(op.f(f"ck_{table}_remark_said"), "remark IS NULL OR remark <> ''")
"""

FAILS_LATE = """
    with op.batch_alter_table("run") as batch:
        batch.add_column(sa.Column("remark", sa.Text(), nullable=True))
    op.create_table("half", sa.Column("a", sa.Text()))
    op.execute("INSERT INTO half SELECT name FROM run")
    op.execute("INSERT INTO half SELECT there_is_no_such_column FROM run")
"""

LOSES_ROWS = """
    op.execute("DELETE FROM note WHERE id = (SELECT min(id) FROM note)")
"""

BREAKS_REFERENCES = """
    op.execute("UPDATE charge SET battery = 4711")
"""


@dataclass(frozen=True, slots=True)
class Old:
    """A book whose database the migrations in `versions` would upgrade."""

    book: SmallBook
    engine: sa.Engine
    versions: Path

    def upgrade(self) -> Upgrade:
        return upgrade_database(self.book.folder, self.engine, self.versions)

    def state(self) -> tuple[list[str], dict[str, Rows], str | None]:
        """Schema, rows and revision."""
        with reading(self.engine) as connection:
            return schema_lines(connection), all_rows(self.engine), migrations.current(connection)

    def write_migration(self, body: str) -> None:
        (self.versions / f"m{NEXT}_next.py").write_text(HEAD + body)


@pytest.fixture
def old(tmp_path: Path, book: SmallBook) -> Iterator[Old]:
    versions = tmp_path / "my 50%: versions"
    shutil.copytree(migrations.VERSIONS, versions)
    engine = engine_of(book.folder, read_configuration(book.folder))
    yield Old(book, engine, versions)
    engine.dispose()


def backups(book: SmallBook) -> list[Path]:
    return sorted(book.folder.glob("*.backup"))


def test_a_rebuild_of_parents_keeps_every_row_rule_and_trigger(old: Old) -> None:
    old.write_migration(REBUILDS_PARENTS)
    lines, rows, _revision = old.state()
    with refuses(BookVersion, "has revision", NEWEST, "this labbook writes", NEXT, "labbook db upgrade"):
        check_revision(old.engine, old.versions)
    done = old.upgrade()
    assert (done.before, done.after) == (NEWEST, NEXT)
    check_revision(old.engine, old.versions)
    after_lines, after_rows, revision = old.state()
    assert revision == NEXT
    assert after_rows == rows
    assert all(rows[name] for name in ("run", "charge", "run_file", "note", "signal", "jump", "journal"))
    named = {
        word for line in lines for word in line.split() if word.strip('"').startswith(("ck_", "fk_", "uq_", "ix_"))
    }
    assert named <= {word for line in after_lines for word in line.split()}
    assert {line for line in lines if "TRIGGER" in line} == {line for line in after_lines if "TRIGGER" in line}
    if old.engine.dialect.name == "sqlite":
        assert all(
            "STRICT" in line for line in after_lines if line.startswith("CREATE TABLE") and "alembic" not in line
        )
    for change in ("UPDATE journal SET reason = 'x'", "DELETE FROM journal"):

        def forge(change: str = change) -> None:
            with writing(old.engine) as connection:
                connection.exec_driver_sql(change)

        with pytest.raises(DBAPIError, match="only ever added"):
            forge()


def test_foreign_keys_are_on_again_afterwards(old: Old) -> None:
    old.write_migration(REBUILDS_PARENTS)
    old.upgrade()

    def orphan() -> None:
        with writing(old.engine) as connection:
            connection.exec_driver_sql("DELETE FROM person")

    with pytest.raises(DBAPIError, match=r"(?i)violates foreign|FOREIGN KEY"):
        orphan()


@pytest.mark.parametrize(
    ("body", "says"),
    [
        (FAILS_LATE, f"upgrade from {NEWEST} to {NEXT} failed .*there_is_no_such_column.* nothing was changed"),
        (LOSES_ROWS, r"lost rows of \['note'\].*nothing was changed"),
        (BREAKS_REFERENCES, r"broken 16 references|violates foreign key"),
    ],
    ids=["fails late", "loses rows", "breaks references"],
)
def test_a_broken_migration_is_rolled_back_whole(old: Old, body: str, says: str) -> None:
    old.write_migration(body)
    before = old.state()
    with pytest.raises((BookDamaged, BookVersion), match=f"(?s){says}"):
        old.upgrade()
    assert old.state() == before
    assert len(backups(old.book)) == (1 if old.engine.dialect.name == "sqlite" else 0)
    with old.book.open():  # and the book opens as before
        pass


def test_the_backup_is_the_database_as_it_was(old: Old) -> None:
    old.write_migration(REBUILDS_PARENTS)
    before = old.state()
    done = old.upgrade()
    if old.engine.dialect.name == "postgresql":  # its backups are made by whoever keeps the server
        assert (done.backup, backups(old.book)) == (None, [])
        return
    assert done.backup is not None
    assert backups(old.book) == [done.backup]
    kept = sqlite_engine(done.backup)
    with reading(kept) as connection:
        assert (schema_lines(connection), all_rows(kept), migrations.current(connection)) == before
    kept.dispose()


def test_an_upgrade_of_what_is_newest_does_nothing(old: Old) -> None:
    before = old.state()
    assert old.upgrade() == Upgrade(NEWEST, NEWEST, None)
    assert old.state() == before
    assert backups(old.book) == []


def test_a_revision_that_is_not_known_is_never_upgraded(old: Old) -> None:
    with writing(old.engine) as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '4711'")
    before = old.state()
    with refuses(BookVersion, "4711", "labbook does not", "newer labbook"):
        old.upgrade()
    assert old.state() == before


def test_a_database_that_is_no_book_is_never_upgraded(tmp_path: Path, empty_engine: sa.Engine) -> None:
    with refuses(BookVersion, "labbook init DIR"):
        upgrade_database(tmp_path, empty_engine)
    with empty_engine.begin() as connection:
        connection.exec_driver_sql("CREATE TABLE recipes (name TEXT)")
    with refuses(BookVersion, "recipes"):
        upgrade_database(tmp_path, empty_engine)
    with reading(empty_engine) as connection:
        assert sa.inspect(connection).get_table_names() == ["recipes"]
    assert list(tmp_path.glob("*.backup")) == []


def test_an_upgrade_waits_for_nobody_for_ever(tmp_path: Path) -> None:
    book = small_book(tmp_path / "lab", ingested=False)
    engine = sqlite_engine(book.database, busy_timeout_s=0.05)
    other = sqlite_engine(book.database)
    with (
        writing(other),
        refuses(BookBusy, "program is writing"),
    ):
        migrate_checked(engine)
    migrate_checked(engine)
    engine.dispose()
    other.dispose()


def test_a_copy_of_the_file_alone_loses_what_the_backup_keeps(tmp_path: Path) -> None:
    """The trap itself: `cp labbook.db` while the newest rows still stand in the write-ahead log."""
    book = small_book(tmp_path / "lab", ingested=False)
    engine = sqlite_engine(book.database)
    with engine.connect() as connection, connection.begin():  # a reader keeps the log from being folded in
        before = count_rows(connection)["person"]
        with writing(engine) as writer:
            values = [{"uid": f"u{n}", "name": f"n{n}", "initials": f"i{n}"} for n in range(100)]
            writer.execute(METADATA.tables["person"].insert(), values)
        copied = tmp_path / "copy.db"
        shutil.copy(book.database, copied)
        backup = back_up(book.folder, "0001")
    engine.dispose()
    with closing(sqlite3.connect(copied)) as by_copy, closing(sqlite3.connect(backup)) as by_backup:
        assert by_copy.execute("SELECT count(*) FROM person").fetchone() == (before,)
        assert by_backup.execute("SELECT count(*) FROM person").fetchone() == (before + 100,)


def test_a_full_disk_is_seen_before_anything_is_done(tmp_path: Path) -> None:
    book = small_book(tmp_path / "lab", ingested=False)
    os.truncate(
        book.database, shutil.disk_usage(book.folder).free
    )  # a file with a hole: large, though it fills nothing
    listed = sorted(book.folder.iterdir())
    with pytest.raises(UsageError, match=r"\d+ MB.*make room"):
        back_up(book.folder, "0001")
    assert sorted(book.folder.iterdir()) == listed


def test_old_backups_do_not_count_as_the_database(tmp_path: Path) -> None:
    book = small_book(tmp_path / "lab", ingested=False)
    earlier = book.folder / "labbook.db.0000.20200101T000000Z.backup"
    earlier.touch()
    os.truncate(earlier, shutil.disk_usage(book.folder).free)
    assert back_up(book.folder, "0001").exists()
