"""A study of what accuracy costs, and what it advises."""

from __future__ import annotations

import dataclasses

import pytest

from simulator.accuracy.methods import LABBOOK, METHODS, NAMES
from simulator.accuracy.reference_of import Reference
from simulator.accuracy.study import AccuracyStudy, Point, Series, n_points, needs
from simulator.scene_file import load_scene
from tests.helpers.accuracy_studies import quick_study

SCENE = load_scene("sim2")


@pytest.fixture(scope="module")
def study() -> AccuracyStudy:
    found, told = quick_study(SCENE)
    assert len(told) == n_points(quick=True)
    return found


def points(study: AccuracyStudy, method: str) -> tuple[Point, ...]:
    return next(series.points for series in study.series if series.method == method)


def test_every_method_is_tried_and_timed(study: AccuracyStudy) -> None:
    assert [series.method for series in study.series] == list(METHODS)
    for series in study.series:
        assert series.points
        for point in series.points:
            assert not point.failure
            assert point.outcome == "apex"
            assert point.seconds > 0.0
            assert point.evaluations > 0


def test_labbook_keeps_its_goal_and_nothing_is_claimed_under_the_floor(study: AccuracyStudy) -> None:
    for point in points(study, LABBOOK):
        assert max(error for error in (point.errors or {}).values() if error is not None) <= point.setting
    for point in (point for series in study.series for point in series.points):
        for name in NAMES:
            assert ((point.errors or {})[name] or 0.0) >= (study.reference.floor[name] or 1.0)


def test_a_run_that_fails_is_kept_with_its_reason(study: AccuracyStudy) -> None:
    found, _told = quick_study(SCENE, ["solve_ivp RK45"], most_evaluations=1000)
    failed = [point for point in points(found, "solve_ivp RK45") if point.failure]
    assert failed
    assert "than 1000 evaluations" in failed[-1].failure
    assert failed[-1].errors is None
    assert len(points(found, "solve_ivp RK45")) == len(points(study, "solve_ivp RK45"))


def series_of(*errors: float, failure: str = "") -> Series:
    """A method whose points take 1 s, 2 s, ..., with these errors in all outputs."""
    made = [
        Point(10.0**-place, "apex", dict.fromkeys(NAMES, error), 100 * place, float(place))
        for place, error in enumerate(errors, start=1)
    ]
    if failure:
        made[-1] = dataclasses.replace(made[-1], failure=failure)
    return Series("made up", "step", "s", tuple(made))


def advised(series: Series, goal: float, floor: float = 1e-15) -> Point | None:
    levels = dict.fromkeys(NAMES, floor)
    reference = Reference("made up", True, "apex", dict.fromkeys(NAMES, 1.0), levels, levels)
    need = needs(AccuracyStudy(SCENE, reference, (series, Series("made up", "step", "s", (), "no sand"))), goal)
    assert [one.within_reach for one in need] == [floor <= goal]  # a method that does not cover the scene needs nothing
    return need[0].point


@pytest.mark.parametrize(
    ("series", "goal", "seconds"),
    [
        pytest.param(series_of(1e-1, 1e-3, 1e-5), 1e-2, 2.0, id="the coarsest that keeps the goal"),
        pytest.param(series_of(1e-9, 1e-1, 1e-3, 1e-4), 1e-2, 3.0, id="small by luck does not count"),
        pytest.param(series_of(1e-1, 1e-4, 1e-6, failure="400000 evaluations"), 1e-3, 2.0, id="a finer one gave up"),
        pytest.param(series_of(1e-1, 1e-2), 1e-3, None, id="none will do"),
        pytest.param(series_of(1e-1, 1e-4, failure="gave up"), 1e-3, None, id="the only one gave up"),
    ],
)
def test_which_setting_is_advised(series: Series, goal: float, seconds: float | None) -> None:
    point = advised(series, goal)
    advised(series, goal, floor=10.0 * goal)
    assert (None if point is None else point.seconds) == seconds
