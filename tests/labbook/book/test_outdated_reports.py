"""Which reports a statement names: of each selection the newest one with numbers that depend on what it changes."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from data_schema.queries.charges import charges_of_run
from data_schema.queries.reports import list_reports
from ingest.tables.sheet import SheetFile
from labbook.actions.files.assigning import assign
from labbook.actions.files.stored_files import withdraw
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct, void
from labbook.actions.runs.jump_review import decide
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.report_numbers import outdated_reports
from labbook.book.write_session import DryRun, WriteSession
from tests.helpers.books import ADA, SmallBook, copy_of, instrument_files, small_book
from tests.helpers.statements import note

OF_ALL, OF_SMALL = 2, 3
"""Numbers of the newest report of all runs, and of that of the small foot's."""


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Book]:
    def made(folder: Path) -> SmallBook:
        small = small_book(folder)
        with small.open() as standing:
            for where in (None, None, "foot=small"):
                state_report(standing, where, ADA, lambda _step: None)
        return small

    with copy_of("reported-thrice", made, tmp_path_factory.mktemp("reported")).open() as standing:
        yield standing


def named_after(book: Book, said: Callable[[WriteSession], object]) -> list[int]:
    """State something and take it back; returns the numbers of the reports that are named."""
    found: list[str] = []
    with contextlib.suppress(DryRun), book.session(ADA) as session:
        said(session)
        found = outdated_reports(session)
        raise DryRun
    with book.reading() as connection:
        numbers = {report.called: report.number for report in list_reports(connection)}
    return [numbers[called] for called in found]


def charge_of(book: Book, run: str) -> str:
    with book.reading() as connection:
        (charge,) = charges_of_run(connection, run_named(connection, run).uid)
    return f"charge:{charge.uid}"


@pytest.mark.parametrize(
    ("target", "field"),
    [
        ("r002", "started_utc=2021-06-14T09:31:00-04:00"),
        ("r007", "position_in_day=12"),
        ("study", "jumps_nominal=26"),
        ("study", "time_zone=Europe/Berlin"),
    ],
)
def test_a_column_without_numbers_on_it_names_none(target: str, field: str, book: Book) -> None:
    assert named_after(book, lambda session: correct(book, session, target, [field], "x")) == []


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        (["position_in_day=12"], [OF_ALL, OF_SMALL]),  # what is adjusted for the place in the day
        (["jumps_made=2"], [OF_ALL, OF_SMALL]),
        (["foot=large"], [OF_ALL, OF_SMALL]),
        (["name=r902"], [OF_ALL, OF_SMALL]),
        (["kind=idle", "jumps_made=0", "levels=none"], [OF_ALL, OF_SMALL]),
    ],
)
def test_a_column_of_a_run_names_what_uses_it(fields: list[str], named: list[int], book: Book) -> None:
    assert named_after(book, lambda session: correct(book, session, "r002", fields, "x")) == named


@pytest.mark.parametrize("field", ["end_voltage_v=16.7", "duration_s=700", "stated_pack=C"])
def test_what_else_a_charge_says_names_none(field: str, book: Book) -> None:
    target = charge_of(book, "r002")
    assert named_after(book, lambda session: correct(book, session, target, [field], "x")) == []


def test_an_idle_run_that_joins_names_every_joule(book: Book) -> None:
    head = instrument_files()["runs.csv"].decode().splitlines()[0]
    sheet = f"{head}\nr017,2021-06-16,9,idle,,,,A,hopper,17:00,1500,,1,\n"

    def declared(session: WriteSession) -> object:
        return import_runs(book, session, SheetFile("more.csv", sheet.encode()))

    assert named_after(book, declared) == [OF_ALL, OF_SMALL]


def test_a_charge_of_another_run_by_its_sheet_names_the_reports_of_both(book: Book) -> None:
    of_large, of_small = charge_of(book, "r003"), charge_of(book, "r002")

    def exchanged(session: WriteSession) -> None:
        correct(book, session, of_small, ["run=none"], "x")
        session.entries.clear()
        correct(book, session, of_large, ["stated_run=r002"], "x")

    assert named_after(book, exchanged) == [OF_ALL, OF_SMALL]


@pytest.mark.parametrize(("run", "named"), [("r002", [OF_ALL, OF_SMALL]), ("r003", [OF_ALL])])
def test_a_run_names_the_newest_report_of_each_selection_that_uses_it(run: str, named: list[int], book: Book) -> None:
    """r003 is of the large foot, which the second selection leaves out."""
    target = charge_of(book, run)
    assert named_after(book, lambda session: correct(book, session, target, ["charge_mah=118"], "x")) == named
    assert named_after(book, lambda session: correct(book, session, run, ["duration_s=700"], "x")) == named
    assert named_after(book, lambda session: void(session, run, "was touched")) == named
    assert named_after(book, lambda session: assign(session, f"{run}.csv", "none", "wrong card")) == named
    assert named_after(book, lambda session: decide(book, session, run, [2], "reject", "misfire", None)) == named


def test_what_all_runs_depend_on_names_all(book: Book) -> None:
    both = [OF_ALL, OF_SMALL]
    idle = charge_of(book, "r007")
    assert named_after(book, lambda session: void(session, "r007", "was touched")) == both
    assert named_after(book, lambda session: correct(book, session, "study", ["reference_voltage_v=16.8"], "x")) == both
    assert named_after(book, lambda session: correct(book, session, idle, ["charge_mah=118"], "x")) == both
    assert named_after(book, lambda session: correct(book, session, "robot:hopper", ["rest_length_m=0.3"], "x")) == both


def test_what_no_number_depends_on_names_none(book: Book) -> None:
    assert named_after(book, lambda session: note(session, "left rail squeaked", "r002")) == []
    assert named_after(book, lambda session: correct(book, session, "battery:A", ["capacity_mah=6000"], "x")) == []
    assert named_after(book, lambda session: correct(book, session, "r002", ["starts=4"], "x")) == []


def test_what_is_taken_off_a_run_names_the_reports_of_its_numbers(book: Book) -> None:
    target = charge_of(book, "r002")
    both = [OF_ALL, OF_SMALL]
    assert named_after(book, lambda session: correct(book, session, target, ["run=none"], "another's")) == both
    assert named_after(book, lambda session: withdraw(session, "r002.csv", "copied twice")) == both
