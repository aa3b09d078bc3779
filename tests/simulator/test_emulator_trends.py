"""The emulator's trends (scenes.md sections 3 and 6): with gain, torque and active damping, and with its clock."""

from __future__ import annotations

import itertools

import pytest

from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

EMULATOR = load_scene("emulator")
GAINS = (100, 200, 300, 400, 500)
PER_GAIN_KG_M = 3.32 / 6.0
"""Active damping scaled with the gain, at the thesis's ratio of 1 to 6."""


def steady(gain: float, **values: float) -> JumpResult:
    result = simulate(EMULATOR.changed({"k_extension": stiffness_n_m(gain), **values}, jumps=6), 1e-7)
    assert [jump.outcome for jump in result.jumps] == ["touchdown"] * 6
    return result.jump


def test_apexes_rise_with_the_gain_and_with_the_torque_where_it_binds() -> None:
    apexes_m = {
        torque: [steady(gain, stall_torque=torque).apex_height_m or 0.0 for gain in GAINS] for torque in (3.0, 3.5, 4.0)
    }
    for rising in apexes_m.values():
        assert all(lower < higher for lower, higher in itertools.pairwise(rising))
    for weak, usual, strong in zip(*apexes_m.values(), strict=True):
        assert weak <= usual <= strong
    assert apexes_m[4.0][3:] == [pytest.approx(0.477, abs=5e-4), pytest.approx(0.506, abs=5e-4)]


SAVINGS = {100: 0.012, 200: 0.086, 300: 0.173, 400: 0.163, 500: 0.145}


@pytest.mark.parametrize("gain", GAINS)
def test_active_damping_saves_more_the_more_of_it_there_is_and_never_chatters(gain: float) -> None:
    """Zeno: damping switched by contact would let the foot go and catch it again 40 000 times (scenes.md 5.1)."""
    without = steady(gain)
    damped = [steady(gain, b_ad=share * PER_GAIN_KG_M * gain) for share in (0.5, 1.0, 2.0, 3.0)]
    savings = [1.0 - jump.cost_J / without.cost_J for jump in damped]
    assert savings[1] == pytest.approx(SAVINGS[int(gain)], abs=1e-3)
    assert all(0.0 < less < more for less, more in itertools.pairwise(savings))
    assert [len(jump.mode_changes) for jump in damped] == [5] * 4


@pytest.mark.parametrize("gain", [400, 500])
def test_the_cap_is_left_and_reached_without_ringing(gain: float) -> None:
    """On and off would alternate on rounding 38 000 times (scenes.md 5.3)."""
    jump = steady(gain)
    assert 0.03 < jump.capped_time_s < 0.06
    assert jump.steps < 600


def clocked(rate: float, linear: bool) -> tuple[JumpResult, ...]:
    """Jumps at gain 300 with an active gain of 50, controlled continuously (0) or at ticks of a rate (Hz)."""
    on = ("linear_active_damping",) if linear else ()
    scene = EMULATOR.changed({"k_extension": stiffness_n_m(300), "b_ad": 50.0 * 3.32}, on, jumps=3)
    if rate:
        scene = scene.changed({"control_rate": rate}, ("sampled_control",))
    return simulate(scene, 1e-5).jumps


def all_clocked() -> dict[tuple[float, bool], tuple[JumpResult, ...]]:
    return {(rate, linear): clocked(rate, linear) for rate in (0.0, 1e3, 333.0) for linear in (False, True)}


def test_a_slow_clock_makes_sampled_damping_unstable() -> None:
    """1 kHz is fine; held over 3 ms the damping of the foot's speed rings, and added as a force it fails (5.9)."""
    found = interpreted(all_clocked)
    for linear in (False, True):
        continuous, quick = found[0.0, linear][-1], found[1e3, linear][-1]
        assert quick.apex_height_m == pytest.approx(continuous.apex_height_m, abs=5e-4)
        assert len(quick.mode_changes) == len(continuous.mode_changes) == 5
    assert found[333.0, True][-1].outcome == "no_liftoff"
    assert found[333.0, False][-1].apex_height_m == pytest.approx(0.373, abs=2e-3)
    assert found[333.0, False][-1].error_growth > 100.0
