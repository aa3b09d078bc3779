"""The emulator's hard cases: its state machine's edges, its stop, a platform with no damping or hardly any give."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.kernel.layout import MODES
from simulator.result import JumpResult
from simulator.scene_file import load_scene

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
    """Measured: 3e-9 J at accuracy 1e-8."""
    assert max(abs(jump.energy_residual_J) for jump in jumps) < 1e-8


@pytest.mark.parametrize("shortest_hold", [0.0, 0.02, 0.1, 0.4])
@pytest.mark.parametrize("gain", [100, 300])
def test_the_shortest_hold_never_binds(gain: float, shortest_hold: float) -> None:
    """A hold begins in flight: any time up to 0.5 s gives the same jumps (scenes.md section 1)."""
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


def test_a_release_that_a_sampled_controller_misses_is_counted_too() -> None:
    scene = EMULATOR.changed({"shortest_hold": 0.6}, effects_on=["sampled_control"], jumps=4)
    assert counted(simulate(scene, 1e-6).jumps, "release_missed") == [1, 0, 1, 0]


def test_a_hold_of_two_seconds_bottoms_and_folds_the_leg() -> None:
    found = jumps_of({"shortest_hold": 2.0}, 12)
    assert found[-1].outcome == "leg_folded"
    assert counted(found[:-1], "release_missed") == [1] * (len(found) - 1)
    assert sum(counted(found, "bottomed")) == 2
    assert found[-1].max_depth_m == pytest.approx(TRAVEL_M, abs=EVENT_ALLOWANCE_M)
    assert_closes(found)


def test_release_and_switch_at_one_instant() -> None:
    """The platform is released first: nothing changes from a tolerance a little above that of the leg."""
    tied, before = jumps_of({"release_tolerance": 0.005}), jumps_of({"release_tolerance": 0.0051})
    assert EMULATOR["rest_tolerance"] == 0.005
    assert not any(counted(tied, "release_missed"))
    for one, other in zip(tied, before, strict=True):
        assert one.apex_height_m == pytest.approx(other.apex_height_m, abs=5e-9)
        assert [change.after for change in one.mode_changes] == [change.after for change in other.mode_changes]
    assert_closes(tied)


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


LEG = (
    "body_mass",
    "foot_mass",
    "rest_length",
    "k_compression",
    "k_extension",
    "b_compression",
    "b_extension",
    "switch_speed_tolerance",
    "rest_tolerance",
)


def test_a_stiff_platform_approaches_rigid_ground() -> None:
    """The depth falls with the root of the stiffness, and with it what is lost there and how jumps differ."""
    rigid = simulate(PLATE.changed(jumps=FOURTH), 1e-9).jumps
    leg = {name: PLATE[name] for name in LEG}
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


REACHED_IN_RESET = {
    # random scenes in which the platform comes up as the foot comes down
    "light": {
        "body_mass": 0.5388,
        "foot_mass": 0.2968,
        "k_compression": 188.2,
        "k_extension": 3750.0,
        "platform_stiffness": 340.1,
        "platform_damping": 36.4,
        "platform_drag": 17.23,
        "platform_travel": 0.3423,
        "release_time": 0.004359,
        "reset_time": 0.2036,
        "engage_time": 0.04781,
        "b_compression": 14.41,
        "b_extension": 2.016,
        "b_ad": 322.8,
        "switch_compression": 0.01938,
        "guard_length": 0.1694,
        "stall_torque": 1.513,
    },
    "heavy": {
        "body_mass": 1.985,
        "foot_mass": 0.4894,
        "k_compression": 102.3,
        "k_extension": 3320.0,
        "platform_stiffness": 1375.0,
        "platform_damping": 7.589,
        "platform_drag": 64.88,
        "platform_travel": 0.1849,
        "release_time": 0.002135,
        "reset_time": 0.2778,
        "engage_time": 0.003665,
        "release_tolerance": 0.01771,
        "b_compression": 10.79,
        "b_extension": 0.2923,
        "b_ad": 407.4,
        "switch_compression": 0.07457,
        "guard_length": 0.1937,
        "stall_torque": 4.862,
    },
    "shipped, quick": {**at_gain(100), "reset_time": 0.25},
    "shipped, slow": {**at_gain(100), "reset_time": 0.35},
}


@pytest.mark.parametrize("accuracy", [1e-4, 1e-8])
@pytest.mark.parametrize("name", REACHED_IN_RESET)
def test_depth_is_that_of_the_deepest_foot_where_it_lands_on_the_rising_platform(name: str, accuracy: float) -> None:
    result = simulate(EMULATOR.changed(REACHED_IN_RESET[name], jumps=2), accuracy, trajectory=True)
    assert result.jump.counters["touched_during_reset"] > 0
    assert result.trajectory is not None
    motion: Any = result.trajectory
    stance = motion["mode"].values != MODES.index("flight")
    for place, jump in enumerate(result.jumps):
        heights_m = motion["foot_height"].values[stance & (motion["jump"].values == place)]
        assert jump.max_depth_m == pytest.approx(-heights_m.min(), abs=1e-12)


@pytest.mark.parametrize("reset_time", [0.06, 0.15, 0.25, 0.35])
def test_what_happens_at_the_lowest_gain_does_not_hang_on_the_accuracy(reset_time: float) -> None:
    """Counters and modes, jump by jump; with long resets the platform meets the foot on its way."""

    def story(accuracy: float) -> list[tuple[dict[str, int], list[str]]]:
        found = jumps_of({**at_gain(100), "reset_time": reset_time}, FOURTH, accuracy)
        return [(jump.counters, [change.after for change in jump.mode_changes]) for jump in found]

    stories = [story(accuracy) for accuracy in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)]
    assert all(one == stories[0] for one in stories)
    assert any(counters["touched_during_reset"] for counters, _ in stories[0]) == (reset_time > 0.1)


@pytest.mark.parametrize(("reset_time", "thrown_m"), [(0.02, 0.095), (0.03, 0.014)])
def test_a_platform_that_overtakes_the_foot_throws_it_and_says_so(reset_time: float, thrown_m: float) -> None:
    default, thrown = jumps_of({}, 12)[-1], jumps_of({"reset_time": reset_time}, 12)[-1]
    assert thrown.counters["touched_during_reset"] == 1
    assert (thrown.apex_height_m or 0.0) - (default.apex_height_m or 0.0) == pytest.approx(thrown_m, abs=1e-3)
    assert thrown.reset_work_J > default.reset_work_J + 0.1


def test_every_jump_of_six_thousand_has_its_mode_changes() -> None:
    result = simulate(EMULATOR.changed(jumps=6000), 1e-3)
    assert len(result.jumps) == 6000
    steady = [change.after for change in result.jumps[5].mode_changes]
    assert steady[0] == "intruding"
    assert all([change.after for change in jump.mode_changes] == steady for jump in result.jumps[5:])


def test_an_overdamped_leg_is_carried_into_the_next_stance_unless_it_may_end_short_of_its_rest() -> None:
    """scenes.md 5.4: such a leg comes to its rest length only asymptotically."""
    stuck = jumps_of({"b_extension": 30.0, "rest_tolerance": 0.0}, 3)
    free = jumps_of({"b_extension": 30.0, "rest_tolerance": 0.005}, 3)
    assert stuck[-1].outcome == "no_liftoff"
    assert len(stuck) < 3
    assert [jump.outcome for jump in free] == ["touchdown"] * 3


@pytest.mark.parametrize("foot_mass", [1e-2, 1e-3, 1e-4])
def test_a_light_foot_on_a_platform_without_mass(foot_mass: float) -> None:
    found = jumps_of({"foot_mass": foot_mass}, 3, 1e-6)
    assert [jump.outcome for jump in found] == ["touchdown"] * 3
    assert max(abs(jump.energy_residual_J) for jump in found) < 2e-6
    assert found[-1].apex_height_m == pytest.approx(0.4794, abs=0.01)


def test_in_a_steady_cycle_the_leg_gives_what_the_ground_takes() -> None:
    last = jumps_of({}, 100, 1e-9)[-1]
    assert last.leg_work_J == pytest.approx(last.ground_loss_J + last.impact_loss_J - last.reset_work_J, abs=1e-8)
    assert np.isfinite(last.leg_work_J)
