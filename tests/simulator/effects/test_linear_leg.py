"""A leg driven straight through a gear: its cap and its heat, against what they are by hand."""

from __future__ import annotations

import pytest

from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

SIM2 = load_scene("sim2")
RADIUS_M = 0.02


def _jump(on: tuple[str, ...], off: tuple[str, ...] = (), **values: float) -> JumpResult:
    return interpreted(simulate, SIM2.changed(values, on, off), 1e-8).jump


def test_the_heat_is_that_of_the_geared_motors_and_the_motion_is_none_of_it() -> None:
    """A force that is commanded at any leg length heats by the square of radius / ratio."""
    six, twelve = (_jump(("linear_leg",), pinion_radius=RADIUS_M, gear_ratio=ratio) for ratio in (6.0, 12.0))
    assert six.stance_heat_J == pytest.approx(4.0 * twelve.stance_heat_J, rel=1e-12)
    assert six.apex_height_m == twelve.apex_height_m == pytest.approx(_jump(()).apex_height_m, rel=1e-7)


def test_the_torque_caps_the_force_at_every_length_alike() -> None:
    capped = _jump(("linear_leg", "torque_cap"), ("constant_force_cap",), pinion_radius=RADIUS_M, gear_ratio=0.2)
    constant = _jump(("linear_leg",), force_cap=2.0 * SIM2["stall_torque"] * 0.2 / RADIUS_M)
    assert capped.capped_time_s == pytest.approx(constant.capped_time_s, rel=1e-6)
    assert capped.capped_time_s > 0.0
    for name in ("apex_height_m", "max_depth_m", "liftoff_time_s"):
        assert getattr(capped, name) == pytest.approx(getattr(constant, name), rel=1e-7)
