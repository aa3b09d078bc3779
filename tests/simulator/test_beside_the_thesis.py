"""Hard cases with the thesis's fixed-step scheme beside them: explicit Euler at its step of 1 microsecond fails."""

from __future__ import annotations

import math

import pytest

from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.fixed_step_euler import fixed_step_euler_jump, outcome

SIM2 = load_scene("sim2")
STIFF = (1e4, 1e6, 1e8)


def jump_of(scene: Scene, accuracy: float = 1e-9) -> JumpResult:
    return simulate(scene, accuracy).jump


@pytest.mark.parametrize(("kg_scale", "too_deep"), [(1e2, 1.08), (1e4, 1.5), (1e6, 5.0), (1e8, 8.0)])
def test_on_stiff_ground_fixed_steps_go_through_the_surface(kg_scale: float, too_deep: float) -> None:
    """An intrusion of microseconds is as long as a step of theirs; here its depth is that of all accuracies."""
    scene = SIM2.changed({"kg_scale": kg_scale})
    found, coarse = jump_of(scene), jump_of(scene, 1e-4)
    assert coarse.max_depth_m == pytest.approx(found.max_depth_m, rel=1e-4)
    assert fixed_step_euler_jump(scene)["max_depth_m"] > too_deep * found.max_depth_m


def test_at_the_stiffest_they_fold_the_leg() -> None:
    scene = SIM2.changed({"kg_scale": 1e8})
    assert outcome(fixed_step_euler_jump(scene)) == "leg_folded"
    assert jump_of(scene).outcome == "touchdown"


@pytest.mark.parametrize("kg_scale", STIFF)
def test_an_intrusion_that_begins_and_ends_inside_one_step(kg_scale: float) -> None:
    """On stiff ground the foot is stopped by a linear spring, in a quarter of its period; steps before and after are a
    hundred times as long.
    """
    scene = SIM2.changed({"kg_scale": kg_scale})
    jump = jump_of(scene)
    first, second = jump.mode_changes[:2]
    area_m2, cone = math.pi * scene["foot_radius"] ** 2, math.cos(scene["cone_angle"])
    stiffness_n_m = kg_scale * (scene["k_sh"] + scene["sigma"] * area_m2 / cone)
    omega = math.sqrt(stiffness_n_m / scene["foot_mass"])
    assert (first.after, second.after) == ("intruding", "jammed")
    assert second.time_s == pytest.approx(0.5 * math.pi / omega, rel=0.05)
    assert jump.max_depth_m == pytest.approx(-scene["initial_velocity"] / omega, rel=0.1)
    assert second.time_s < 2e-4
    assert jump.next_touchdown_time_s is not None
    assert jump.next_touchdown_time_s / jump.steps > 5.0 * second.time_s


@pytest.mark.parametrize(("foot_mass", "apart"), [(1e-3, 0.005), (1e-4, 0.05), (1e-5, 0.15), (1e-6, 0.15)])
def test_a_light_foot_is_no_foot_for_fixed_steps(foot_mass: float, apart: float) -> None:
    """The apex leaves the limit that it tends to; at a milligram the scheme calls some steps a stance."""
    limit_m = jump_of(SIM2.changed({"foot_mass": 1e-6})).apex_height_m
    scene = SIM2.changed({"foot_mass": foot_mass})
    found, by_steps = jump_of(scene), fixed_step_euler_jump(scene)
    assert found.apex_height_m == pytest.approx(limit_m, rel=1e-3)
    assert limit_m is not None
    assert abs(by_steps["apex_height_m"] / limit_m - 1.0) > apart
    assert by_steps["liftoff_time_s"] < 1e-4 or foot_mass > 1e-6


def test_a_resting_foot_is_one_jam_here_and_thousands_of_flips_there() -> None:
    """Zeno: by fixed steps the foot jams and yields from step to step (thesis 3.2, footnote 1)."""
    scene = SIM2.changed({"initial_velocity": 0.0})
    jump = jump_of(scene)
    assert len(jump.mode_changes) < 10
    assert fixed_step_euler_jump(scene)["mode_changes"] > 500 * len(jump.mode_changes)


def test_under_much_sampled_damping_fixed_steps_miss_the_chatter() -> None:
    scene = SIM2.changed({"k_extension": 1091.36, "b_ad": 610.0})
    found = jump_of(scene)
    assert found.ill_conditioned
    assert abs(fixed_step_euler_jump(scene)["apex_height_m"] - (found.apex_height_m or 0.0)) > 0.004


def test_a_leg_too_damped_to_jump_jumps_by_fixed_steps() -> None:
    scene = SIM2.changed({"b_extension": 1e4})
    assert jump_of(scene).outcome == "no_liftoff"
    assert outcome(fixed_step_euler_jump(scene)) == "apex"
