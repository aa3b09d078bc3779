"""Simulating a scene: what is refused, what a result holds, and jumps that hang on one decision."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from data_schema.errors import UsageError
from simulator.jump import FINEST_ACCURACY, ILL_CONDITIONED_BELOW, parameter_row, simulate
from simulator.kernel.build import kernel_for
from simulator.kernel.rows import COLUMN
from simulator.result import JumpResult
from simulator.scene_file import load_scene, shipped_scenes
from tests.helpers.kernels import batch_rows, interpreted
from tests.helpers.wording import refuses, says


@pytest.mark.parametrize("accuracy", [0.0, -1e-6, 1e-14, 0.2, math.nan, math.inf])
def test_an_accuracy_that_cannot_be_had_is_refused(accuracy: float) -> None:
    with refuses(UsageError, "accuracy of", "cannot be had", "1e-13", "0.1"):
        simulate(load_scene("sim2"), accuracy)


@pytest.mark.parametrize("name", shipped_scenes())
def test_costs_and_times_of_a_result_belong_together(name: str) -> None:
    scene = load_scene(name)
    result = simulate(scene, 1e-7)
    assert len(result.jumps) == scene.jumps
    assert result.jump is result.jumps[-1]
    assert result.accuracy == 1e-7
    span = "jump" if "cost_of_whole_jump" in scene.effects else "stance"
    ends_s = 0.0
    for place, jump in enumerate(result.jumps):
        assert jump.outcome == "touchdown"
        parts = [getattr(jump, f"{span}_{part}_J") for part in ("heat", "mechanical", "drag")]
        assert jump.cost_J == pytest.approx(sum(parts), rel=1e-14)
        assert 0.0 < jump.stance_heat_J <= jump.jump_heat_J
        lift_off_s, apex_s, next_s = (
            time_s or 0.0 for time_s in (jump.liftoff_time_s, jump.apex_time_s, jump.next_touchdown_time_s)
        )
        assert 0.0 < lift_off_s < apex_s < next_s
        assert jump.min_leg_length_m < min(scene["rest_length"], jump.max_leg_length_m)
        assert jump.steps > 0
        assert jump.rhs_evaluations > jump.steps
        if place:
            assert jump.touchdown_time_s == pytest.approx(ends_s, rel=1e-12)
        ends_s = jump.touchdown_time_s + next_s


def test_a_notebook_shows_what_a_jump_came_to() -> None:
    jump = simulate(load_scene("sim2")).jump
    says(jump._repr_html_(), f"{jump.apex_height_m:.4g} m")
    says(replace(jump, outcome="<sank>", apex_height_m=None)._repr_html_(), "&lt;sank&gt;", "no apex")


def test_passive_draw_counts_over_the_time_of_a_jump() -> None:
    scene = load_scene("force_plate").changed(effects_on=("passive_draw",), jumps=2)
    none, some = (interpreted(simulate, scene.changed({"passive_power": each})).jump for each in (0.0, 6.0))
    assert some.next_touchdown_time_s is not None
    assert some.passive_J == pytest.approx(6.0 * some.next_touchdown_time_s, rel=1e-12)
    assert some.cost_J - none.cost_J == pytest.approx(some.passive_J, rel=1e-12)
    assert none.passive_J == 0.0


@pytest.mark.parametrize(("halvings", "nearest"), [(8, ILL_CONDITIONED_BELOW), (38, 1e-7)])
def test_where_one_decision_hangs_on_an_edge_both_branches_are_shown(halvings: int, nearest: float) -> None:
    """Halved often enough, the state at the tick at which the leg extends says nothing more than its rounding does."""
    scene, accuracy = load_scene("sim2"), 1e-6
    stiffness_n_m = np.linspace(250.0, 254.0, 4001)
    kernel = kernel_for(scene.effects)
    place = [parameter.name for parameter in kernel.composition.parameters].index("k_compression")
    table = np.repeat(parameter_row(kernel, scene)[np.newaxis, :], len(stiffness_n_m), axis=0)
    table[:, place] = stiffness_n_m
    rows, _ = batch_rows(kernel.batch, table, accuracy)
    apexes_m = rows[:, 0, COLUMN["apex_height_m"]]
    edge = int(np.argmax(np.abs(np.diff(apexes_m))))
    sides_m = apexes_m[edge], apexes_m[edge + 1]
    assert abs(sides_m[1] - sides_m[0]) > 100.0 * np.median(np.abs(np.diff(apexes_m)))

    def jump_at(value: float) -> JumpResult:
        return simulate(scene.changed({"k_compression": value}), accuracy).jump

    low, high = float(stiffness_n_m[edge]), float(stiffness_n_m[edge + 1])
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        apex_m = jump_at(middle).apex_height_m or 0.0
        if abs(apex_m - sides_m[0]) < abs(apex_m - sides_m[1]):
            low = middle
        else:
            high = middle
    margins = []
    for value, own_m, other_m in ((low, *sides_m), (high, *sides_m[::-1])):
        jump = jump_at(value)
        assert jump.ill_conditioned
        margins.append(math.inf if jump.decision_margin is None else jump.decision_margin)
        assert jump.decision_tick is not None
        assert jump.other_branch is not None
        between_m = abs(sides_m[1] - sides_m[0])
        assert jump.apex_height_m == pytest.approx(own_m, abs=2e-3 * between_m)
        assert jump.other_branch.apex_height_m == pytest.approx(other_m, abs=2e-3 * between_m)
    assert max(margins) < ILL_CONDITIONED_BELOW
    assert min(margins) < nearest


SUNK = {"foot_radius": 0.0073, "kg_scale": 1.0, "k_extension": 5254.0}


def test_a_body_that_gets_under_the_grains_is_marked() -> None:
    jump = simulate(load_scene("sim2").changed(SUNK)).jump
    assert jump.outcome == "touchdown"
    assert jump.under_surface
    assert jump.max_depth_m > 0.3
    assert jump.apex_height_m is not None
    assert jump.min_body_height_m < jump.apex_height_m < 0.0
    above = simulate(load_scene("sim2").changed({**SUNK, "kg_scale": 1.95})).jump
    assert not above.under_surface
    assert 0.0 < above.min_body_height_m < 0.02


def test_a_book_that_stays_open_is_marked() -> None:
    """Rounding in a foot of ten milligrams takes more than the finest accuracy allows."""
    scene = load_scene("sim2").changed({"foot_mass": 1e-5})
    jump = simulate(scene, FINEST_ACCURACY).jump
    assert jump.repeats > 0
    assert jump.open_book
    assert abs(jump.energy_residual_J) > FINEST_ACCURACY * jump.energy_at_play_J
    assert not simulate(scene, 1e-9).jump.open_book


def test_every_jump_on_grains_is_on_fresh_ground() -> None:
    """A massless leg lands at its rest length with its foot as fast as the body, as a scene starts."""
    scene = load_scene("sim2").changed(effects_on=("massless_leg_in_flight",), effects_off=("held_gains_in_flight",))
    first, *others = interpreted(simulate, scene.changed(jumps=3), 1e-8).jumps
    for jump in others:
        alone = scene.changed({"initial_velocity": first.next_touchdown_body_velocity_m_s})
        again = interpreted(simulate, alone, 1e-8).jump
        for name in ("max_depth_m", "liftoff_time_s", "apex_height_m", "cost_J"):
            assert getattr(jump, name) == pytest.approx(getattr(again, name), rel=1e-7), name
        assert jump.mode_changes[0].after == "intruding"
        first = jump


def test_a_robot_hops_steadily_on_grains_and_its_books_close() -> None:
    jumps = simulate(load_scene("bed").changed(jumps=12), 1e-6).jumps
    assert {jump.outcome for jump in jumps} == {"touchdown"}
    assert jumps[-1].apex_height_m == pytest.approx(jumps[-2].apex_height_m, rel=1e-3)
    assert all(abs(jump.energy_residual_J) < 1e-6 * jump.energy_at_play_J for jump in jumps)
