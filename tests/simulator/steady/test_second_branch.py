"""The map from jump to jump on the force plate has two fixed points (scenes.md section 4); the start chooses one."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene_file import load_scene

ACCURACY = 1e-8
STEADY_M = 1e-5
"""Most by which the last two apexes differ: one cycle of these comes to rest slowly."""
LOWER_M, HIGHER_M = (0.45, 0.56), (0.63, 0.72)
BISTABLE = [
    (600.0, {}),
    (500.0, {"b_compression": 22.0}),
    (400.0, {"k_compression": 200.0}),
]
"""Gains, and what else is changed in the shipped scene: softer or less damped, the higher branch begins lower."""


def last_two(gain: float, changed: Mapping[str, float], initial_height_m: float) -> tuple[JumpResult, JumpResult]:
    values = {"k_extension": stiffness_n_m(gain), "initial_height": initial_height_m, **changed}
    scene = load_scene("force_plate").changed(values)
    jumps = simulate(scene, ACCURACY).jumps
    assert len(jumps) == scene.jumps
    return jumps[-2], jumps[-1]


def steady_apex_m(before: JumpResult, last: JumpResult) -> float:
    assert before.apex_height_m is not None
    assert last.apex_height_m is not None
    assert abs(last.apex_height_m - before.apex_height_m) < STEADY_M
    return last.apex_height_m


@pytest.mark.parametrize(("gain", "changed"), BISTABLE)
def test_a_robot_dropped_from_higher_goes_on_jumping_higher(gain: float, changed: Mapping[str, float]) -> None:
    low, high = (last_two(gain, changed, height_m) for height_m in (0.0, 0.45))
    assert LOWER_M[0] < steady_apex_m(*low) < LOWER_M[1]
    assert HIGHER_M[0] < steady_apex_m(*high) < HIGHER_M[1]
    assert [jump.counters["guard_switch"] for jump in (low[1], high[1])] == [0, 1]  # where the leg turns stiff
    guard_m = load_scene("force_plate")["guard_length"]
    assert low[1].min_leg_length_m > guard_m >= high[1].min_leg_length_m


@pytest.mark.soak
@pytest.mark.parametrize(("gain", "changed"), BISTABLE)
def test_without_the_guard_there_is_no_higher_branch(gain: float, changed: Mapping[str, float]) -> None:
    values = {"k_extension": stiffness_n_m(gain), "initial_height": 0.45, **changed}
    scene = load_scene("force_plate").changed(values, effects_off=["short_leg_guard"])
    assert simulate(scene, ACCURACY).jump.outcome == "leg_folded"


@pytest.mark.parametrize("initial_height_m", [0.0, 0.05, 0.2, 0.45])
def test_the_shipped_scene_comes_to_the_same_jump_from_any_height(initial_height_m: float) -> None:
    assert steady_apex_m(*last_two(300.0, {}, initial_height_m)) == pytest.approx(0.3367, abs=1e-4)


@pytest.mark.parametrize("gain", [400.0, 500.0, 600.0])
def test_far_enough_off_only_the_higher_branch_is_left(gain: float) -> None:
    apexes_m = [steady_apex_m(*last_two(gain, {"k_compression": 180.0}, height_m)) for height_m in (0.0, 0.45)]
    assert apexes_m[0] == pytest.approx(apexes_m[1], rel=1e-6)
    assert HIGHER_M[0] < apexes_m[0] < 0.73
