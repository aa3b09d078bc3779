"""Figures 3.2 to 3.6: the ground's functions, one jump with either controller, its energies, and the ground's power."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.thesis.figures import (
    JumpEnergies,
    Motion,
    both_controllers,
    ground_functions,
    ground_power_w,
    jump_energies,
    motion_of,
    power_surface,
)
from tests.helpers.thesis import thesis_figures

ACCURACY = 1e-9


@pytest.fixture(scope="module")
def ce_scene() -> Scene:
    return both_controllers(load_scene("sim1")).ce


@pytest.fixture(scope="module")
def ce(ce_scene: Scene) -> Motion:
    return motion_of(ce_scene, ACCURACY)


@pytest.fixture(scope="module")
def energies(ce_scene: Scene, ce: Motion) -> JumpEnergies:
    return jump_energies(ce_scene, ce)


def test_a_motion_is_that_of_the_jump(ce_scene: Scene, ce: Motion) -> None:
    jump = simulate(ce_scene, ACCURACY).jump
    assert np.all(np.diff(ce.time_s) > -1e-12)
    assert (ce.body_height_m[0], ce.foot_height_m[0]) == (0.27, 0.0)
    assert ce.liftoff_time_s == jump.liftoff_time_s
    assert ce.body_height_m.max() == pytest.approx(jump.apex_height_m, rel=1e-6)
    assert ce.ground_loss_j[-1] == pytest.approx(jump.ground_loss_J, rel=1e-9)
    assert ce.jams == sum(change.after == "jammed" for change in jump.mode_changes)
    assert np.all(np.diff(ce.depth_m) >= 0.0)


@pytest.mark.parametrize("name", ["ce", "ad"])
def test_the_phase_is_the_one_whose_gains_give_the_force(name: str) -> None:
    """In compression both controllers are one spring and damper, in extension CE is another."""
    figures = thesis_figures()
    motion = getattr(figures.example, name)
    scene = getattr(both_controllers(figures.set_1), name)
    push_n = scene["body_mass"] * (motion.body_acceleration_m_s2 + 9.81)
    compression_m = scene["rest_length"] - motion.body_height_m + motion.foot_height_m
    speed_m_s = motion.body_velocity_m_s - motion.foot_velocity_m_s
    soft_n = 250.0 * compression_m - 0.5 * speed_m_s
    stiff_n = 650.0 * compression_m - 5.0 * speed_m_s
    held = ~motion.extending & ~motion.flying
    assert push_n[held] == pytest.approx(soft_n[held], abs=0.2)
    if name == "ce":
        assert push_n[motion.extending] == pytest.approx(stiff_n[motion.extending], abs=0.2)
    assert motion.extending.any()
    assert not (motion.extending & motion.flying).any()
    assert motion.switch_time_s == pytest.approx(round(motion.switch_time_s, 3), abs=1e-9)  # a tick


def test_the_energies_close_with_the_energy_book(energies: JumpEnergies) -> None:
    """Without the virtual spring and the grains' weight, the change is what the leg did less what the ground took."""
    motion = energies.motion
    mechanical_j = energies.total_j - energies.leg_spring_j - energies.grain_gravity_j
    book_j = mechanical_j[0] + motion.leg_work_j - motion.ground_loss_j + motion.grain_energy_j
    assert mechanical_j == pytest.approx(book_j, abs=2e-5)
    assert np.all(np.diff(energies.ground_spring_j) >= 0.0)  # pressing the ground is part of what it takes
    assert np.all(energies.ground_spring_j <= motion.ground_loss_j + 1e-5)


def test_the_switch_puts_energy_into_the_spring_and_liftoff_drops_the_grains(energies: JumpEnergies) -> None:
    motion = energies.motion
    switch = int(np.argmax(motion.extending))
    assert energies.leg_spring_j[switch] == pytest.approx(650.0 / 250.0 * energies.leg_spring_j[switch - 1], rel=1e-6)
    liftoff = int(np.argmax(motion.flying))
    without_spring_j = energies.total_j - energies.leg_spring_j  # whose stiffness falls, too
    gained_j = without_spring_j[liftoff] - without_spring_j[liftoff - 1]
    assert gained_j == pytest.approx(-energies.grain_gravity_j[liftoff - 1], abs=1e-9)
    assert 0.0 < gained_j < 0.2  # the small amount of thesis 3.1.5


def test_the_power_is_that_of_eq_3_4() -> None:
    assert ground_power_w(np.array(30.0), np.array(50.0), np.array(-2.0)) == -(50.0 * 8.0 + 30.0 * 2.0)
    surface = power_surface(load_scene("sim1"), 1e-4)
    assert surface.power_w.shape == (surface.velocity_m_s.size, surface.depth_m.size)
    assert np.all(surface.power_w <= 0.0)
    assert np.all(surface.power_w[-1] == 0.0)
    assert np.all(np.diff(surface.power_w, axis=0) >= 0.0)  # the faster, the more


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
