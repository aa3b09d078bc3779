"""Methods say what was done with the drain line's error; limitations name the runs that they are about."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.actions.report_command import state_report
from labbook.analysis.study import StudyAnalysis
from labbook.presenting.report.methods import limitations, methods
from tests.helpers.books import ADA, small_book
from tests.helpers.wording import says
from tests.labbook.presenting.conftest import Told


@pytest.fixture
def analysis(without_control: Told) -> StudyAnalysis:
    return without_control.made.analysis


def made_jumps(analysis: StudyAnalysis, name: str, jumps: int) -> StudyAnalysis:
    runs = tuple(replace(run, jumps_made=jumps) if run.name == name else run for run in analysis.evidence.runs)
    return replace(analysis, evidence=replace(analysis.evidence, runs=runs))


def test_runs_without_apexes_are_named(analysis: StudyAnalysis) -> None:
    by_name = {run.name: run.uid for run in analysis.evidence.runs}
    for names, start in ((("r005",), "1 run (r005) has"), (("r002", "r005"), "2 runs (r002, r005) have")):
        missing = {by_name[name]: Undefined(Reason.NO_HEIGHT_LOG) for name in names}
        results = {**analysis.results, Outcome.APEX: replace(analysis.results[Outcome.APEX], missing=missing)}
        notes = limitations(replace(analysis, results=results))
        says(notes, start, "no apex heights")


def test_jumps_found_beside_other_jumps_made(analysis: StudyAnalysis) -> None:
    assert not any("jumps found" in note for note in limitations(analysis))
    (note,) = [note for note in limitations(made_jumps(analysis, "r002", 5)) if "jumps found" in note]
    says(note, "1 run", "not the jumps", "r002", "3", "5")


def test_a_log_of_a_run_without_jumps_made(analysis: StudyAnalysis) -> None:
    notes = limitations(made_jumps(analysis, "r002", 0))
    assert not any("jumps made" in note for note in notes)
    (note,) = [note for note in notes if "recorded as made" in note]
    says(note, "1 run", "r002", "3 found", "labbook correct RUN")


def test_how_pooled_levels_are_weighted_is_said_where_levels_are_pooled(tmp_path: Path) -> None:
    with small_book(tmp_path).open() as book:
        one_level = state_report(book, None, ADA, lambda _step: None).analysis
    pooled = [replace(item, pair=replace(item.pair, b=item.pair.b * 2)) for item in one_level.compared]
    weighted = "pooled levels weighted by their runs"
    assert weighted not in methods(one_level)[-1]
    says(methods(replace(one_level, compared=pooled))[-1], weighted)
