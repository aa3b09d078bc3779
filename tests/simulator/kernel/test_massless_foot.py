"""A foot too light for its inertia to be seen follows the emulator's platform, as explicit steps would show."""

from __future__ import annotations

import pytest

from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene_file import load_scene

OUTPUTS = ("max_depth_m", "liftoff_time_s", "apex_height_m", "cost_J")


def last_of_three(foot_mass_kg: float, accuracy: float) -> JumpResult:
    scene = load_scene("emulator").changed({"foot_mass": foot_mass_kg}, jumps=3)
    return simulate(scene, accuracy).jump


def follows(jump: JumpResult) -> bool:
    return any(change.after == "creeping" for change in jump.mode_changes)


@pytest.mark.parametrize("foot_mass_kg", [1e-4, 3e-4])
def test_it_is_what_explicit_steps_give(foot_mass_kg: float) -> None:
    followed, stepped = last_of_three(foot_mass_kg, 1e-6), last_of_three(foot_mass_kg, 1e-9)
    assert follows(followed)
    assert not follows(stepped)
    assert 10 * followed.steps < stepped.steps
    for name in OUTPUTS:
        assert getattr(followed, name) == pytest.approx(getattr(stepped, name), rel=1e-6), name


def test_lighter_feet_come_to_the_massless_one_in_proportion() -> None:
    heavy, light, lightest = (last_of_three(mass, 1e-7).apex_height_m for mass in (4e-5, 2e-5, 1e-5))
    assert heavy is not None
    assert light is not None
    assert lightest is not None
    assert (heavy - light) / (light - lightest) == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_a_milligram_ends_in_bounded_work(accuracy: float) -> None:
    jump = last_of_three(1e-6, accuracy)
    assert jump.outcome == "touchdown"
    assert follows(jump)
    assert jump.steps < 20_000
    assert abs(jump.energy_residual_J) < accuracy * jump.cost_J
