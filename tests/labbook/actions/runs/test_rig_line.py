"""What the person at the rig reads of a run: flights are jumps, a last landing is none, and held samples are gaps."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema.queries.detections import jumps_found
from data_schema.queries.files import readings_of
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.jump_review import jump_lines, review, without_apex
from labbook.actions.runs.rig_line import rig_lines_of, rig_lines_of_runs
from labbook.actions.runs.run_plot import plot_run
from labbook.actions.runs.run_view import run_view, view_lines
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.book.opening import Book
from tests.helpers.attention import found_in
from tests.helpers.books import ADA, small_book
from tests.helpers.hopping_log import apex_s, hopping_log, landing_s
from tests.helpers.statements import state
from tests.helpers.wording import says

RUN = "r001"


@pytest.fixture
def book(tmp_path: Path) -> Iterator[Book]:
    with small_book(tmp_path, ingested=False).open() as book:
        state(book, correct, RUN, ["jumps_made=10"], "for this test")
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


def test_the_last_landing_is_no_jump_and_has_no_apex(book: Book, tmp_path: Path) -> None:
    outcome, line = ingest(book, tmp_path, hopping_log(10))
    says(line, "10 jumps")
    assert found_not_made(outcome) == []
    says(shown(book), "10 jumps", "10 found")
    with book.reading() as connection:
        (row,) = readings_of(connection, outcome.sha256)
        assert list(jumps_found(connection, row.uid, None).values()) == [10]
        found = review(book, connection, RUN)
    assert len(found.jumps) == 11
    (without,) = without_apex(found, [1, 11])
    says(without, "11", RUN, "no apex")
    head, lines, meanings = jump_lines(found)
    first, last = (dict(zip(head, cells, strict=True)) for cells in (lines[0], lines[10]))
    assert float(first["touchdown"].removesuffix(" s")) == pytest.approx(landing_s(1), abs=0.01)
    assert float(first["apex"].removesuffix(" s")) == pytest.approx(apex_s(1), abs=0.005)
    assert float(last["touchdown"].removesuffix(" s")) == pytest.approx(landing_s(11), abs=0.01)
    assert (last["apex"], last["height"], last["flight time"]) == ("", "", "")
    assert meanings == []  # no flag was raised


def test_a_misfire_is_told_by_its_reason_not_by_how_the_reason_is_worded(book: Book, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    content = hopping_log(10)
    last_ms = float(content.splitlines()[-1].partition(b",")[0])
    held = "".join(f"{last_ms + 4 * row:.3f},{0.33 + 1e-5 * (row % 3):.6f},15.4\n" for row in range(1, 1001))
    path.write_bytes(content + held.encode())  # the robot is lifted, and held
    outcome = ingest_file(book, path, IngestRequest(run=RUN, person=ADA))
    ((line,),) = rig_lines_of(book, [outcome])
    assert (line.run, line.jumps_found, line.jumps_made, line.misfires) == (RUN, 10, 10, 1)
    says(line.text, "10 jumps", "1 misfire")
    with book.engine.begin() as connection:
        connection.execute(
            sa.text("UPDATE jump SET undefined_reason = 'other words' WHERE undefined_reason IS NOT NULL")
        )
    with book.reading() as connection:
        made = plot_run(book, connection, RUN, 11, tmp_path / "jump.svg")
    assert made.remark == "jump 11 of run r001 was a misfire: other words."


def test_a_jump_whose_apex_is_lost_is_missing(book: Book, tmp_path: Path) -> None:
    content = hopping_log(10, lost_s=[(apex_s(4) - 0.1, apex_s(4) + 0.1)])
    outcome, line = ingest(book, tmp_path, content)
    says(line, "9", "10 jumps", "1 missing", "1 gap")
    (message,) = found_not_made(outcome)
    says(message, "9 jumps")
    says(shown(book), "10 jumps", "9 found")
    results = state_report(book, None, ADA, lambda _step: None).computed.made.values()
    scope = {"run": RUN, "detector": "robust", "heed_decisions": True}
    found = [one for one in results if isinstance(one, RunApexes) and scope.items() <= one.origin.scope.items()]
    assert [one.jumps_found.value for one in found] == [9]


def test_held_samples_are_gaps_and_one_while_standing_costs_no_jump(book: Book, tmp_path: Path) -> None:
    held = [(landing_s(3) + 0.05, landing_s(3) + 0.09), (apex_s(6) - 0.01, apex_s(6) + 0.03)]
    _, line = ingest(book, tmp_path, hopping_log(10, held_s=held, lost_s=[(landing_s(8) + 0.05, landing_s(8) + 0.07)]))
    says(line, "10 jumps", "3 gaps", "28 samples", "22")
    with book.reading() as connection:
        jumps = review(book, connection, RUN).jumps
    assert [item.jump.number for item in jumps if item.excluded == "touches a gap"] == [6]


def test_a_charge_below_the_passive_drain_is_said_of_the_run_and_of_its_day(tmp_path: Path) -> None:
    with small_book(tmp_path).open() as book:
        (fine,) = rig_lines_of_runs(book, ["r002"])
        state(book, correct, "r002", ["mah=10"], "for this test")
        (line,) = rig_lines_of_runs(book, ["r002"])
        (day,) = found_in(book, day="2021-06-14")["charge_below_drain"]
    assert line.concern == "charge_below_drain" != fine.concern
    says(line.text, "10 mAh", "86.2 mAh", "12 min", "labbook show r002")
    assert day.run == "r002"
    says(day.what, "10 mAh", "86.2 mAh")


def test_control_limits_begin_at_0_joules(tmp_path: Path) -> None:
    """The scatter of two levels among the earlier runs put the lower limit at -7970.8 J, which tells nothing."""
    with small_book(tmp_path).open() as book:
        for run, mah in {"r003": "120", "r004": "90", "r005": "300"}.items():
            state(book, correct, run, [f"mah={mah}", "foot=small", "b_ad_gain=0"], "for this test")
        (few,) = rig_lines_of_runs(book, ["r009"])
        (line,) = rig_lines_of_runs(book, ["r014"])
        state(book, correct, "r014", ["mah=50"], "for this test")
        (below,) = rig_lines_of_runs(book, ["r014"])
    assert few.concern != "outside_limits"
    says(line.text, "within the control limits 0 to")
    says(below.text, "OUTSIDE the control limits 0 to")
