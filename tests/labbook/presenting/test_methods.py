"""Limitations name the runs that they are about."""

from __future__ import annotations

from dataclasses import replace

import pytest

from labbook.analysis.study import StudyAnalysis
from labbook.presenting.methods import limitations
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
        missing = {by_name[name]: "no log with a body height" for name in names}
        notes = limitations(replace(analysis, apexes=replace(analysis.apexes, missing=missing)))
        assert f"{start} no apex heights: no log with a body height." in notes


def test_jumps_found_beside_other_jumps_made(analysis: StudyAnalysis) -> None:
    assert not any("jumps found" in note for note in limitations(analysis))
    (note,) = [note for note in limitations(made_jumps(analysis, "r002", 5)) if "jumps found" in note]
    assert (
        note == "In 1 run the jumps found are not the jumps made (r002: 3 of 5); joules are divided by the jumps made."
    )


def test_a_log_of_a_run_without_jumps_made(analysis: StudyAnalysis) -> None:
    notes = limitations(made_jumps(analysis, "r002", 0))
    assert not any("divided by the jumps made" in note for note in notes)
    (note,) = [note for note in notes if "recorded as made" in note]
    assert note.startswith("1 run (r002: 3 found) has jumps in the log though none is recorded as made: no joules")
    assert "`labbook correct RUN jumps_made=N --why ...`" in note
