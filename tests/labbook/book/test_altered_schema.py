"""The form of a database that is not as labbook made it is named, and a rebuild mends it."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.altered_schema import altered_schema
from data_schema.engine import postgres_engine, sqlite_engine
from tests.helpers.books import SmallBook, small_book
from tests.helpers.upkeep import health, rebuilt

ON_BOTH = (
    (("DROP INDEX ix_journal_entity",), "ix_journal_entity"),
    (("DROP INDEX ix_run_day", "CREATE INDEX ix_run_day ON run (name)"), "ix_run_day"),
    (("ALTER TABLE note RENAME TO note_kept", "CREATE VIEW note AS SELECT * FROM note_kept"), "note "),
    (("ALTER TABLE run ADD COLUMN mood TEXT",), "mood"),
    (("DROP VIEW v_note", "CREATE VIEW v_note AS SELECT uid AS run FROM note"), "v_note"),
    (("DROP VIEW v_note",), "v_note"),
)
ON_SERVER = (
    (("ALTER TABLE channel ALTER COLUMN scale TYPE real",), "scale"),
    (("ALTER TABLE charge ALTER COLUMN uid DROP NOT NULL",), "uid"),
    (("ALTER TABLE run DROP CONSTRAINT fk_run_day",), "fk_run_day"),
    (("ALTER TABLE note RENAME COLUMN text TO body",), "body"),
    (("ALTER TABLE run DROP CONSTRAINT uq_run_uid",), "uq_run_uid"),
    (("DROP VIEW v_note", "CREATE VIEW v_note AS SELECT * FROM (SELECT NULL::text AS run) AS x"), "v_note"),
)


def alter(book: SmallBook, url: str | None, *statements: str) -> None:
    engine = postgres_engine(url) if url else sqlite_engine(book.database)
    with engine.connect().execution_options(labbook_writes=True) as connection, connection.begin():
        for statement in statements:
            connection.exec_driver_sql(statement)
    engine.dispose()


@pytest.mark.parametrize(("statements", "named"), ON_BOTH)
def test_what_is_altered_is_named_and_mended(tmp_path: Path, statements: tuple[str, ...], named: str) -> None:
    book = small_book(tmp_path, ingested=False)
    alter(book, None, *statements)
    problems = health(book).problems
    assert any(named in problem for problem in problems), problems
    rebuilt(book)
    assert health(book).whole


def test_a_column_that_is_gone_is_named(tmp_path: Path) -> None:
    book = small_book(tmp_path, ingested=False)
    alter(book, None, "DROP VIEW v_note", "ALTER TABLE note DROP COLUMN text")
    found = health(book)
    assert any("table note" in problem for problem in found.problems)
    assert found.entries


def test_a_view_of_a_lab_is_let_be(tmp_path: Path) -> None:
    book = small_book(tmp_path, ingested=False)
    alter(book, None, "CREATE VIEW ours AS SELECT name FROM run")
    assert health(book).whole


def test_on_postgresql(tmp_path: Path, postgres_url: str) -> None:
    book = small_book(tmp_path, database_url=postgres_url)
    assert health(book).problems == ()
    engine = postgres_engine(postgres_url)
    for statements, named in (*ON_BOTH, *ON_SERVER):
        with engine.connect() as connection:
            for statement in statements:
                connection.exec_driver_sql(statement)
            found = altered_schema(connection)
            connection.rollback()
        assert any(named in sentence for sentence in found), (statements, found)
    engine.dispose()
    alter(book, postgres_url, "DROP VIEW v_note", "ALTER TABLE note DROP COLUMN text")
    assert any("text of table note" in problem for problem in health(book).problems)
