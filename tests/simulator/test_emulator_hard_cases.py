"""The emulator's hard cases: its state machine's edges, its stop, a platform with no damping or hardly any give."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
import pytest

from simulator.gains import stiffness_n_m
from simulator.jump import simulate
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


def test_in_a_steady_cycle_the_leg_gives_what_the_ground_takes() -> None:
    last = jumps_of({}, 100, 1e-9)[-1]
    assert last.leg_work_J == pytest.approx(last.ground_loss_J + last.impact_loss_J - last.reset_work_J, abs=1e-8)
    assert np.isfinite(last.leg_work_J)
