"""What a statement names as stale: what rests on what it changes, and nothing else. Tried on one report, kept never."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from data_schema.queries.charges import charges_of_run
from ingest.tables.sheet import SheetFile
from labbook.actions.files.assigning import assign
from labbook.actions.report_command import state_report
from labbook.actions.runs.charges import state_charge
from labbook.actions.runs.correcting import correct, void
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.write_session import DryRun, WriteSession
from tests.helpers.books import ADA, instrument_files, reported_book, small_book

Stale = dict[str, set[str]]
NOTHING: Stale = {}


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Book]:
    with reported_book(tmp_path_factory.mktemp("reported")).open() as standing:
        yield standing


def stale_after(book: Book, *said: Callable[[WriteSession], object]) -> Stale:
    """State something and take it back; returns what became stale by its last part: kinds, and runs they are about."""
    found: Stale = {}
    with contextlib.suppress(DryRun), book.session(ADA) as session:
        for statement in said:
            session.stale.clear()
            statement(session)
        for kind, scope in session.stale:
            found.setdefault(kind, set()).add(json.loads(scope).get("run", ""))
        raise DryRun
    return found


def corrected(book: Book, target: str, *fields: str) -> Stale:
    return stale_after(book, lambda session: correct(book, session, target, fields, "x"))


def charge_of(book: Book, run: str) -> str:
    with book.reading() as connection:
        (charge,) = charges_of_run(connection, run_named(connection, run).uid)
    return f"charge:{charge.uid}"


@pytest.mark.parametrize(
    ("target", "field"),
    [
        ("r002", "started_utc=2021-06-14T09:31:00-04:00"),
        ("r007", "position_in_day=12"),
        ("battery:A", "capacity_mah=6000"),
        ("study", "jumps_nominal=26"),
        ("study", "time_zone=Europe/Berlin"),
        ("robot:hopper", "body_mass_kg=1.9"),
    ],
)
def test_a_column_without_numbers_on_it_names_nothing(target: str, field: str, book: Book) -> None:
    assert corrected(book, target, field) == NOTHING


def test_the_place_of_a_jump_run_in_its_day_names_what_is_adjusted_for_it_alone(book: Book) -> None:
    assert corrected(book, "r002", "position_in_day=12").keys() == {"decision"}


@pytest.mark.parametrize("field", ["end_voltage_v=16.7", "duration_s=700", "stated_pack=C"])
def test_what_else_a_charge_says_names_nothing(field: str, book: Book) -> None:
    assert corrected(book, charge_of(book, "r002"), field) == NOTHING


def test_a_jump_run_names_its_numbers_and_its_conditions(book: Book) -> None:
    for columns in (["jumps_made=2"], ["duration_s=700"], ["foot=large"]):
        stale = corrected(book, "r002", *columns)
        assert stale["run_energy"] == stale["run_apexes"] == {"r002"}
        assert {"condition_summary", "decision", "thesis_route"} <= stale.keys()
        assert "passive_drain" not in stale


def test_a_charge_names_joules_and_no_apexes(book: Book) -> None:
    stale = corrected(book, charge_of(book, "r002"), "charge_mah=118")
    assert stale["run_energy"] == {"r002"}
    assert {"condition_summary", "decision", "thesis_route"} <= stale.keys()
    assert "run_apexes" not in stale


def test_a_charge_typed_in_later_names_its_condition(tmp_path: Path) -> None:
    with small_book(tmp_path).open() as book:
        with book.session(ADA) as session:
            correct(book, session, charge_of(book, "r001"), ["run=none"], "belongs elsewhere")
        state_report(book, None, ADA, lambda _step: None)
        typed = stale_after(book, lambda session: state_charge(session, book.configuration, "r001", 120.0, None, None))
    assert "condition_summary" in typed


def all_joules(stale: Stale) -> bool:
    return "passive_drain" in stale and len(stale["run_energy"]) == 12


def test_an_idle_run_names_the_drain_fit_and_every_joule(book: Book) -> None:
    assert all_joules(corrected(book, "r007", "duration_s=1300"))
    assert all_joules(corrected(book, charge_of(book, "r007"), "charge_mah=118"))
    assert all_joules(stale_after(book, lambda session: void(session, "r007", "was touched")))
    assert len(corrected(book, "study", "reference_voltage_v=16.8")["run_energy"]) == 12
    assert len(corrected(book, "robot:hopper", "rest_length_m=0.3")["run_apexes"]) == 12


def test_an_idle_run_that_joins_names_the_drain_fit_though_nothing_rested_on_it(book: Book) -> None:
    head = instrument_files()["runs.csv"].decode().splitlines()[0]
    sheet = f"{head}\nr017,2021-06-16,9,idle,,,,A,hopper,17:00,1500,,1,\n"

    def declared(session: WriteSession) -> object:
        return import_runs(book, session, SheetFile("more.csv", sheet.encode()))

    assert all_joules(stale_after(book, declared))
    assert all_joules(corrected(book, "r002", "kind=idle", "jumps_made=0", "levels=none"))


def test_a_log_taken_off_names_apexes_and_no_joules(book: Book) -> None:
    stale = stale_after(book, lambda session: assign(session, "r001.csv", "none", "wrong card"))
    assert stale["run_apexes"] == {"r001"}
    compared = {"decision", "decision_family", "thesis_route", "thesis_route_over_jumps"}
    assert stale.keys() == {"run_apexes", "condition_summary", *compared}
    moved = stale_after(book, lambda session: assign(session, "r001.csv", "r003", "mixed up"))
    assert moved["run_apexes"] == {"r001", "r003"}
