"""The emulator's trends, its state machine's edges and its stop; a platform with no damping or hardly any give."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import pytest

from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

EMULATOR, PLATE = load_scene("emulator"), load_scene("force_plate")
TRAVEL_M = EMULATOR["platform_travel"]
EVENT_ALLOWANCE_M = 1e-10
"""How far past the stop the platform may be found at accuracy 1e-8."""
FOURTH, SIXTH = 4, 6


def jumps_of(values: Mapping[str, float], jumps: int = SIXTH, accuracy: float = 1e-8) -> tuple[JumpResult, ...]:
    return simulate(EMULATOR.changed(values, jumps=jumps), accuracy).jumps


def at_gain(gain: float) -> dict[str, float]:
    return {"k_extension": stiffness_n_m(gain)}


def counted(jumps: tuple[JumpResult, ...], counter: str) -> list[int]:
    return [jump.counters[counter] for jump in jumps]


def assert_closes(jumps: tuple[JumpResult, ...]) -> None:
    assert max(abs(jump.energy_residual_J) for jump in jumps) < 1e-8


@pytest.mark.parametrize("shortest_hold", [0.0, 0.02, 0.1, 0.4])
@pytest.mark.parametrize("gain", [100, 300])
def test_the_shortest_hold_never_binds(gain: float, shortest_hold: float) -> None:
    found = jumps_of({**at_gain(gain), "shortest_hold": shortest_hold})
    assert found == jumps_of(at_gain(gain))
    assert not any(counted(found, "release_missed"))


def test_a_hold_that_is_too_long_misses_the_release() -> None:
    """The platform stays down, and the next jump starts from there: 0.473 m in place of 0.418 m."""
    default, late = jumps_of({}, 12), jumps_of({"shortest_hold": 0.6}, 12)
    assert default[-1].apex_height_m == pytest.approx(0.418, abs=5e-4)
    assert max(jump.apex_height_m or 0.0 for jump in late) == pytest.approx(0.473, abs=5e-4)
    assert sum(counted(late, "release_missed")) == 6
    assert not any(counted(late, "bottomed"))
    assert_closes(late)


def test_a_hold_of_two_seconds_bottoms_and_folds_the_leg() -> None:
    found = jumps_of({"shortest_hold": 2.0}, 12)
    assert found[-1].outcome == "leg_folded"
    assert counted(found[:-1], "release_missed") == [1] * (len(found) - 1)
    assert sum(counted(found, "bottomed")) == 2
    assert found[-1].max_depth_m == pytest.approx(TRAVEL_M, abs=EVENT_ALLOWANCE_M)
    assert_closes(found)


@pytest.mark.parametrize(("gain", "bottoms"), [(100, False), (200, False), (300, True), (400, True)])
def test_a_platform_as_soft_as_sand_reaches_its_stop_from_gain_300_on(gain: float, bottoms: bool) -> None:
    found = jumps_of({**at_gain(gain), "platform_stiffness": 684.0})
    assert counted(found, "bottomed") == [0] + [int(bottoms)] * 5
    for jump in found:
        assert jump.outcome == "touchdown"
        assert (jump.max_depth_m >= TRAVEL_M) == bool(jump.counters["bottomed"])
        assert jump.max_depth_m <= TRAVEL_M + EVENT_ALLOWANCE_M
    stopped = [jump.impact_loss_J for jump in found if jump.counters["bottomed"]]
    assert all(loss > 1e-3 for loss in stopped)
    assert_closes(found)


def test_a_platform_without_damping_ends_at_its_stop() -> None:
    found = jumps_of({"platform_damping": 0.0, "platform_drag": 0.0})
    assert [jump.outcome for jump in found] == ["touchdown"] * SIXTH
    assert counted(found, "bottomed")[1:] == [1] * (SIXTH - 1)
    assert_closes(found)


def test_a_stiff_platform_approaches_rigid_ground() -> None:
    """The depth falls with the root of the stiffness, and with it what is lost there and how jumps differ."""
    rigid = simulate(PLATE.changed(jumps=FOURTH), 1e-9).jumps
    leg = {name: PLATE[name] for name in EMULATOR.read}
    away_m, depths_m = [], []
    for power in (5, 6, 7, 8, 9):
        soft = jumps_of({**leg, "platform_stiffness": 10.0**power}, FOURTH, 1e-9)
        away_m.append(abs((soft[-1].apex_height_m or 0.0) - (rigid[-1].apex_height_m or 0.0)))
        depths_m.append(soft[-1].max_depth_m)
    for found in (away_m, depths_m):
        assert all(2.5 < earlier / later < 4.0 for earlier, later in itertools.pairwise(found))
    assert away_m[-1] < 2e-5
    for one, other in zip(soft, rigid, strict=True):
        assert one.jump_heat_J == pytest.approx(other.jump_heat_J, rel=1e-4)
        assert one.liftoff_time_s == pytest.approx(other.liftoff_time_s, rel=1e-4)
        assert one.impact_loss_J + one.ground_loss_J == pytest.approx(other.impact_loss_J, abs=2e-4)


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


@pytest.mark.parametrize("gain", GAINS)
def test_active_damping_saves_more_the_more_of_it_there_is_and_never_chatters(gain: float) -> None:
    """Zeno: damping switched by contact would let the foot go and catch it again 40 000 times (scenes.md 5.1)."""
    without = steady(gain)
    damped = [steady(gain, b_ad=share * PER_GAIN_KG_M * gain) for share in (0.5, 1.0, 2.0, 3.0)]
    savings = [1.0 - jump.cost_J / without.cost_J for jump in damped]
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


def test_a_slow_clock_makes_sampled_damping_unstable() -> None:
    """1 kHz is fine; held over 3 ms the damping of the foot's speed rings, and added as a force it fails (5.9)."""
    every = [(rate, linear) for rate in (0.0, 1e3, 333.0) for linear in (False, True)]
    found = {one: interpreted(clocked, *one) for one in every}
    for linear in (False, True):
        continuous, quick = found[0.0, linear][-1], found[1e3, linear][-1]
        assert quick.apex_height_m == pytest.approx(continuous.apex_height_m, abs=5e-4)
        assert len(quick.mode_changes) == len(continuous.mode_changes) == 5
    assert found[333.0, True][-1].outcome == "no_liftoff"
    assert found[333.0, False][-1].apex_height_m == pytest.approx(0.373, abs=2e-3)
    assert found[333.0, False][-1].error_growth > 100.0
