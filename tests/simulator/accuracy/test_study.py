"""A study of what accuracy costs, what it advises, and what errors are measured against."""

from __future__ import annotations

import dataclasses

import pytest

from simulator.accuracy.methods import LABBOOK, METHODS, NAMES, KernelRun, outputs_of, relative_errors, stops_after
from simulator.accuracy.reference_of import FINEST, Reference, reference_of, stored_reference
from simulator.accuracy.study import AccuracyStudy, Point, Series, n_points, needs
from simulator.scene_file import load_scene
from tests.helpers.accuracy_studies import quick_study
from tests.helpers.wording import says

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


def test_a_stored_result_comes_first_and_the_finest_run_agrees_with_it() -> None:
    reference = reference_of(SCENE, stops_after(SCENE))
    assert reference.stored
    assert "36 digits" in reference.source
    assert reference.values["apex_height_m"] == pytest.approx(0.303334225186479, rel=1e-14)
    finest = KernelRun(SCENE, FINEST, stops_after(SCENE))
    finest.run()
    for name, error in relative_errors(outputs_of(SCENE, finest.rows), reference.values).items():
        assert error is not None
        assert error < 1e-11, name
    assert all(2e-16 <= (reference.floor[name] or 0.0) < 1e-12 for name in NAMES)


def test_a_scene_of_one_s_own_is_confirmed_by_fixed_steps() -> None:
    scene = SCENE.changed({"foot_radius": 0.0351})
    reference = reference_of(scene, stops_after(scene))
    assert not reference.stored
    says(reference.source, "confirmed by Richardson")
    assert all(0.0 <= (doubt or 0.0) < 1e-9 for doubt in reference.doubt.values())
    assert None not in reference.doubt.values()


def test_the_floor_is_high_where_a_scene_hangs_on_last_bits() -> None:
    """At this active damping the sampled leg chatters, and errors grow from tick to tick."""
    calm, chattering = (
        reference_of(SCENE.changed({"b_ad": b_ad}), stops_after(SCENE)).round_off["cost_J"] or 0.0
        for b_ad in (100.0, 650.0)
    )
    assert chattering > 100.0 * calm > 0.0


@pytest.mark.parametrize(
    ("name", "values", "case"),
    [
        ("sim2", {}, "defaults, held gains in flight"),
        ("sim2", {"foot_radius": 0.038, "k_extension": 1091.36}, None),  # stored with soft gains in flight only
        ("sim1", {}, "b_AD = 650"),
        ("sim1", {"b_ad": 0.0}, "defaults"),
        ("sim1", {"b_ad": 1.0}, None),
        ("bed", {}, "small foot, gain 400"),
        ("bed", {"foot_radius": 0.051, "k_extension": 835.36}, "large foot, gain 300"),
        ("bed", {"initial_height": 0.16}, None),
    ],
)
def test_granular_scenes(name: str, values: dict[str, float], case: str | None) -> None:
    match = stored_reference(load_scene(name).changed(values))
    if case is None:
        assert match is None
    else:
        assert match is not None
        assert f"“{case}” of {name}" in match.source
        assert match.doubt["apex_height_m"] <= 1e-30
        assert match.outcome == "apex"


def test_effects_count_unless_they_change_no_motion() -> None:
    assert stored_reference(SCENE.changed(effects_on=("drag", "passive_draw"))) is not None
    for off, known in (("held_gains_in_flight", True), ("active_damping", True), ("added_mass", False)):
        assert (stored_reference(SCENE.changed(effects_off=(off,))) is not None) == known, off


def test_of_jumps_that_follow_each_other_the_last_is_meant() -> None:
    one, four, five = (stored_reference(load_scene("force_plate").changed(jumps=jumps)) for jumps in (1, 4, 5))
    assert one is not None
    assert four is not None
    assert one.values != four.values
    assert five is None
