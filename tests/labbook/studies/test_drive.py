"""Joules from force and leg length, against those that the simulator integrates itself."""

from __future__ import annotations

import numpy as np
import pytest

from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.studies.force_plate import Drive
from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.scene_file import load_scene

DRIVE = Drive(0.1, 0.2, 0.09549296586, 0.186, 0.09549296586)


@pytest.mark.parametrize("gain", [300, pytest.param(600, marks=pytest.mark.soak)])
def test_joules_of_a_stance_are_the_simulator_s(gain: int) -> None:
    scene = load_scene("force_plate").changed({"k_extension": stiffness_n_m(gain)}, jumps=4)
    result = simulate(scene, 1e-6, trajectory=True)
    motion, jump = result.trajectory, result.jumps[-1]
    assert motion is not None
    stance = motion.sel(time=(motion["jump"] == 3) & (motion["mode"] == 0))
    time_s, length_m, speed_m_s, acceleration = (
        stance[name].to_numpy() for name in ("time", "leg_length", "body_velocity", "body_acceleration")
    )
    force_n = scene["body_mass"] * (acceleration + STANDARD_GRAVITY_M_S2)
    levers_m = DRIVE.levers_m(length_m)
    found = [
        np.trapezoid(power_w, time_s)
        for power_w in (DRIVE.heat_w(force_n, levers_m), DRIVE.drag_w(speed_m_s, levers_m), force_n * speed_m_s)
    ]
    assert found == pytest.approx([jump.stance_heat_J, jump.stance_drag_J, jump.stance_mechanical_J], rel=5e-4)


def test_a_leg_reaches_from_folded_to_straight() -> None:
    assert DRIVE.reach_m == pytest.approx((0.1, 0.3))
