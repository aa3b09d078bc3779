"""The energy book: mechanical energy, computed anew from the motion, against the published sums; each one counts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from simulator.effects.registry import BOOKED
from simulator.jump import simulate
from simulator.kernel.layout import INTRUDING
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene, shipped_scenes
from tests.helpers.kernels import interpreted

Row = NDArray[np.float64]
ACCURACY = 1e-8
PLATE, EMULATOR = load_scene("force_plate"), load_scene("emulator")
SIGNS = {"leg_work_J": 1.0, **{energy.column: float(energy.sign) for energy in BOOKED}}
"""How each sum of a result changes body and foot's energy."""
SHOWING = {"leg_work_J": "sim2", "ground_loss_J": "sim2", "grain_energy_J": "bed", "impact_loss_J": "force_plate"}
"""Shipped scenes that turn over each sum; friction and reset take a scene of their own."""


@dataclass(frozen=True, slots=True)
class Motion:
    """What a book is kept of: a scene's jumps, and its states at the end of each."""

    scene: Scene
    jumps: tuple[JumpResult, ...]
    trajectory: xr.Dataset


def added_mass_kg(scene: Scene, depth_m: Row) -> Row:
    """Grains that move with the foot (thesis 3.1.2): phi rho mu V(s) + C z."""
    if "added_mass" not in scene.effects:
        return np.zeros_like(depth_m)
    q = scene["mu"] / math.tan(scene["cone_angle"])
    formed_m = np.clip(depth_m, 0.0, scene["foot_radius"] / q)
    radius_m = scene["foot_radius"]
    cone_m3 = np.pi * (radius_m**2 * formed_m - q * radius_m * formed_m**2 + q**2 * formed_m**3 / 3.0)
    return np.asarray(scene["phi"] * scene["rho"] * scene["mu"] * cone_m3 + scene["added_mass_constant"] * depth_m)


def energy_j(scene: Scene, motion: xr.Dataset) -> Row:
    """Kinetic and potential energy of body and foot, and of the grains while they move with it."""
    body_kg, foot_kg = scene["body_mass"], scene["foot_mass"]
    moved_kg = foot_kg + np.where(motion["mode"] == INTRUDING, added_mass_kg(scene, -motion["foot_height"].values), 0.0)
    return np.asarray(
        body_kg * (motion["body_velocity"].values ** 2 / 2.0 + 9.81 * motion["body_height"].values)
        + moved_kg * motion["foot_velocity"].values ** 2 / 2.0
        + foot_kg * 9.81 * motion["foot_height"].values
    )


def moved(scene: Scene) -> Motion:
    result = simulate(scene, ACCURACY, trajectory=True)
    assert result.trajectory is not None
    return Motion(scene, result.jumps, result.trajectory)


def gains_j(motion: Motion) -> Row:
    """Mechanical energy gained in each jump, from just before its touchdown to just before the next."""
    scene = motion.scene
    height_m, speed_m_s = scene["initial_height"], scene["initial_velocity"]
    total_kg = scene["body_mass"] + scene["foot_mass"]
    start_j = total_kg * (speed_m_s**2 / 2.0 + 9.81 * height_m) + scene["body_mass"] * 9.81 * scene["rest_length"]
    number = motion.trajectory["jump"].values
    last = [int(np.flatnonzero(number == jump)[-1]) for jump in range(len(motion.jumps))]
    ends_j = energy_j(scene, motion.trajectory)[last]
    return np.diff(np.concatenate([[start_j], ends_j]))


def booked_j(jump: JumpResult, without: str = "") -> float:
    return math.fsum(sign * getattr(jump, name) for name, sign in SIGNS.items() if name != without)


@pytest.fixture(scope="module")
def motions() -> dict[str, Motion]:
    scenes = map(load_scene, shipped_scenes())
    less = {"sim1": {"b_ad": 60.0}, "bed": {"b_ad": 60.0}}
    return {one.name: moved(one.changed(less.get(one.name, {}), jumps=min(one.jumps, 3))) for one in scenes}


def assert_closes(motion: Motion) -> None:
    for gained_j, jump in zip(gains_j(motion), motion.jumps, strict=True):
        turned_over_j = abs(jump.leg_work_J) + 5.0
        assert jump.outcome == "touchdown"
        assert abs(gained_j - booked_j(jump)) < 3.0 * ACCURACY * turned_over_j
        assert abs(jump.energy_residual_J) < 3.0 * ACCURACY * turned_over_j


def assert_counts(term: str, motion: Motion) -> None:
    open_j = [gained - booked_j(jump, term) for gained, jump in zip(gains_j(motion), motion.jumps, strict=True)]
    assert max(map(abs, open_j)) > 1e-4, term


@pytest.mark.parametrize("name", shipped_scenes())
def test_the_book_closes_within_the_accuracy_and_at_every_instant(name: str, motions: dict[str, Motion]) -> None:
    """At the ends of steps, where two samples share a time; between them to what a drawing needs."""
    motion = motions[name]
    assert_closes(motion)
    found = energy_j(motion.scene, motion.trajectory)
    number = motion.trajectory["jump"].values
    for jump, result in enumerate(motion.jumps):
        time_s = motion.trajectory["time"].values
        inside = np.flatnonzero((number == jump) & (time_s > result.touchdown_time_s))
        booked = motion.trajectory["leg_work"].values[inside].copy()
        for integral, sign in (("ground_loss", -1.0), ("grain_energy", 1.0), ("reset_work", 1.0)):
            if integral in motion.trajectory:
                booked += sign * motion.trajectory[integral].values[inside]
        left = found[inside] - booked
        ends = np.diff(time_s[inside], prepend=-1.0) == 0.0
        assert ends.sum() > 20
        assert np.ptp(left[ends]) < 3e-7
        assert np.ptp(left) < 5e-4


@pytest.mark.parametrize(("term", "name"), SHOWING.items())
def test_leaving_a_term_out_leaves_the_book_open(term: str, name: str, motions: dict[str, Motion]) -> None:
    assert_counts(term, motions[name])


@pytest.mark.parametrize(
    ("term", "scene"),
    [
        ("friction_loss_J", PLATE.changed({"rail_friction_force": 2.0}, ("rail_friction",), jumps=2)),
        ("reset_work_J", EMULATOR.changed({"reset_time": 0.35, "k_extension": 323.36}, jumps=2)),
    ],
)
def test_friction_and_the_work_of_a_reset_count_too(term: str, scene: Scene) -> None:
    motion = interpreted(moved, scene)
    assert_closes(motion)
    assert_counts(term, motion)
