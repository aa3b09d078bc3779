"""Control limits come from the runs of a condition before a run, and are the same wherever they are told."""

from __future__ import annotations

import random
import statistics
from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.queries.runs import RunRow, list_runs
from data_schema.vocabulary import RunKind
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.rig_line import rig_lines_of_runs
from labbook.actions.runs.to_do import to_do, to_do_lines
from labbook.analysis.outcomes.control_limits import limits_of, runs_outside
from labbook.analysis.outcomes.detection import Detections
from tests.helpers.books import ADA, small_book
from tests.helpers.wording import says


@pytest.fixture
def run(tmp_path: Path) -> RunRow:
    with small_book(tmp_path, ingested=False).open() as book, book.reading() as connection:
        return next(run for run in list_runs(connection) if run.kind is RunKind.JUMPS)


def test_limits_are_three_standard_deviations_about_the_mean_of_the_runs_before(run: RunRow) -> None:
    draws = random.Random(5)
    runs = [
        replace(
            run, uid=f"{n}", day=f"2021-06-{1 + n // 20:02d}", position_in_day=n % 20 // 2, condition_key=f"{n % 3}"
        )
        for n in range(80)
    ]
    values = {each.uid: draws.gauss(40.0, 3.0) for each in runs if each.uid != "30"}
    found = limits_of(draws.sample(runs, len(runs)), values)
    assert set(found) == set(values)
    for each in runs:
        earlier = [
            values[other.uid]
            for other in runs
            if other.uid in values
            and other.condition_key == each.condition_key
            and (other.day, other.position_in_day) < (each.day, each.position_in_day)
        ]
        if each.uid not in values:
            continue
        assert found[each.uid].n == len(earlier)
        ends = found[each.uid].ends
        assert (ends is not None) is (len(earlier) >= 5)
        if ends is not None:
            width = 3.0 * statistics.stdev(earlier)
            assert ends == pytest.approx(
                (statistics.mean(earlier) - width, statistics.mean(earlier) + width), rel=1e-12
            )


def test_equal_runs_before_leave_no_scatter_and_none_of_their_rounding(run: RunRow) -> None:
    runs = [replace(run, uid=f"{n}", position_in_day=n) for n in range(9)]
    values = {each.uid: 0.1 for each in runs}
    assert not runs_outside(runs, values)
    assert [each.uid for each in runs_outside(runs, values | {"7": 0.2})] == ["7"]


def test_a_run_outside_is_named_at_the_rig_in_the_day_and_in_the_report(tmp_path: Path) -> None:
    """It was named at ingest alone: who did not read that line did not learn of it."""
    with small_book(tmp_path).open() as book:
        with book.session(ADA) as session:
            for name in ("r003", "r004", "r005"):
                correct(book, session, name, ["foot=small", "b_ad_gain=0"], "the runs of this test")
            correct(book, session, "r014", ["mah=600"], "the run of this test")
        (line,) = rig_lines_of_runs(book, ["r014"])
        with book.reading() as connection:
            detections = Detections(connection, book.store)
            days = [to_do(detections, book.configuration, day) for day in ("2021-06-14", "2021-06-16")]
        notes = state_report(book, None, ADA, lambda _step: None).content.limitations
    says(line.text, "OUTSIDE the control limits")
    assert [day.outside_limits for day in days] == [(), ("r014",)]
    says(to_do_lines(days[1]), "control limits", "r014")
    says(list(notes), "1 run lies", "control limits", "r014")
