"""A database that was copied to the other engine holds the same rows, and the book goes on with it."""

from __future__ import annotations

import random
import shutil
import time
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema.engine import postgres_engine, reading, sqlite_engine
from data_schema.errors import BookVersion, UsageError
from data_schema.row_hashes import altered_rows
from labbook.actions.upkeep.health import check_book
from labbook.book.copies.copying_database import copy_database
from labbook.terminal import progress
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.commands import KILLED, Commands
from tests.helpers.databases import Rows, all_rows
from tests.helpers.postgres import Cluster
from tests.helpers.statements import note, notes, said_alike
from tests.helpers.whole_book import copy_of_whole_book
from tests.helpers.wording import refuses


def copied(source: Path | str, target: Path | str) -> dict[str, int]:
    return copy_database(str(source), str(target), lambda _step: None).rows


def rows(place: Path | str) -> dict[str, Rows]:
    engine = postgres_engine(place) if isinstance(place, str) else sqlite_engine(place / "labbook.db")
    try:
        return all_rows(engine)
    finally:
        engine.dispose()


def point(book: SmallBook, url: str | None) -> None:
    """Let labbook.toml say another database."""
    text = book.toml.read_text().partition("\n[database]")[0]
    book.toml.write_text(text if url is None else f'{text}\n[database]\nurl = "{url}"\n')


def check_goes_on(book: SmallBook, text: str) -> None:
    """The book is whole, new rows get keys of their own, and what was said is there."""
    assert check_book(book.folder, lambda total: progress("", total, shown=False)).problems == ()
    with book.open() as standing:
        with standing.session(ADA) as session:
            note(session, text)
        assert notes(standing)[-1] == text
        said_alike(standing)


def test_a_server_that_sorts_for_people_has_the_same_hashes(tmp_path: Path, cluster: Cluster) -> None:
    book = copy_of_whole_book(tmp_path)
    name = cluster.make_sorted_for_people()
    try:
        copied(book.folder, cluster.url(name))
        engine = postgres_engine(cluster.url(name))
        with reading(engine) as connection:
            assert connection.exec_driver_sql("SELECT 'a' < 'B'").scalar_one(), "not by bytes"
            assert altered_rows(connection) == []
        engine.dispose()
    finally:
        cluster.drop(name)


def test_from_sqlite_to_postgresql_and_back_every_row_is_the_same(tmp_path: Path, postgres_url: str) -> None:
    book = copy_of_whole_book(tmp_path)
    before = rows(book.folder)
    assert copied(book.folder, postgres_url) == {name: len(found) for name, found in before.items()}
    assert rows(postgres_url) == before
    book.database.unlink()
    point(book, postgres_url)
    check_goes_on(book, "said on the server")
    on_server = rows(postgres_url)
    copied(book.folder, book.folder)
    assert rows(book.folder) == on_server
    point(book, None)
    check_goes_on(book, "said in the file again")


@pytest.mark.soak
def test_from_server_to_server_by_their_addresses(tmp_path: Path, cluster: Cluster) -> None:
    one, other = (cluster.url(cluster.fresh()) for _ in range(2))
    small_book(tmp_path, ingested=False, database_url=one)
    copied(one, other)
    assert rows(other) == rows(one)


def test_what_is_said_meanwhile_is_applied_by_the_first_command_on_the_copy(
    tmp_path: Path, postgres_url: str, commands: Commands
) -> None:
    book = small_book(tmp_path)
    before = rows(book.folder)
    steps = []

    def speak(step: str) -> None:
        steps.append(step)
        if len(steps) == 2:
            code, said = commands.run("note", "r001", "said meanwhile", "--book", book.folder)
            assert code == 0, said

    copy_database(str(book.folder), postgres_url, speak)
    assert rows(postgres_url) == before  # the book at one moment
    point(book, postgres_url)
    check_goes_on(book, "afterwards")
    with book.open() as standing:
        assert notes(standing)[-2:] == ["said meanwhile", "afterwards"]


def test_nothing_is_copied_over_anything(tmp_path: Path, postgres_url: str) -> None:
    book = small_book(tmp_path, ingested=False)
    before = rows(book.folder)
    engine = postgres_engine(postgres_url)
    with engine.begin() as connection:
        connection.exec_driver_sql("CREATE TABLE recipes (x TEXT)")
    for target, text in (
        (postgres_url, r"is not empty \(it holds recipes\)"),
        (str(book.folder), "is there already"),
        (str(tmp_path / "nowhere"), "its folder is not there"),
        ("sqlite:///labbook.db", "is not PostgreSQL"),
        ("mysql://lab/book", "is not PostgreSQL"),
    ):
        with pytest.raises(UsageError, match=text):
            copied(book.folder, target)
    with refuses(BookVersion, "not made by"):
        copied(postgres_url, tmp_path)
    with engine.connect() as connection:
        assert sa.inspect(connection).get_table_names() == ["recipes"]
    engine.dispose()
    assert rows(book.folder) == before
    assert list(tmp_path.rglob(".labbook.db.*")) == []


@pytest.mark.parametrize("target", ["sqlite", pytest.param("postgresql", marks=pytest.mark.soak)])
def test_a_copy_that_is_killed_can_be_made_again(
    tmp_path: Path, commands: Commands, postgres_url: str, target: str
) -> None:
    book = small_book(tmp_path)
    place = tmp_path / "copy" if target == "sqlite" else postgres_url
    (tmp_path / "copy").mkdir()
    chance, died = random.Random(3), 0
    for _ in range(4):
        running = commands.start("db", "copy", book.folder, place)
        time.sleep(chance.uniform(0, 0.3))
        running.kill()
        code = running.wait()
        assert code in (0, KILLED), running.output.read_text()
        if code == 0:
            break
        died += 1
    if code:
        code, said = commands.run("db", "copy", book.folder, place)
        assert code == 0, said
    assert died > 0
    assert rows(place) == rows(book.folder)
    shutil.rmtree(tmp_path / "copy")
