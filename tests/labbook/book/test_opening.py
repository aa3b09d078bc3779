"""Opening a book: it makes nothing, changes nothing, and says what to do about whatever it finds instead."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema.engine import postgres_engine, reading
from data_schema.errors import BookDamaged, BookVersion, UnknownName, UsageError
from data_schema.journal import JOURNAL_SCHEMA, Entry
from labbook.book.opening import check_schema
from tests.cli.shell import labbook, refused
from tests.helpers.books import ADA, BEN, SmallBook, small_book
from tests.helpers.folders import contents
from tests.helpers.wording import refuses


def test_opening_and_reading_change_no_byte(book: SmallBook) -> None:
    before = contents(book.folder)
    with book.open() as opened_book, opened_book.reading() as connection:
        assert connection.exec_driver_sql("SELECT count(*) FROM run").scalar_one() == 16
    assert contents(book.folder) == before


@pytest.mark.parametrize(
    ("theirs", "said"), [((), ("is empty", "labbook init DIR", "labbook rebuild", "url")), (("recipes",), ("recipes",))]
)
def test_an_empty_database_or_one_of_another_program_is_no_book(
    empty_engine: sa.Engine, theirs: tuple[str, ...], said: tuple[str, ...]
) -> None:
    with empty_engine.begin() as connection:
        for table in theirs:
            connection.exec_driver_sql(f"CREATE TABLE {table} (name TEXT)")
    with refuses(BookVersion, "labbook init", *said):
        check_schema(empty_engine)
    with reading(empty_engine) as connection:
        assert sa.inspect(connection).get_table_names() == list(theirs)


def test_a_database_of_another_schema_is_refused_with_what_mends_it(engine: sa.Engine) -> None:
    with engine.begin() as connection:
        connection.exec_driver_sql("UPDATE labbook SET schema = 4711")
    with refuses(BookVersion, "schema", "4711", "labbook rebuild") as caught:
        check_schema(engine)
    assert caught.value.exit_code == 3


@pytest.mark.parametrize(
    "words", [("runs", "list"), ("rebuild",), ("rebuild", "--journal"), ("db", "check"), ("backup", "../copy")]
)
def test_no_rebuild_is_advised_where_the_journal_is_of_another_schema_too(
    tmp_path: Path, words: tuple[str, ...]
) -> None:
    book = small_book(tmp_path)
    with closing(sqlite3.connect(book.database)) as connection, connection:
        connection.execute("UPDATE labbook SET schema = 4711")
    with book.journal.open(encoding="utf-8") as lines:
        first, *others = lines
    other = replace(Entry.from_line(first.rstrip("\n")), schema=JOURNAL_SCHEMA + 1)
    book.journal.write_text("".join([f"{other.line}\n", *others]), encoding="utf-8")
    answer = labbook(*words, at=book.folder)
    refused(answer, 3, f"journal.jsonl has schema {JOURNAL_SCHEMA + 1}")
    assert "`labbook re" not in answer.err


def test_a_password_is_never_shown(postgres_url: str) -> None:
    with_password = postgres_url.replace("labbook@", "labbook:secret@")
    engine = postgres_engine(with_password)
    with pytest.raises(BookVersion, match="is empty") as caught:
        check_schema(engine)
    engine.dispose()
    assert "secret" not in str(caught.value)
    assert "***" in str(caught.value)


def test_a_table_that_is_gone_is_damage(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    with closing(sqlite3.connect(book.database)) as connection:
        connection.execute("DROP TABLE jump")
    with (
        refuses(BookDamaged, "no such table", "labbook rebuild"),
        book.open() as opened_book,
        opened_book.reading() as reading_it,
    ):
        reading_it.exec_driver_sql("SELECT * FROM jump")


# --- who speaks


def test_of_several_one_must_be_named_by_name_or_initials(tmp_path: Path) -> None:
    with small_book(tmp_path, ingested=False, two_people=True).open() as book:
        assert [book.speaker(said) for said in (ADA, "AN", "BO", BEN)] == [ADA, ADA, BEN, BEN]
        with refuses(UsageError, "needs a person", "2", ADA, BEN):
            book.speaker(None)
        with refuses(UnknownName, "'Ada Nwoso'", ADA):
            book.speaker("Ada Nwoso")
