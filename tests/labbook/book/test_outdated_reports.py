"""Which reports a statement names: of each selection the newest one with numbers that depend on what it changes."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

import pytest

from data_schema.queries.charges import charges_of_run
from data_schema.queries.history import list_reports
from ingest.tables.sheet import SheetFile
from labbook.actions.files.assigning import assign
from labbook.actions.files.stored_files import withdraw
from labbook.actions.runs.correcting import correct, void
from labbook.actions.runs.jump_review import decide
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.report_numbers import outdated_reports
from labbook.book.write_session import DryRun, WriteSession
from tests.helpers.books import ADA, instrument_files, reported_book
from tests.helpers.statements import note

OF_ALL, OF_SMALL = 2, 3
"""Numbers of the newest report of all runs, and of that of the small foot's."""


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Book]:
    folder = tmp_path_factory.mktemp("reported")
    with reported_book(folder, None, None, "foot=small").open() as standing:
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


def target_of(book: Book, name: str) -> str:
    """What `correct` takes; `charge r002` is the charge of that run."""
    if not name.startswith("charge "):
        return name
    with book.reading() as connection:
        (charge,) = charges_of_run(connection, run_named(connection, name.removeprefix("charge ")).uid)
    return f"charge:{charge.uid}"


BOTH = [OF_ALL, OF_SMALL]


@pytest.mark.parametrize(
    ("target", "fields", "named"),
    [
        ("r002", ["started_utc=2021-06-14T09:31:00-04:00"], []),
        ("r002", ["starts=4"], []),
        ("r002", ["position_in_day=12"], BOTH),  # what is adjusted for the place in the day
        ("r002", ["jumps_made=2"], BOTH),
        ("r002", ["foot=large"], BOTH),
        ("r002", ["name=r902"], BOTH),
        ("r002", ["duration_s=700"], BOTH),
        ("r002", ["kind=idle", "jumps_made=0", "levels=none"], BOTH),
        ("r003", ["duration_s=700"], [OF_ALL]),  # of the large foot, which the second selection leaves out
        ("r007", ["position_in_day=12"], []),
        ("study", ["jumps_nominal=26"], []),
        ("study", ["time_zone=Europe/Berlin"], []),
        ("study", ["reference_voltage_v=16.8"], BOTH),
        ("robot:hopper", ["rest_length_m=0.3"], BOTH),
        ("battery:A", ["capacity_mah=6000"], []),
        ("charge r002", ["charge_mah=118"], BOTH),
        ("charge r002", ["run=none"], BOTH),
        ("charge r002", ["end_voltage_v=16.7"], []),
        ("charge r002", ["duration_s=700"], []),
        ("charge r002", ["stated_pack=C"], []),
        ("charge r003", ["charge_mah=118"], [OF_ALL]),
        ("charge r007", ["charge_mah=118"], BOTH),  # of an idle run
    ],
)
def test_a_correction_names_what_uses_the_column(target: str, fields: list[str], named: list[int], book: Book) -> None:
    assert named_after(book, lambda session: correct(book, session, target_of(book, target), fields, "x")) == named


def test_an_idle_run_that_joins_names_every_joule(book: Book) -> None:
    head = instrument_files()["runs.csv"].decode().splitlines()[0]
    sheet = SheetFile("more.csv", f"{head}\nr017,2021-06-16,9,idle,,,,A,hopper,17:00,1500,,1,\n".encode())
    assert named_after(book, lambda session: import_runs(book, session, sheet)) == BOTH


def test_a_charge_of_another_run_by_its_sheet_names_the_reports_of_both(book: Book) -> None:
    of_large, of_small = target_of(book, "charge r003"), target_of(book, "charge r002")

    def exchanged(session: WriteSession) -> None:
        correct(book, session, of_small, ["run=none"], "x")
        session.entries.clear()
        correct(book, session, of_large, ["stated_run=r002"], "x")

    assert named_after(book, exchanged) == BOTH


@pytest.mark.parametrize(("run", "named"), [("r002", BOTH), ("r003", [OF_ALL])])
def test_a_run_names_the_newest_report_of_each_selection_that_uses_it(run: str, named: list[int], book: Book) -> None:
    statements: list[Callable[[WriteSession], object]] = [
        lambda session: void(session, run, "was touched"),
        lambda session: assign(session, f"{run}.csv", "none", "wrong card"),
        lambda session: withdraw(session, f"{run}.csv", "copied twice"),
        lambda session: decide(book, session, run, [2], "reject", "misfire", None),
    ]
    assert [named_after(book, said) for said in statements] == [named] * len(statements)


def test_an_idle_run_names_all_reports_and_a_remark_none(book: Book) -> None:
    assert named_after(book, lambda session: void(session, "r007", "was touched")) == BOTH
    assert named_after(book, lambda session: note(session, "left rail squeaked", "r002")) == []
