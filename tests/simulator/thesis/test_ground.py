"""The ground's functions of figure 3.2: by hand, and what the simulated ground does."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.thesis.figures import ground_functions, motion_of


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("sim1")


def test_the_functions_are_those_of_the_thesis(scene: Scene) -> None:
    """Poppy seeds under the published foot, by hand from the formulas of 3.1.2: in the cone, at its end, and below."""
    radius, q = 0.03, 2.0 / math.tan(1.0472)
    depths = np.array([0.0, 0.01, radius / q, 0.05])
    found = ground_functions(scene, depths)
    assert found.cone_depth_m == pytest.approx(0.0259809, rel=1e-5)
    for place, depth in enumerate(depths):
        s = min(depth, radius / q)
        area = math.pi * (radius - q * s) ** 2
        volume = math.pi * (radius**3 - (radius - q * s) ** 3) / (3.0 * q)
        penetration = 1600.0 * volume / (math.pi * radius**2)
        stress = 1.2e5 * depth * (math.pi * radius**2 + volume) / math.cos(1.0472)
        assert found.resistance_n[place] == pytest.approx(penetration + stress, rel=1e-12)
        assert found.drag_kg_m[place] == pytest.approx(17.2 * 2.7 * (0.57 * 1000.0 * 2.0 * area + 1.0), rel=1e-12)
        assert found.added_mass_kg[place] == pytest.approx(0.57 * 1000.0 * 2.0 * volume + depth, rel=1e-12)


def test_a_ground_of_another_scale_is_another_ground(scene: Scene) -> None:
    plain, scaled = ground_functions(scene), ground_functions(scene.changed({"kg_scale": 3.0, "bg_scale": 0.5}))
    assert scaled.resistance_n == pytest.approx(3.0 * plain.resistance_n)
    assert scaled.drag_kg_m == pytest.approx(0.5 * plain.drag_kg_m)
    assert scaled.added_mass_kg == pytest.approx(plain.added_mass_kg)


def test_they_are_what_the_simulated_ground_does(scene: Scene) -> None:
    """Integrated along a simulated foot, K and D give the loss, m_a and its slope the grains' energy of its book."""
    motion = motion_of(scene.changed({"b_ad": 0.0}), 1e-9)
    intruding = ~motion.flying & (motion.foot_velocity_m_s < 0.0)
    speed = np.where(intruding, -motion.foot_velocity_m_s, 0.0)
    ground = ground_functions(scene, -motion.foot_height_m)
    slope_kg_m = ground.drag_kg_m / (scene["b_g"] * scene["c_g"])

    def summed(power_w: np.ndarray) -> float:
        return float(np.sum(0.5 * (power_w[1:] + power_w[:-1]) * np.diff(motion.time_s)))

    loss_j = summed(ground.resistance_n * speed + ground.drag_kg_m * speed**3)
    grains_j = summed(ground.added_mass_kg * 9.81 * speed + 0.5 * slope_kg_m * speed**3)
    assert loss_j == pytest.approx(motion.ground_loss_j[-1], rel=1e-3)
    assert grains_j == pytest.approx(motion.grain_energy_j[-1], rel=1e-3)
