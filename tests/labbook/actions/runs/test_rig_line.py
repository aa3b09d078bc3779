"""What the person at the rig reads of a run: flights are jumps, a last landing is none, and held samples are gaps."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema.queries.detections import jumps_found
from data_schema.queries.readings import readings_of
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.jump_review import jump_lines, review, without_apex
from labbook.actions.runs.rig_line import rig_lines_of, rig_lines_of_runs
from labbook.actions.runs.run_plot import plot_run
from labbook.actions.runs.run_view import run_view, view_lines
from labbook.actions.runs.to_do import to_do, to_do_lines
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.book.opening import Book
from tests.helpers.books import ADA, small_book
from tests.helpers.hopping_log import apex_s, hopping_log, landing_s
from tests.helpers.wording import says

RUN = "r001"


@pytest.fixture
def book(tmp_path: Path) -> Iterator[Book]:
    with small_book(tmp_path, ingested=False).open() as book:
        with book.session(ADA) as session:
            correct(book, session, RUN, ["jumps_made=10"], "the run of this test")
        yield book


def ingest(book: Book, folder: Path, content: bytes) -> tuple[FileOutcome, str]:
    path = folder / "log.csv"
    path.write_bytes(content)
    outcome = ingest_file(book, path, IngestRequest(run=RUN, person=ADA))
    assert outcome.status == "imported", outcome
    ((line,),) = rig_lines_of(book, [outcome])
    return outcome, line.text


def found_not_made(outcome: FileOutcome) -> list[str]:
    assert outcome.read is not None
    return [finding.message for finding in outcome.read.findings if finding.rule == "jumps_found_not_made"]


def shown(book: Book) -> str:
    with book.reading() as connection:
        return "\n".join(view_lines(run_view(Detections(connection, book.store), book.configuration, RUN)))


def test_the_last_landing_is_no_jump(book: Book, tmp_path: Path) -> None:
    """It was: "11 of 10 jumps found (1 too many)"."""
    outcome, line = ingest(book, tmp_path, hopping_log(10))
    says(line, "10 jumps")
    assert found_not_made(outcome) == []
    says(shown(book), "10 jumps", "10 found")
    with book.reading() as connection:
        assert len(review(book, connection, RUN).jumps) == 11


def test_what_a_new_reading_found_is_counted_as_what_was_made(book: Book, tmp_path: Path) -> None:
    """It was "20 jumps found" beside "10 of 10 jumps found": each stance without a flight counted too."""
    path = tmp_path / "log.csv"
    path.write_bytes(hopping_log(10))
    outcome = ingest_file(book, path, IngestRequest(run=RUN, person=ADA))
    with book.reading() as connection:
        (row,) = readings_of(connection, outcome.sha256)
        assert list(jumps_found(connection, row.uid, None).values()) == [10]
        found = review(book, connection, RUN)
    (last,) = without_apex(found, [1, 11])
    says(last, "11", "r001", "no apex")


def test_a_misfire_is_told_by_its_reason_not_by_how_the_reason_is_worded(book: Book, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    content = hopping_log(10)
    last_ms = float(content.splitlines()[-1].partition(b",")[0])
    held = "".join(f"{last_ms + 4 * row:.3f},{0.33 + 1e-5 * (row % 3):.6f},15.4\n" for row in range(1, 1001))
    path.write_bytes(content + held.encode())  # the robot is lifted, and held
    ingest_file(book, path, IngestRequest(run=RUN, person=ADA))
    with book.engine.begin() as connection:
        connection.execute(
            sa.text("UPDATE jump SET undefined_reason = 'other words' WHERE undefined_reason IS NOT NULL")
        )
    with book.reading() as connection:
        made = plot_run(book, connection, RUN, 11, tmp_path / "jump.svg")
    assert made.remark == "jump 11 of run r001 was a misfire: other words."


def test_a_misfire_has_a_touchdown_and_no_apex_in_the_list(book: Book, tmp_path: Path) -> None:
    """It had "apex at 0.000 s", or at the time of its touchdown."""
    ingest(book, tmp_path, hopping_log(10))
    with book.reading() as connection:
        head, lines, meanings = jump_lines(review(book, connection, RUN))
    first, last = (dict(zip(head, line, strict=True)) for line in (lines[0], lines[10]))
    assert float(first["touchdown"].removesuffix(" s")) == pytest.approx(landing_s(1), abs=0.01)
    assert float(first["apex"].removesuffix(" s")) == pytest.approx(apex_s(1), abs=0.005)
    assert float(last["touchdown"].removesuffix(" s")) == pytest.approx(landing_s(11), abs=0.01)
    assert (last["apex"], last["height"], last["flight time"]) == ("", "", "")
    assert meanings == []  # no flag was raised


def test_a_jump_whose_apex_is_lost_is_missing(book: Book, tmp_path: Path) -> None:
    """It was "10 of 10 jumps found": the last landing stood in for it."""
    content = hopping_log(10, lost_s=[(apex_s(4) - 0.1, apex_s(4) + 0.1)])
    outcome, line = ingest(book, tmp_path, content)
    says(line, "9", "10 jumps", "1 missing", "1 gap")
    (message,) = found_not_made(outcome)
    says(message, "9 jumps")
    says(shown(book), "10 jumps", "9 found")
    results = state_report(book, None, ADA, lambda _step: None).computed.made.values()
    (found,) = [
        one.jumps_found.value
        for one in results
        if isinstance(one, RunApexes)
        if (one.origin.scope["run"], one.origin.scope["detector"], one.origin.scope["heed_decisions"])
        == (RUN, "robust", True)
    ]
    assert found == 9


def test_held_samples_are_gaps_and_one_while_standing_costs_no_jump(book: Book, tmp_path: Path) -> None:
    """It was "no gaps", and the jump out of a stance with a gap was left out of the mean."""
    held = [(landing_s(3) + 0.05, landing_s(3) + 0.09), (apex_s(6) - 0.01, apex_s(6) + 0.03)]
    _, line = ingest(book, tmp_path, hopping_log(10, held_s=held, lost_s=[(landing_s(8) + 0.05, landing_s(8) + 0.07)]))
    says(line, "10 jumps", "3 gaps", "28 samples", "22")
    with book.reading() as connection:
        jumps = review(book, connection, RUN).jumps
    assert [item.jump.number for item in jumps if item.excluded == "touches a gap"] == [6]


def test_a_charge_below_the_passive_drain_is_said_of_the_run_and_of_its_day(tmp_path: Path) -> None:
    """It was "-286.0 J a jump, within the control limits -7970.8 to 10196.7 J", and not a word."""
    with small_book(tmp_path).open() as book:
        (fine,) = rig_lines_of_runs(book, ["r002"])
        with book.session(ADA) as session:
            correct(book, session, "r002", ["mah=10"], "the run of this test")
        (line,) = rig_lines_of_runs(book, ["r002"])
        with book.reading() as connection:
            day = to_do_lines(to_do(Detections(connection, book.store), book.configuration, "2021-06-14"))
    assert line.concern == "charge_below_drain" != fine.concern
    says(line.text, "10 mAh", "86.2 mAh", "12 min", "labbook show r002")
    says(day, "too little charged", "r002", "86.2 mAh")


def test_control_limits_begin_at_0_joules(tmp_path: Path) -> None:
    """The scatter of two levels among the earlier runs put the lower limit at -7970.8 J, which tells nothing."""
    with small_book(tmp_path).open() as book:
        with book.session(ADA) as session:
            for run, mah in {"r003": "120", "r004": "90", "r005": "300"}.items():
                fields = [f"mah={mah}", "foot=small", "b_ad_gain=0"]
                correct(book, session, run, fields, "the runs of this test")
        (few,) = rig_lines_of_runs(book, ["r009"])
        (line,) = rig_lines_of_runs(book, ["r014"])
        with book.session(ADA) as session:
            correct(book, session, "r014", ["mah=50"], "the runs of this test")
        (below,) = rig_lines_of_runs(book, ["r014"])
        with book.session(ADA) as session:
            for run in ("r001", "r003", "r004", "r005", "r006", "r009"):
                correct(book, session, run, ["mah=1"], "the runs of this test")
        (none,) = rig_lines_of_runs(book, ["r014"])
    assert few.concern != "outside_limits"
    says(line.text, "within the control limits 0 to")
    says(below.text, "OUTSIDE")
    says(below.text, "OUTSIDE the control limits 0 to")
    assert none.concern != "outside_limits"
    says(none.text, "no control limits")
