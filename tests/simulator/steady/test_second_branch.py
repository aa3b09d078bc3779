"""The map from jump to jump on the force plate has two fixed points (scenes.md section 4); the start chooses one."""

from __future__ import annotations

import pytest

from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene_file import load_scene
from tests.helpers.scenes import with_set

ACCURACY = 1e-8
STEADY_M = 1e-5
"""Most by which the last two apexes differ: one cycle of these comes to rest slowly."""
LOWER_M, HIGHER_M = (0.45, 0.56), (0.63, 0.72)
PLATE = load_scene("force_plate")
BISTABLE = ["gain=600", "gain=500 b_compression=22", "gain=400 k_compression=200"]
"""Changes of the shipped scene: softer or less damped, the higher branch begins lower."""


def steady(words: str, initial_height_m: float) -> tuple[JumpResult, float]:
    """The last jump, and its apex, m."""
    scene = with_set(PLATE, f"{words} initial_height={initial_height_m}")
    *others, last = simulate(scene, ACCURACY).jumps
    assert len(others) == scene.jumps - 1
    apexes_m = [jump.apex_height_m or 0.0 for jump in (others[-1], last)]
    assert abs(apexes_m[1] - apexes_m[0]) < STEADY_M
    return last, apexes_m[1]


@pytest.mark.parametrize("words", BISTABLE)
def test_a_robot_dropped_from_higher_goes_on_jumping_higher(words: str) -> None:
    (low, low_m), (high, high_m) = (steady(words, height_m) for height_m in (0.0, 0.45))
    assert LOWER_M[0] < low_m < LOWER_M[1]
    assert HIGHER_M[0] < high_m < HIGHER_M[1]
    assert [jump.counters["guard_switch"] for jump in (low, high)] == [0, 1]  # where the leg turns stiff
    assert low.min_leg_length_m > PLATE["guard_length"] >= high.min_leg_length_m


@pytest.mark.soak
@pytest.mark.parametrize("words", BISTABLE)
def test_without_the_guard_there_is_no_higher_branch(words: str) -> None:
    scene = with_set(PLATE, f"{words} initial_height=0.45").changed(effects_off=["short_leg_guard"])
    assert simulate(scene, ACCURACY).jump.outcome == "leg_folded"


@pytest.mark.parametrize("initial_height_m", [0.0, 0.05, 0.2, 0.45])
def test_the_shipped_scene_comes_to_the_same_jump_from_any_height(initial_height_m: float) -> None:
    assert steady("gain=300", initial_height_m)[1] == pytest.approx(0.3367, abs=1e-4)


@pytest.mark.parametrize("gain", [400, 500, 600])
def test_far_enough_off_only_the_higher_branch_is_left(gain: int) -> None:
    apexes_m = [steady(f"gain={gain} k_compression=180", height_m)[1] for height_m in (0.0, 0.45)]
    assert apexes_m[0] == pytest.approx(apexes_m[1], rel=1e-6)
    assert HIGHER_M[0] < apexes_m[0] < 0.73
