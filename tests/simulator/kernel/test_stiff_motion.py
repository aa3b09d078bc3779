"""Motion faster than a step: feet without inertia on the emulator, quick decays, and feet that stop at once."""

from __future__ import annotations

import pytest

from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene_file import load_scene
from tests.helpers.scenes import with_set

OUTPUTS = ("max_depth_m", "liftoff_time_s", "apex_height_m", "cost_J")


def last_of_three(foot_mass_kg: float, accuracy: float) -> JumpResult:
    scene = load_scene("emulator").changed({"foot_mass": foot_mass_kg}, jumps=3)
    return simulate(scene, accuracy).jump


def follows(jump: JumpResult) -> bool:
    return any(change.after == "creeping" for change in jump.mode_changes)


@pytest.mark.parametrize("foot_mass_kg", [1e-4, 3e-4])
def test_a_foot_too_light_to_be_seen_follows_the_platform_as_explicit_steps_give(foot_mass_kg: float) -> None:
    followed, stepped = last_of_three(foot_mass_kg, 1e-6), last_of_three(foot_mass_kg, 1e-9)
    assert follows(followed)
    assert not follows(stepped)
    assert 10 * followed.steps < stepped.steps
    for name in OUTPUTS:
        assert getattr(followed, name) == pytest.approx(getattr(stepped, name), rel=1e-6), name


def test_lighter_feet_come_to_the_massless_one_in_proportion() -> None:
    heavy, light, lightest = (last_of_three(mass, 1e-7).apex_height_m or 0.0 for mass in (4e-5, 2e-5, 1e-5))
    assert (heavy - light) / (light - lightest) == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_a_milligram_ends_in_bounded_work(accuracy: float) -> None:
    jump = last_of_three(1e-6, accuracy)
    assert jump.outcome == "touchdown"
    assert follows(jump)
    assert jump.steps < 20_000
    assert abs(jump.energy_residual_J) < accuracy * jump.cost_J


DAMPED = (
    "body_mass=0.04 foot_mass=10 rest_length=0.7 upper_link=0.8 lower_link=1 k_extension=30.5 kg_scale=200 "
    "b_extension=300 control_rate=20000 motor_resistance=0.02"
)
"""A light body on a heavy foot: in extension its speed decays in 0.1 ms, two ticks, and its length in 10 s."""
STOPPED = (
    "foot_mass=1e-4 rest_length=0.05 upper_link=0.02 lower_link=0.05 initial_velocity=-5 foot_radius=0.1 sigma=7e13 "
    "kg_scale=2e8 rho=10 added_mass_constant=20 b_g=121 c_g=500 bg_scale=50"
)
"""A light foot that very stiff ground stops within some 1e-12 s."""


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_a_controller_sees_the_motion_itself_at_its_ticks(accuracy: float) -> None:
    """It chattered on a dense output that had passed over the decay: 0.8 to 9 times the cost."""
    scene = with_set(load_scene("sim2"), DAMPED)
    jump, finest = simulate(scene, accuracy).jump, simulate(scene, 1e-12).jump
    assert jump.cost_J == pytest.approx(finest.cost_J, rel=1e-3)
    assert jump.steps < finest.steps


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-8])
def test_a_foot_that_stops_at_once_is_as_deep_as_is_asked_for(accuracy: float) -> None:
    scene = with_set(load_scene("bed"), STOPPED)
    depths_m = [simulate(scene, goal).jump.max_depth_m for goal in (accuracy, 1e-12)]
    assert depths_m[0] == pytest.approx(depths_m[1], rel=accuracy, abs=0.0)
