"""A book of the version before: upgraded on both engines, it shows the same numbers, and every printed id answers."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema import migrations
from data_schema.errors import BookVersion
from data_schema.queries.charges import charges_by_run, every_charge
from data_schema.queries.detections import jump_decisions, verdicts_waiting
from data_schema.queries.runs import list_runs
from data_schema.queries.signals import signals_of_runs
from data_schema.vocabulary import FileRole
from labbook.actions.upkeep.health import check_book
from labbook.actions.upkeep.tracing import NumberTrace, PrintedNumber, trace
from labbook.analysis.results.result_cache import equals_printed
from labbook.book.opening import Book, engine_of, opened, read_configuration
from labbook.book.rebuilding import rebuild_database
from labbook.book.upgrading import upgrade_database
from labbook.terminal import progress
from tests.helpers.databases import all_rows_by_name
from tests.helpers.old_book import unpack
from tests.helpers.postgres import Cluster

RUNS, LOGS, VERDICTS = 271, 265, 16


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.soak)])
def old(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, dict[str, float | None]]:
    """The old book's folder, and what it printed."""
    cluster: Cluster | None = None if request.param == "sqlite" else request.getfixturevalue("cluster")
    return tmp_path, unpack(tmp_path, cluster)


def upgrade(folder: Path) -> None:
    engine = engine_of(folder, read_configuration(folder))
    try:
        done = upgrade_database(folder, engine)
    finally:
        engine.dispose()
    assert (done.before, done.after) == ("0001", migrations.newest())


def holds(book: Book) -> None:
    """What the old book held counts as it did."""
    with book.reading() as connection:
        assert len(list_runs(connection)) == RUNS
        assert len(signals_of_runs(connection, FileRole.LOG)) == LOGS
        counted = sum(len(charges) for charges in charges_by_run(connection).values())
        assert counted == RUNS
        assert {charge.charge_mah for charge in every_charge(connection)} >= {97.0, 103.0, 250.0}, "corrected, waiting"
        said = {decision.uid for several in jump_decisions(connection).values() for decision in several}
        assert len(said) == VERDICTS
        assert verdicts_waiting(connection) == []


def answers(book: Book, printed: dict[str, float | None], every: int) -> int:
    """Every printed id answers; returns how many lead to a number that this labbook still computes, with its value."""
    found = 0
    with book.reading() as connection:
        for uid, value in list(printed.items())[::every]:
            told = trace(connection, uid)
            if isinstance(told, NumberTrace):
                assert equals_printed(value, told.number.value), uid
                found += 1
            else:
                assert isinstance(told, PrintedNumber)
                assert equals_printed(value, told.value), uid
    return found


def test_an_old_book_is_named_as_such_and_upgrades(old: tuple[Path, dict[str, float | None]]) -> None:
    folder, printed = old
    with pytest.raises(BookVersion, match="`labbook db upgrade`"), opened(folder):
        pass
    upgrade(folder)
    with opened(folder) as book:
        holds(book)
        assert answers(book, printed, every=199) == len(list(printed)[::199])


@pytest.mark.soak
def test_an_upgraded_book_is_a_rebuilt_one(old: tuple[Path, dict[str, float | None]]) -> None:
    folder, printed = old
    upgrade(folder)
    found = rebuild_database(folder, lambda _step: None).differences
    assert found.numbers_changed == 0
    assert found.files_waiting == ()
    with opened(folder) as book:
        holds(book)
        answers(book, printed, every=31)
        assert check_book(folder, lambda total: progress("checking", total, shown=False), deep=True).problems == ()
        rows = all_rows_by_name(book.engine)
    if not (folder / "labbook.db").exists():
        return
    (folder / "labbook.db").unlink()
    rebuild_database(folder, lambda _step: None)
    with opened(folder) as book:
        assert all_rows_by_name(book.engine) == rows
