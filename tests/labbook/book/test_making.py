"""`labbook init`: the only way a book comes into being; where one is, it is refused and nothing changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.engine import postgres_engine, reading
from data_schema.errors import BookMissing, UnknownName, UsageError
from data_schema.journal_file import JournalFile
from data_schema.queries.study import factors, people, the_study
from labbook.book.making import make_book
from labbook.book.opening import opened
from tests.helpers.books import ADA, small_book, small_toml
from tests.helpers.folders import contents
from tests.helpers.wording import refuses


@pytest.fixture
def folder(tmp_path: Path, database_url: str | None) -> Path:
    """A folder with a configuration and nothing else."""
    path = tmp_path / "lab"
    path.mkdir()
    (path / "labbook.toml").write_text(small_toml(database_url=database_url))
    return path


def test_a_new_book_holds_what_its_configuration_says(folder: Path) -> None:
    make_book(folder, "AN")
    with opened(folder) as book, book.reading() as connection:
        study = the_study(connection)
        assert study is not None
        assert study.reference_voltage_v == 15.4
        assert people(connection) == {ADA: "AN"}
        assert [factor.name for factor in factors(connection)] == ["foot", "k_gain", "b_ad_gain"]
        said = [(entry.person, str(entry.action)) for entry in book.mirror.entries()]
    assert said
    assert set(said) == {(ADA, "set")}


def test_a_folder_without_configuration_gets_one_to_fill_in(tmp_path: Path) -> None:
    make_book(tmp_path / "new book", "Zoë Ł")
    with opened(tmp_path / "new book") as book, book.reading() as connection:
        assert list(people(connection)) == ["Zoë Ł"]
    assert sorted(path.name for path in (tmp_path / "new book").iterdir()) == [
        ".whole.journal.jsonl",
        "journal.jsonl",
        "labbook.db",
        "labbook.toml",
    ]


def test_a_database_that_is_not_empty_is_left_alone(tmp_path: Path, postgres_url: str) -> None:
    engine = postgres_engine(postgres_url)
    with engine.begin() as connection:
        connection.exec_driver_sql("CREATE TABLE public.run (theirs TEXT)")
        connection.exec_driver_sql("CREATE SCHEMA labbook")
        connection.exec_driver_sql("CREATE TABLE recipes (name TEXT)")
    (tmp_path / "labbook.toml").write_text(small_toml(database_url=postgres_url))
    with refuses(UsageError, "not empty", "recipes", "[database] url"):
        make_book(tmp_path, ADA)
    assert [path.name for path in tmp_path.iterdir()] == ["labbook.toml"]
    with reading(engine) as connection:
        assert connection.exec_driver_sql("SELECT count(*) FROM recipes").scalar_one() == 0
    engine.dispose()


def test_a_wrong_name_leaves_no_half_made_book(folder: Path) -> None:
    before = contents(folder)
    with refuses(UnknownName, "'Ada Nwoso'"):
        make_book(folder, "Ada Nwoso")
    assert contents(folder) == before
    make_book(folder, ADA)
    assert JournalFile(folder / "journal.jsonl").last() is not None


def test_journal_and_store_lie_where_the_configuration_says(tmp_path: Path) -> None:
    shared = tmp_path / "shared"
    text = small_toml() + f'\n[store]\npath = "{shared}"\n'
    (tmp_path / "labbook.toml").write_text(text)
    make_book(tmp_path, ADA)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["labbook.db", "labbook.toml", "shared"]
    assert sorted(path.name for path in shared.iterdir()) == [".whole.journal.jsonl", "journal.jsonl"]


def test_a_lost_labbook_toml_is_written_as_the_journal_holds_it(tmp_path: Path) -> None:
    made = small_book(tmp_path)
    text = made.toml.read_text(encoding="utf-8")
    made.toml.unlink()
    with pytest.raises(BookMissing, match="`labbook init "), opened(made.folder):
        pass
    assert not make_book(made.folder, None)
    assert made.toml.read_text(encoding="utf-8") == text
