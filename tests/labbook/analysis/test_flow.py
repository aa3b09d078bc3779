"""Runs are counted by what each analysis used: a run without joules is none of those that joules come from."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from data_schema.vocabulary import ReasonCode, Verdict
from labbook.actions.files.assigning import assign
from labbook.actions.runs.jump_review import decide
from labbook.analysis.study import Analysis
from reports.tables.formats import csv_bytes
from reports.tables.registry import TABLES
from tests.helpers.books import ADA, JUMPS, small_book
from tests.helpers.decided import reports
from tests.helpers.pages import quick_page
from tests.helpers.statements import judge_blind, state
from tests.helpers.wording import says

RUNS, IDLE = 12, 4


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    """A report on runs of which one has no charge, another no log, and a third no jump that counts."""
    book = small_book(tmp_path_factory.mktemp("flow"))
    with book.open() as opened, opened.session(ADA) as session:
        assign(session, "2021-06-14.csv#2", "none", "of another run")
        assign(session, "r003.csv", "none", "of another run")
        decide(opened, session, "r004", [1, 2, 3], "reject", "misfire", None)
    return reports(book)


def test_runs_count_where_their_number_was_used_and_the_others_have_a_reason(made: Analysis) -> None:
    flow = made.results.flow
    assert flow.runs_with == {Outcome.JOULES: RUNS - 1, Outcome.APEX: RUNS - 2}
    assert flow.runs_without == {
        Outcome.JOULES: {"no charge recorded": 1},
        Outcome.APEX: {"no log with a body_height channel": 1, "none of its jumps counts": 1},
    }
    for quantity in made.results.outcomes:
        assert flow.runs_with[quantity] + sum(flow.runs_without[quantity].values()) == RUNS
        summaries = [condition.summary(quantity) for condition in made.results.conditions]
        assert flow.runs_with[quantity] == sum(len(summary.runs) for summary in summaries if summary is not None)


def test_jumps_are_those_of_the_runs_with_heights(made: Analysis) -> None:
    flow = made.results.flow
    assert (flow.jumps_made, flow.jumps_detected) == (JUMPS * (RUNS - 2),) * 2
    assert flow.jumps_analysed + sum(flow.jumps_excluded.values()) == flow.jumps_detected
    assert not any("misfire" in reason for reason in flow.jumps_excluded)


def test_verdicts_of_people_are_counted_on_the_first_page(tmp_path: Path) -> None:
    """Of the jumps analysed and of those left out by a person; a verdict that was taken back is none."""
    made = small_book(tmp_path)
    with made.open() as book:
        for run, numbers, verdict, reason in (
            ("r001", [1, 2], "accept", "looks_right"),
            ("r002", [3], "reject", "misfire"),
            ("r003", [1], "accept", "looks_right"),
            ("r003", [1], "clear", "other"),
            ("r003", [2, 3], "accept", "with_the_rest"),
        ):
            state(book, decide, run, numbers, verdict, reason, None)
        judge_blind(book, "r005", 1, Verdict.REJECT, ReasonCode.TOUCHED_BY_HAND)
        judge_blind(book, "r005", 2, Verdict.ACCEPT, ReasonCode.LOOKS_RIGHT)
    content = reports(made).results
    flow = content.flow
    assert (flow.jumps_reviewed, flow.jumps_rejected, flow.verdicts_blind) == (3, 2, 2)
    assert flow.jumps_with_the_rest == 2
    assert flow.jumps_analysed == flow.jumps_detected - sum(flow.jumps_excluded.values())
    page = re.sub(r"\s+", " ", quick_page(content)).replace("\u00a0", " ")
    says(
        page,
        f"reviewed 3 of the {flow.jumps_analysed} jumps",
        "2 more",
        "accepted 2 with the rest",
        "2 of these 7 verdicts",
        "blind",
    )


def test_table_and_page_give_both_counts(made: Analysis) -> None:
    content = made.results
    rows = list(csv.DictReader(io.StringIO(csv_bytes(TABLES["flow"].make(content)).decode())))
    counts = {row["step"]: (row["count"], row["left_out"]) for row in rows}
    idle = f"{IDLE} idle, for the passive drain"
    says(counts["runs with joules"], "11", idle, "1 excluded", "no charge")
    assert counts["runs with apex heights"][0] == "10"
    page = re.sub(r"\s+", " ", quick_page(content)).replace("\u00a0", " ")
    says(page, "16 runs", "2 days", "11", "10")
    assert "12 of 16" not in page
