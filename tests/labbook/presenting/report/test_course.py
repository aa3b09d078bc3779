"""When a factor is called confounded with the day."""

from __future__ import annotations

from dataclasses import replace

import pytest

from labbook.analysis.study import StudyAnalysis
from labbook.presenting.report.campaign import confounded_with_day
from tests.helpers.wording import says
from tests.labbook.presenting.conftest import Told

SAND, GRAVEL = "sand", "gravel"


@pytest.fixture
def analysis(surfaces: Told) -> StudyAnalysis:
    return surfaces.made.analysis


def on_days(analysis: StudyAnalysis, *days: tuple[str, ...]) -> list[str]:
    """What is said of runs that had these surfaces, a tuple a day, and one drop height."""
    first = analysis.evidence.runs[0]
    runs = tuple(
        replace(first, day=f"2021-07-{day:02d}", is_control=surface == SAND, levels={"surface": surface})
        for day, surfaces in enumerate(days, start=1)
        for surface in surfaces
    )
    return confounded_with_day(replace(analysis, evidence=replace(analysis.evidence, runs=runs)))


def test_days_of_a_single_run_show_nothing(analysis: StudyAnalysis) -> None:
    assert on_days(analysis, (SAND,), (GRAVEL,), (SAND, GRAVEL)) == []
    assert on_days(analysis, (SAND,), (GRAVEL,)) == []


def test_a_factor_is_confounded_where_all_days_had_one_level_of_it(analysis: StudyAnalysis) -> None:
    says(on_days(analysis, (SAND, SAND), (GRAVEL, GRAVEL), (GRAVEL,)), "On every day", "the surface", "confounded")


def test_most_days_make_it_largely_confounded_and_half_of_them_do_not(analysis: StudyAnalysis) -> None:
    mixed = (SAND, GRAVEL)
    (sentence,) = on_days(analysis, (SAND, SAND), (GRAVEL, GRAVEL), mixed)
    says(sentence, "2", "3 days")
    assert on_days(analysis, (SAND, SAND), (GRAVEL, GRAVEL), mixed, mixed) == []


def test_days_without_a_control_are_named_where_the_treated_levels_differ_in_a_day(analysis: StudyAnalysis) -> None:
    (sentence,) = on_days(analysis, (GRAVEL, "mud"), (GRAVEL, "mud"), (SAND, GRAVEL))
    says(sentence, "2", "3 days")
    assert on_days(analysis, (GRAVEL, "mud"), (GRAVEL, "mud")) == []
