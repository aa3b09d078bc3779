"""Motion that decays within a fraction of a step: what the controller sees of it, and where a foot stops."""

from __future__ import annotations

import pytest

from simulator.jump import simulate
from simulator.scene_file import load_scene

DAMPED = {
    "body_mass": 0.04, "foot_mass": 10.0, "rest_length": 0.7, "upper_link": 0.8, "lower_link": 1.0,
    "k_extension": 30.5, "kg_scale": 200.0, "b_extension": 300.0, "control_rate": 20000.0, "motor_resistance": 0.02,
}  # fmt: skip
"""A light body on a heavy foot: in extension its speed decays in 0.1 ms, two ticks, and its length in 10 s."""
STOPPED = {
    "foot_mass": 1e-4, "rest_length": 0.05, "upper_link": 0.02, "lower_link": 0.05, "initial_velocity": -5.0,
    "foot_radius": 0.1, "sigma": 7e13, "kg_scale": 2e8, "rho": 10.0, "added_mass_constant": 20.0, "b_g": 121.0,
    "c_g": 500.0, "bg_scale": 50.0,
}  # fmt: skip
"""A light foot that very stiff ground stops within some 1e-12 s."""


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_a_controller_sees_the_motion_itself_at_its_ticks(accuracy: float) -> None:
    """It chattered on a dense output that had passed over the decay: 0.8 to 9 times the cost."""
    scene = load_scene("sim2").changed(DAMPED)
    jump, finest = simulate(scene, accuracy).jump, simulate(scene, 1e-12).jump
    assert jump.cost_J == pytest.approx(finest.cost_J, rel=1e-3)
    assert jump.steps < finest.steps


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-8])
def test_a_foot_that_stops_at_once_is_as_deep_as_is_asked_for(accuracy: float) -> None:
    scene = load_scene("bed").changed(STOPPED)
    depths_m = [simulate(scene, goal).jump.max_depth_m for goal in (accuracy, 1e-12)]
    assert depths_m[0] == pytest.approx(depths_m[1], rel=accuracy, abs=0.0)
