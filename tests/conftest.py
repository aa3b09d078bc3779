"""Databases for tests: each engine that labbook stores to, empty or with all tables."""

from __future__ import annotations

import gc
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import hypothesis
import numpy as np
import pytest
import sqlalchemy as sa
from sqlalchemy.dialects.postgresql.psycopg import PGDialect_psycopg
from sqlalchemy.dialects.sqlite.pysqlite import SQLiteDialect_pysqlite

from data_schema.engine import POSTGRES_SCHEMA, postgres_engine, sqlite_engine
from labbook.cli.main import GARBAGE_AFTER
from tests.helpers.advice import AdviceTaken
from tests.helpers.books import SmallBook, small_book
from tests.helpers.commands import Commands, running_commands
from tests.helpers.databases import ENGINES, make_all_tables, make_empty_sqlite
from tests.helpers.folders import folder_in_memory
from tests.helpers.once import SHARED, made_once
from tests.helpers.postgres import Cluster, NoServer, running_cluster

# A loaded machine is no fault of the code. Each run draws examples of its own: few, or in `make soak` many.
for profile, examples in (("few", 7), ("many", 200)):
    hypothesis.settings.register_profile(
        profile, max_examples=examples, deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
    )
hypothesis.settings.load_profile("few")

TESTS = Path(__file__).parent
ROOM_BYTES = 4 << 30
"""More than all files of a run, with those that failing tests keep."""


def with_all_tables() -> Path:
    """Return a SQLite file with all tables, to be copied."""

    def make(folder: Path) -> Path:
        path = folder / "labbook.db"
        make_empty_sqlite(path)
        engine = sqlite_engine(path)
        make_all_tables(engine)
        engine.dispose()
        return path

    return made_once("with_tables", make)


def pytest_configure(config: pytest.Config) -> None:
    """Make the folder that the processes of this run share; those that are started for it inherit its name.

    Books are many small files that live for a second: in memory, where there is room, each sync and removal is quick.
    """
    if not hasattr(config, "workerinput"):
        os.environ.setdefault("TMPDIR", str(folder_in_memory(ROOM_BYTES)))
        os.environ.setdefault(
            "OPENBLAS_NUM_THREADS", "1"
        )  # of processes that fill the cores, or threads wait for another
        tempfile.tempdir = None  # to be looked up anew
        shared = tempfile.TemporaryDirectory(prefix="labbook-tests-")
        config.add_cleanup(shared.cleanup)
        os.environ[SHARED] = shared.name
    elif config.workerinput["workerid"] == "gw1" and [Path(word).resolve() for word in config.args] == [TESTS]:
        # In a fresh checkout each of two compiles half of the files: they meet in the middle.
        folders = sorted({str(test.relative_to(TESTS).parts[0]) for test in TESTS.rglob("test_*.py")}, reverse=True)
        config.args = [str(TESTS / folder) for folder in folders]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give all processes the tests in one order."""
    items.sort(key=lambda item: item.path.relative_to(TESTS).parts[0])


def pytest_collection_finish() -> None:
    """Let the garbage collector leave alone what was imported and collected; it took a seventh of the time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(GARBAGE_AFTER)


@pytest.fixture(scope="session")
def cluster() -> Iterator[Cluster]:
    """A PostgreSQL server of this process' own; tests that need one are skipped where none can run."""
    try:
        with running_cluster() as running:
            yield running
    except NoServer as reason:
        pytest.skip(str(reason))


@pytest.fixture
def postgres_url(cluster: Cluster) -> Iterator[str]:
    """The address of an empty PostgreSQL database: always the same, so that books there can be copied."""
    cluster.make("own")
    yield cluster.url("own")
    cluster.drop("own")


@pytest.fixture(scope="session")
def template_with_tables(cluster: Cluster) -> str:
    """A PostgreSQL database with all tables, to be copied."""
    name = cluster.fresh()
    engine = postgres_engine(cluster.url(name))
    make_all_tables(engine)
    engine.dispose()
    return name


@pytest.fixture(scope="session")
def sqlite_with_tables() -> Path:
    """A SQLite file with all tables, to be copied."""
    return with_all_tables()


ADVICE = AdviceTaken()
"""What messages advise about the files that are read in this process."""


@pytest.fixture(scope="session", autouse=True)
def _files_are_noted_as_they_are_read() -> Iterator[None]:
    """Each test fails that is told something about a file which labbook then refuses."""
    with ADVICE.noting_files():
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[Any]:
    """After a test that passes, take the advice in what it read; a long one damages files in several ways at once."""
    ADVICE.clear()
    result = yield
    faults = [] if item.get_closest_marker("soak") else ADVICE.faults()
    assert not faults, "\n".join(faults)
    return result


@pytest.fixture(scope="session", autouse=True)
def _statements_are_compiled_once() -> Iterator[None]:
    """SQLAlchemy compiles a statement for each engine anew, and every book that is opened has one: here all share."""
    cache: sa.util.LRUCache[object, object] = sa.util.LRUCache(5000)
    make_engine = sa.create_engine

    def sharing(url: str, **options: Any) -> sa.Engine:
        return make_engine(url, execution_options={"compiled_cache": cache}, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sa, "create_engine", sharing)
        for dialect in (SQLiteDialect_pysqlite, PGDialect_psycopg):  # part of a statement's key: one is as another
            patch.setattr(dialect, "__eq__", lambda one, other: type(one) is type(other), raising=False)
            patch.setattr(dialect, "__hash__", lambda one: hash(type(one)), raising=False)
        yield


@pytest.fixture(scope="session", autouse=True)
def _arrays_are_compared_as_a_whole() -> Iterator[None]:
    """`pytest.approx` of an array compares number by number in Python: only where they differ, to say which."""
    kind: Any = type(pytest.approx(np.zeros(1)))
    by_number = kind.__eq__

    def compare(approx: Any, other: object) -> bool:
        wanted, found = np.asarray(approx.expected), np.asarray(other)
        if wanted.dtype.kind == found.dtype.kind == "f" and wanted.shape == found.shape:
            rel = (0.0 if approx.abs is not None else 1e-6) if approx.rel is None else approx.rel
            within = np.maximum(rel * np.abs(wanted), 1e-12 if approx.abs is None else approx.abs)
            with np.errstate(invalid="ignore"):  # of what is infinite
                if np.isfinite(wanted).all() and np.all(np.abs(found - wanted) <= within):
                    return True
        return bool(by_number(approx, other))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kind, "__eq__", compare)
        yield


@pytest.fixture(scope="session")
def postgres_book(cluster: Cluster, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished small book on the PostgreSQL database `book`, kept as `finished_book`: both are to be copied."""
    folder = tmp_path_factory.mktemp("postgres-book")
    cluster.make("book")
    small_book(folder, database_url=cluster.url("book"))
    cluster.make("finished_book", "book")
    return folder


@pytest.fixture(params=ENGINES)
def book(request: pytest.FixtureRequest, tmp_path: Path) -> SmallBook:
    """A finished small book of the test's own, once on SQLite and once on PostgreSQL."""
    if request.param == "sqlite":
        return small_book(tmp_path)
    shutil.copytree(request.getfixturevalue("postgres_book"), tmp_path, dirs_exist_ok=True)
    cluster: Cluster = request.getfixturevalue("cluster")
    cluster.drop("book")
    cluster.make("book", "finished_book")
    return SmallBook(tmp_path / "book", tmp_path / "instruments")


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[sa.Engine]:
    """An engine on a fresh database with all tables, once for SQLite and once for PostgreSQL."""
    if request.param == "sqlite":
        path = tmp_path / "labbook.db"
        path.write_bytes(with_all_tables().read_bytes())
        fresh = sqlite_engine(path)
        yield fresh
        fresh.dispose()
        return
    cluster: Cluster = request.getfixturevalue("cluster")
    name = cluster.fresh(request.getfixturevalue("template_with_tables"))
    fresh = postgres_engine(cluster.url(name))
    yield fresh
    fresh.dispose()
    cluster.drop(name)


@pytest.fixture(params=ENGINES)
def empty_engine(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[sa.Engine]:
    """An engine on a database without any table, once for SQLite and once for PostgreSQL."""
    if request.param == "sqlite":
        path = tmp_path / "labbook.db"
        make_empty_sqlite(path)
        fresh = sqlite_engine(path)
    else:
        fresh = postgres_engine(request.getfixturevalue("postgres_url"))
        with fresh.begin() as connection:
            connection.exec_driver_sql(f"CREATE SCHEMA {POSTGRES_SCHEMA}")
    yield fresh
    fresh.dispose()


@pytest.fixture(params=ENGINES)
def database_url(request: pytest.FixtureRequest) -> str | None:
    """What `[database] url` says: nothing for SQLite, then the address of an empty PostgreSQL database."""
    if request.param == "sqlite":
        return None
    url: str = request.getfixturevalue("postgres_url")
    return url


@pytest.fixture(scope="session")
def commands() -> Iterator[Commands]:
    """Real processes of the command line, quickly started."""
    with running_commands() as running:
        yield running
