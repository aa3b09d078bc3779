"""What differs between two runs, and nothing that does not; what differs follows from what was stated."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import pytest

from data_schema.vocabulary import ReasonCode, Verdict
from labbook.actions.files.assigning import assign
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.run_view import RunsCompared, RunView, compare_runs, run_view
from labbook.analysis.outcomes.detection import Detections
from labbook.book.opening import Book
from tests.cli.shell import good, labbook, refused, unchanged
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.statements import judge_blind, state
from tests.helpers.wording import says


@pytest.fixture
def whole(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path)


def views(book: Book, *names: str) -> list[RunView]:
    with book.reading() as connection:
        detections = Detections(connection, book.store)
        return [run_view(detections, book.configuration, name) for name in names]


def differing(found: RunsCompared) -> dict[tuple[str, str, str], tuple[Any, Any]]:
    """Both values by subject, what they are of, and what they are."""
    return {
        (subject, one.of, one.what): (one.first, one.second)
        for subject, several in found.by_subject.items()
        for one in several
    }


def compared(book: Book, first: str, second: str) -> dict[tuple[str, str, str], tuple[Any, Any]]:
    return differing(compare_runs(*views(book, first, second)))


def test_two_runs_of_a_day_differ_in_their_levels_logs_charges_and_numbers(whole: SmallBook) -> None:
    with whole.open() as book:
        found = compared(book, "r001", "r002")
        first, second = views(book, "r001", "r002")
    assert found["facts", "", "b_ad_gain"] == ("0", "100")
    assert found["facts", "", "position in day"] == (1, 2)
    assert found["files", "log", "name"] == ("r001.csv", "r002.csv")
    assert found["numbers", "", "joules a jump"] == (first.joules_per_jump, second.joules_per_jump)
    assert found["charges", "charge", "charge"] == (first.charges[0].charge_mah, second.charges[0].charge_mah)
    alike = {"foot", "k_gain", "day", "robot", "rate", "reader", "body_height", "jumps found"}
    assert not alike & {what for _subject, _of, what in found}
    assert not any(of == "charge" for subject, of, _what in found if subject == "files")  # one sheet has both


def test_a_run_is_like_itself_and_the_other_way_round_differs_in_the_same(whole: SmallBook) -> None:
    with whole.open() as book:
        some = views(book, "r001", "r002", "r007", "r009")
    for one in some:
        assert differing(compare_runs(one, one)) == {}
    for one, other in itertools.permutations(some, 2):
        back = {thing: (b, a) for thing, (a, b) in differing(compare_runs(other, one)).items()}
        assert differing(compare_runs(one, other)) == back


def test_what_was_stated_of_one_run_is_what_differs_then(whole: SmallBook) -> None:
    with whole.open() as book:
        before = compared(book, "r001", "r006")
        state(book, correct, "r006", ["duration_s=700"], "misread")
        judge_blind(book, "r006", 2, Verdict.ACCEPT, ReasonCode.LOOKS_RIGHT)
        after = compared(book, "r001", "r006")
    new = {thing: both for thing, both in after.items() if thing not in before}
    assert new.pop(("facts", "", "duration"))[1] == 700
    assert new.pop(("verdicts", "", "jumps not reviewed")) == (3, 2)
    (((subject, _of, what), both),) = new.items()
    assert (subject, both) == ("verdicts", (None, (2,)))
    says(what, "accepted", ADA, "blind")


def test_a_file_that_one_run_lacks_is_one_difference(whole: SmallBook) -> None:
    with whole.open() as book:
        state(book, assign, "r002.csv", "none", "of another run")
        found = compared(book, "r001", "r002")
        (view,) = views(book, "r001")
    ((signal, _gaps),) = view.signals
    of_log = {what: both for (_subject, of, what), both in found.items() if of == "log"}
    assert of_log == {"name": ("r001.csv", None), "channels": (len(signal.channels), None)}
    assert found["numbers", "", "jumps found"] == (3, None)


def test_how_a_file_was_read_is_told(whole: SmallBook) -> None:
    good(labbook("files", "reread", "r001.csv", "--column", "k_gain=own.gain", "--why", "tried", at=whole.folder))
    said = good(labbook("runs", "diff", "r001", "r006", at=whole.folder)).out
    says(said, "columns", "k_gain", "gain", "none")


@pytest.mark.parametrize(
    ("ending", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF"), ("html", b"<!DOCTYPE html>")]
)
def test_both_logs_are_drawn_in_the_form_asked_for(ending: str, start: bytes, whole: SmallBook, tmp_path: Path) -> None:
    out = tmp_path / f"both.{ending}"
    found = good(labbook("runs", "diff", "r001", "r002", "--out", out, "--json", at=whole.folder)).json
    assert found["figure"] == str(out)
    assert out.read_bytes().startswith(start)


def test_what_cannot_be_compared_or_drawn_is_refused_and_nothing_written(whole: SmallBook, tmp_path: Path) -> None:
    with unchanged(whole.folder):
        refused(labbook("runs", "diff", "r001", "r0002", at=whole.folder), 2, "r0002", "r002")
        refused(labbook("runs", "diff", "r001", "r002", "--out", "both.gif", at=whole.folder), 2, ".gif", ".html")
        out = tmp_path / "both.png"
        refused(labbook("runs", "diff", "r001", "r007", "--out", out, at=whole.folder), 2, "r007", "no log")
        assert not out.exists()
        says(good(labbook("runs", "diff", "r001", "r001", at=whole.folder)).out, "r001", "alike")
