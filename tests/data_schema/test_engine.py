"""Both engines as labbook sets them up: what is set is so, what half happened did not, and who waits for whom."""

from __future__ import annotations

import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, closing
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema.engine import postgres_engine, reading, sqlite_engine, writing
from data_schema.errors import BookBusy, BookDamaged, UsageError
from tests.helpers.databases import ENGINES, make_empty_sqlite
from tests.helpers.postgres import Cluster
from tests.helpers.wording import refuses

PERSON = "INSERT INTO person (uid, name, initials) VALUES ('{0}', '{0}', '{0}')"


@pytest.fixture
def sqlite_path(tmp_path: Path) -> Path:
    path = tmp_path / "labbook.db"
    make_empty_sqlite(path)
    return path


@pytest.fixture(params=ENGINES)
def impatient(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[sa.Engine, sa.Engine]]:
    """Two engines on one database with all tables, that wait for each other for a twentieth of a second."""
    if request.param == "sqlite":
        path = tmp_path / "labbook.db"
        path.write_bytes(request.getfixturevalue("sqlite_with_tables").read_bytes())
        engines = [sqlite_engine(path, busy_timeout_s=0.05) for _ in range(2)]
        name = None
    else:
        cluster: Cluster = request.getfixturevalue("cluster")
        name = cluster.fresh(request.getfixturevalue("template_with_tables"))
        engines = [postgres_engine(cluster.url(name), busy_timeout_s=0.05) for _ in range(2)]
    yield engines[0], engines[1]
    for engine in engines:
        engine.dispose()
    if name is not None:
        cluster.drop(name)


def people(connection: sa.Connection) -> int:
    return int(connection.exec_driver_sql("SELECT count(*) FROM person").scalar_one())


def test_every_connection_has_the_settings(sqlite_path: Path) -> None:
    names = ("journal_mode", "synchronous", "foreign_keys", "recursive_triggers", "busy_timeout")
    engine = sqlite_engine(sqlite_path)
    with engine.connect() as first, engine.connect() as second:
        for connection in (first, second):
            found = [connection.exec_driver_sql(f"PRAGMA {name}").scalar_one() for name in names]
            assert found == ["wal", 2, 1, 1, 10_000]
    engine.dispose()


def test_a_setting_that_cannot_be_made_is_an_error(tmp_path: Path) -> None:
    """Another program holds the file in the old journal mode, so that write-ahead logging cannot be switched on."""
    path = tmp_path / "labbook.db"
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.executescript("CREATE TABLE t (a); BEGIN IMMEDIATE; INSERT INTO t VALUES (1)")
        engine = sqlite_engine(path, busy_timeout_s=0.05)
        with pytest.raises(BookBusy), reading(engine):
            pass
        engine.dispose()


def test_a_path_may_hold_any_character(tmp_path: Path) -> None:
    folder = tmp_path / "100 % sure? #7 ü"
    folder.mkdir()
    make_empty_sqlite(folder / "labbook.db")
    engine = sqlite_engine(folder / "labbook.db")
    with engine.begin() as connection:
        connection.exec_driver_sql("CREATE TABLE t (a INTEGER)")
    engine.dispose()
    assert [path.relative_to(tmp_path) for path in tmp_path.rglob("*.*")] == [Path(folder.name, "labbook.db")]


def test_a_file_that_is_no_database_is_damage_with_the_way_out(tmp_path: Path) -> None:
    path = tmp_path / "labbook.db"
    path.write_bytes(b"not a database " * 1000)
    engine = sqlite_engine(path)
    with pytest.raises(BookDamaged, match="labbook rebuild"), reading(engine):
        pass
    engine.dispose()


def test_what_is_not_postgresql_is_refused() -> None:
    for url in ("mysql://host/name", "sqlite:///x.db", "nonsense"):
        with pytest.raises(UsageError, match=r"postgresql\+psycopg://"):
            postgres_engine(url)


def test_a_server_that_does_not_answer_is_a_sentence(tmp_path: Path) -> None:
    engine = postgres_engine(f"postgresql+psycopg://labbook@/nothing?host={tmp_path}")
    with pytest.raises(BookDamaged, match="did not answer"), reading(engine):
        pass
    engine.dispose()


def fail(transaction: AbstractContextManager[sa.Connection], *statements: str) -> None:
    """Have an error of Python after these statements."""
    with transaction as connection:
        for statement in statements:
            connection.exec_driver_sql(statement)
        raise ZeroDivisionError


def test_tables_made_in_a_failed_transaction_do_not_stay(empty_engine: sa.Engine) -> None:
    with pytest.raises(ZeroDivisionError):
        fail(empty_engine.begin(), "CREATE TABLE half (a INTEGER)", "INSERT INTO half VALUES (1)")
    with reading(empty_engine) as connection:
        assert sa.inspect(connection).get_table_names() == []


def test_a_writer_waits_for_the_other_and_sees_what_it_wrote(engine: sa.Engine) -> None:
    seen: list[int] = []

    def second() -> None:
        with writing(engine) as connection:
            seen.append(people(connection))
            connection.exec_driver_sql(PERSON.format("second"))

    thread = threading.Thread(target=second)
    with writing(engine) as connection:
        assert people(connection) == 0
        thread.start()
        time.sleep(0.1)
        connection.exec_driver_sql(PERSON.format("first"))
    thread.join()
    assert seen == [1]
    with reading(engine) as connection:
        assert people(connection) == 2


def test_a_writer_that_waits_too_long_gets_a_sentence(impatient: tuple[sa.Engine, sa.Engine]) -> None:
    first, second = impatient
    with writing(first) as connection:
        connection.exec_driver_sql(PERSON.format("first"))
        with refuses(BookBusy, "program is writing") as caught, writing(second):
            pass
        assert caught.value.exit_code == 3
        with reading(second) as reader:  # a reader never waits
            assert people(reader) == 0
    with writing(second) as connection:
        assert people(connection) == 1


def test_a_reader_sees_one_state_to_its_end(engine: sa.Engine) -> None:
    with reading(engine) as reader:
        assert people(reader) == 0
        with writing(engine) as connection:
            connection.exec_driver_sql(PERSON.format("meanwhile"))
        assert people(reader) == 0
    with reading(engine) as reader:
        assert people(reader) == 1


def test_a_failed_writer_leaves_nothing(engine: sa.Engine) -> None:
    with pytest.raises(ZeroDivisionError):
        fail(writing(engine), PERSON.format("nobody"))
    with reading(engine) as connection:
        assert people(connection) == 0
