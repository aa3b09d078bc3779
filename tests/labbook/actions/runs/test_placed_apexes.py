"""An apex that a person put at another time, and a jump that one added: measured each time, and counted as others."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import InputRefused, UsageError
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.report_command import state_report
from labbook.actions.runs.jump_review import RunReview, add, decide, move, review
from labbook.actions.runs.run_plot import plot_run
from labbook.actions.runs.run_view import run_view
from labbook.actions.upkeep.merging import merge
from labbook.actions.upkeep.report_differences import report_named
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.book.opening import Book
from labbook.book.report_numbers import read_numbers
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import ADA, BEN, SmallBook, small_book
from tests.helpers.hopping_log import REST_LENGTH_M, RISE_M, apex_s, hopping_log, landing_s
from tests.helpers.statements import state
from tests.helpers.upkeep import health, rebuilt, rebuilt_alike
from tests.helpers.wording import refuses, says

RUN = "r001"
HEIGHT_M = REST_LENGTH_M + RISE_M


@pytest.fixture
def made(tmp_path: Path) -> SmallBook:
    """A book of which r001 has ten jumps, and the detector misses the one out of stance 4."""
    small = small_book(tmp_path, ingested=False, two_people=True)
    small.log(RUN).write_bytes(hopping_log(10, shallow=[4]))
    with small.open() as book:
        ingest_file(book, small.log(RUN), IngestRequest(run=RUN, person=ADA))
        ingest_file(book, small.log("r002"), IngestRequest(person=ADA))
    return small


def reviewed(book: Book) -> RunReview:
    with book.reading() as connection:
        return review(book, connection, RUN)


def number_near(book: Book, at_s: float) -> int:
    """The number of the jump whose apex is there."""
    (found,) = (item for item in reviewed(book).jumps if abs((item.jump.apex_s or 0.0) - at_s) < 0.1)
    return found.jump.number


def apexes(book: Book, **settings: Any) -> RunApexes:
    """What the last report has of the run, as the protocol finds it."""
    done = state_report(book, None, ADA, lambda _step: None)
    scope = {"run": RUN, "detector": "robust", "heed_decisions": True, **settings}
    (found,) = (
        one
        for one in done.computed.made.values()
        if isinstance(one, RunApexes) and scope.items() <= one.origin.scope.items()
    )
    return found


def put(book: Book, action: Callable[..., Any], *given: object, person: str = ADA, **more: Any) -> Any:
    return state(book, action, RUN, *given, person=person, **more)


def test_an_added_jump_counts_in_every_number_until_it_is_taken_back(made: SmallBook) -> None:
    with made.open() as book:
        before = apexes(book)
        count = len(reviewed(book).jumps)
        found, stated = put(book, add, apex_s(4) + 0.01, "other", None)
        assert stated
        assert found.jump.apex_height_m == pytest.approx(HEIGHT_M, abs=0.0005)
        assert found.jump.number == 4
        jumps = reviewed(book).jumps
        assert [item.jump.number for item in jumps] == [*range(1, count + 2)]
        assert [item.jump.apex_s for item in jumps if item.jump.apex_s] == sorted(
            item.jump.apex_s for item in jumps if item.jump.apex_s
        )
        after = apexes(book)
        assert len(after.heights_m) == len(before.heights_m) + 1
        assert found.jump.apex_height_m in after.heights_m
        assert after.jumps_found.value == before.jumps_found.value + 1
        assert after.apex_height.provenance != before.apex_height.provenance
        with book.reading() as connection:
            assert run_view(Detections(connection, book.store), book.configuration, RUN).jumps_found == 10
        again, stated = put(book, add, apex_s(4) + 0.01, "other", None)
        assert (again.jump, stated) == (found.jump, False)
        put(book, decide, [4], "clear", "other", None)
        back = apexes(book)
        assert back.heights_m == before.heights_m
        assert back.apex_height.provenance == before.apex_height.provenance
    assert health(made).whole


def test_a_moved_apex_is_measured_where_it_was_put_and_why_names_it(made: SmallBook) -> None:
    """The detector took a hand that lifts the robot for the flight: here, the apex of the one before."""
    with made.open() as book:
        number = number_near(book, apex_s(3))
        found, stated = put(book, move, number, apex_s(4), "wrong_apex", "the flight before was a hand")
        assert stated
        assert (found.jump.number, found.jump.touchdown_s) == (number, pytest.approx(landing_s(4), abs=0.01))
        assert found.jump.apex_s == pytest.approx(apex_s(4), abs=0.003)
        assert found.as_found is not None
        assert found.as_found.apex_s == pytest.approx(apex_s(3), abs=0.003)
        assert found.jump.apex_height_m in apexes(book).heights_m
        assert found.placed is not None
        with book.reading() as connection:
            numbers = read_numbers(book.store.root, report_named(connection, "last"))
        resting = [
            one.id
            for one in numbers.numbers.values()
            if found.placed.uid in {leaf.input_uid for leaf in numbers.leaves_of(one)}
        ]
        assert len(apexes(book, heed_decisions=False).heights_m) == 9
        assert any(abs(m - HEIGHT_M) < 0.001 for m in apexes(book, detector="published").heights_m)
    assert resting
    why = good(labbook("why", resting[0], "--check", at=made.folder)).out
    says(why, "move", "wrong_apex", ADA)


def test_what_a_person_put_survives_a_rebuild_a_check_and_a_picture(made: SmallBook, tmp_path: Path) -> None:
    with made.open() as book:
        put(book, add, apex_s(4), "other", "seen on the film")
        put(book, move, number_near(book, apex_s(7)), apex_s(7) + 0.02, "wrong_apex", None, person=BEN, blind=True)
        before = reviewed(book).jumps
        with book.reading() as connection:
            plot_run(book, connection, RUN, 4, tmp_path / "jump.svg")
    rebuilt_alike(made)
    with made.open() as book:
        assert reviewed(book).jumps == before
        moved = next(item for item in before if item.placed is not None and item.placed.person == BEN)
        assert moved.placed is not None
        assert (moved.placed.at_s, moved.placed.blind) == (apex_s(7) + 0.02, True)
        assert moved.placed.old_value == moved.before.apex_height_m
    assert health(made, deep=True).whole


def test_numbers_without_such_verdicts_are_those_of_before_and_those_with_them_do_not_come_from_the_cache(
    made: SmallBook,
) -> None:
    with made.open() as book:
        first = apexes(book)
        put(book, add, apex_s(4), "other", None)
        second = apexes(book)
        shutil.rmtree(book.store.root / "numbers")
    rebuilt(made)
    with made.open() as book:
        assert apexes(book) == second
        put(book, decide, [number_near(book, apex_s(4))], "clear", "other", None)
        assert apexes(book) == first


def test_a_verdict_on_an_added_jump_is_one_as_on_others(made: SmallBook) -> None:
    with made.open() as book:
        put(book, add, apex_s(4), "other", None)
        put(book, decide, [4], "reject", "touched_by_hand", None, person=BEN)
        item = reviewed(book).jumps[3]
        assert item.excluded is not None
        assert [(said.person, said.verdict) for said in item.verdicts] == [(ADA, "add"), (BEN, "reject")]
        put(book, decide, [4], "accept", "looks_right", None, person=BEN)
        assert reviewed(book).jumps[3].excluded is None
        put(book, move, 4, apex_s(4) - 0.02, "wrong_apex", None, person=BEN)
        item = reviewed(book).jumps[3]
        assert (item.excluded, item.placed is not None and item.placed.person) == (None, BEN)


def test_what_cannot_be_said_is_refused_with_the_reason(made: SmallBook) -> None:
    with made.open() as book:
        entries = len(reviewed(book).jumps)
        with refuses(UsageError, RUN, "above"):
            put(book, add, landing_s(3) + 0.1, "other", None)
        with refuses(UsageError, RUN, "jump 2", "move"):
            put(book, add, apex_s(2) + 0.03, "other", None)
        with refuses(UsageError, "jump 2"):
            put(book, move, 1, apex_s(2), "wrong_apex", None)
        with refuses(UsageError, "no jump 40"):
            put(book, move, 40, apex_s(2), "wrong_apex", None)
        with refuses(UsageError, "no log 2"):
            put(book, add, apex_s(4), "other", None, log=2)
        with refuses(UsageError, "tired"):
            put(book, add, apex_s(4), "tired", None)
        assert len(reviewed(book).jumps) == entries


def test_numbers_that_mean_other_jumps_meanwhile_are_not_taken(made: SmallBook) -> None:
    with made.open() as book:
        seen = reviewed(book)
        put(book, add, apex_s(4), "other", None, person=BEN)
        with refuses(UsageError, "jumps list"):
            put(book, decide, [5], "reject", "misfire", None, found=seen)


def test_of_several_logs_the_one_meant_is_named(made: SmallBook) -> None:
    with made.open() as book:
        path = made.instruments / "second.csv"
        path.write_bytes(hopping_log(5, shallow=[3], rise_m=RISE_M))
        good(labbook("correct", RUN, "starts=2", "--why", "restarted", "--as", "AN", at=made.folder))
        ingest_file(book, path, IngestRequest(run=RUN, person=ADA))
        assert len(reviewed(book).signals) == 2
        with refuses(UsageError, "2 logs", "--log"):
            put(book, add, apex_s(3), "other", None)
        which = next(
            place for place, signal in enumerate(reviewed(book).signals, start=1) if signal.file_name == "second.csv"
        )
        found, _stated = put(book, add, apex_s(3), "other", None, log=which)
        assert found.signal_sha256 == reviewed(book).signals[which - 1].sha256


def test_it_comes_along_in_a_merge(made: SmallBook, tmp_path: Path) -> None:
    laptop = SmallBook(tmp_path / "laptop", made.instruments)
    shutil.copytree(made.folder, laptop.folder)
    with laptop.open() as book:
        put(book, add, apex_s(4), "other", None, person=BEN)
        there = reviewed(book).jumps
    with made.open() as book:
        merge(book, laptop.folder, ADA)
        assert reviewed(book).jumps == there
    with laptop.open() as book:
        put(book, move, 2, apex_s(2) + 0.01, "wrong_apex", None, person=BEN)
    with made.open() as book:
        put(book, move, 2, apex_s(2) - 0.01, "wrong_apex", None)
        with refuses(InputRefused, "two verdicts", "move"):
            merge(book, laptop.folder, ADA)


def test_the_commands(made: SmallBook) -> None:
    at = f"{apex_s(4):.3f}"
    done = good(labbook("jumps", "add", RUN, "--at", at, "--as", "BO", "--json", at=made.folder)).json
    assert (done["run"], done["jumps"], done["verdict"]) == (RUN, [4], "add")
    assert done["jump"]["jump"]["apex_height_m"] == pytest.approx(HEIGHT_M, abs=0.001)
    listed = good(labbook("jumps", "list", RUN, at=made.folder)).out
    says(listed, "added: ")
    moved = good(labbook("jumps", "move", RUN, "4", "--at", f"{apex_s(4) + 0.02:.3f}", "--as", "AN", at=made.folder))
    says(moved.out, RUN, "jump 4", " mm")
    shown = good(labbook("show", RUN, at=made.folder)).out
    says(shown, "r001")
    good(labbook("jumps", "clear", RUN, "4", "--as", "AN", at=made.folder))
    assert "added" not in good(labbook("jumps", "list", RUN, at=made.folder)).out
    refused(labbook("jumps", "add", RUN, "--at", "soon", "--as", "AN", at=made.folder), 2, "soon")
    refused(labbook("jumps", "add", RUN, "--at", "nan", "--as", "AN", at=made.folder), 2, "nan")


def test_a_server_keeps_it_as_a_file_does(tmp_path: Path, postgres_url: str) -> None:
    small = small_book(tmp_path, database_url=postgres_url)
    with small.open() as book:
        at_s = (reviewed(book).jumps[1].jump.apex_s or 0.0) + 0.01
        found, _stated = put(book, move, 2, at_s, "wrong_apex", None)
        put(book, decide, [2], "accept", "looks_right", None, blind=True)
        assert reviewed(book).jumps[1].jump == found.jump
    rebuilt_alike(small)
    with small.open() as book:
        item = reviewed(book).jumps[1]
        assert item.jump == found.jump
        assert item.decision is not None
        assert item.decision.blind
