"""Hard cases: a jump that ends, in bounded work, with its energy book closed and an outcome that has a name."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from simulator.error_bars import simulate_with_errors
from simulator.jump import simulate
from simulator.parameter import GRAVITY_M_S2
from simulator.result import JumpResult
from simulator.scene_file import load_scene

FEW_STEPS = 40_000


def _jump(name: str = "sim2", /, accuracy: float = 1e-6, **changes: float) -> JumpResult:
    return simulate(load_scene(name).changed(changes), accuracy).jump


def _closes(jump: JumpResult, accuracy: float = 1e-6) -> None:
    """Measured: 4e-8 of what is turned over, at accuracy 1e-6."""
    assert abs(jump.energy_residual_J) < 0.1 * accuracy * (abs(jump.leg_work_J) + jump.ground_loss_J)
    assert jump.steps < FEW_STEPS


@pytest.mark.parametrize("kg_scale", [0.1, 1.0, 1e2, 1e4, 1e6, 1e8])
def test_ground_from_soft_to_a_hundred_million_times_as_stiff(kg_scale: float) -> None:
    jump = _jump(kg_scale=kg_scale)
    assert jump.outcome == "touchdown"
    _closes(jump)


@pytest.mark.parametrize("kg_scale", [1e2, 1e4, 1e6, 1e8])
def test_the_depth_in_stiff_ground_is_that_of_all_accuracies(kg_scale: float) -> None:
    coarse, fine = (_jump(accuracy=accuracy, kg_scale=kg_scale) for accuracy in (1e-4, 1e-9))
    assert coarse.max_depth_m == pytest.approx(fine.max_depth_m, rel=1e-4)


@pytest.mark.parametrize("kg_scale", [1e4, 1e6, 1e8])
def test_an_intrusion_that_begins_and_ends_inside_one_step(kg_scale: float) -> None:
    """On stiff ground the foot is stopped by a linear spring, in a quarter of its period; steps before and after are a
    hundred times as long.
    """
    scene, jump = load_scene("sim2"), _jump(accuracy=1e-9, kg_scale=kg_scale)
    first, second = jump.mode_changes[:2]
    area_m2, cone = math.pi * scene["foot_radius"] ** 2, math.cos(scene["cone_angle"])
    stiffness_n_m = kg_scale * (scene["k_sh"] + scene["sigma"] * area_m2 / cone)
    omega = math.sqrt(stiffness_n_m / scene["foot_mass"])
    assert (first.after, second.after) == ("intruding", "jammed")
    assert second.time_s == pytest.approx(0.5 * math.pi / omega, rel=0.05)
    assert jump.max_depth_m == pytest.approx(-scene["initial_velocity"] / omega, rel=0.1)
    assert second.time_s < 2e-4
    assert jump.next_touchdown_time_s is not None
    assert jump.next_touchdown_time_s / jump.steps > 5.0 * second.time_s


def test_ground_that_grows_stiffer_tends_to_a_limit() -> None:
    times = [_jump(kg_scale=10.0**power).liftoff_time_s or 0.0 for power in (4, 5, 6, 7, 8)]
    changes = np.abs(np.diff(times))
    assert all(later < earlier for earlier, later in pairwise(changes))
    assert changes[-1] < 2e-6


@pytest.mark.parametrize("foot_mass", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
def test_a_foot_down_to_a_milligram(foot_mass: float) -> None:
    jump = _jump(foot_mass=foot_mass)
    assert jump.outcome == "touchdown"
    _closes(jump)


def test_a_lighter_foot_tends_to_a_limit() -> None:
    apexes = [_jump(foot_mass=10.0**power).apex_height_m or 0.0 for power in (-3, -4, -5, -6)]
    assert all(abs(later) < 0.2 * abs(earlier) for earlier, later in pairwise(np.diff(apexes)))


def test_micro_intrusions_on_stiff_ground_under_a_rising_force() -> None:
    resolved = _jump(kg_scale=1e5, initial_velocity=0.0)
    assert len(resolved.mode_changes) > 100
    assert resolved.outcome == "touchdown"
    _closes(resolved)


def test_creeping_takes_the_place_of_ringing_that_the_accuracy_does_not_see() -> None:
    """The finer the accuracy, the longer the foot is followed through micro-intrusions, each ending where its speed
    but touches 0.
    """
    crept = _jump(accuracy=1e-4, kg_scale=1e8, initial_velocity=0.0)
    rung = _jump(accuracy=1e-6, kg_scale=1e8, initial_velocity=0.0)

    def creeps_from_s(jump: JumpResult) -> float:
        return next(change.time_s for change in jump.mode_changes if change.after == "creeping")

    assert creeps_from_s(crept) < 0.25 * creeps_from_s(rung)
    assert len(crept.mode_changes) < 30
    assert rung.steps > 100_000
    assert crept.steps * 1000 < rung.steps
    assert crept.max_depth_m == pytest.approx(rung.max_depth_m, rel=1e-5)
    assert crept.cost_J == pytest.approx(rung.cost_J, rel=4e-5)


@pytest.mark.soak
def test_a_creeping_foot_settles_where_the_body_held_back_by_its_rail_lets_the_force_rise_no_more() -> None:
    scene = load_scene("sim2").changed(
        {"kg_scale": 1e8, "initial_velocity": 0.0, "rail_friction_force": 9.0}, ("rail_friction",)
    )
    crept, rung = (simulate(scene, accuracy).jump for accuracy in (1e-4, 1e-6))
    assert "jammed" in [change.after for change in crept.mode_changes if change.before == "creeping"]
    assert crept.steps * 1000 < rung.steps
    assert crept.max_depth_m == pytest.approx(rung.max_depth_m, rel=2e-5)


def test_start_at_rest_on_the_surface() -> None:
    at_rest, almost = _jump(initial_velocity=0.0), _jump(initial_velocity=-1e-9)
    assert at_rest.outcome == "touchdown"
    assert at_rest.apex_height_m == pytest.approx(almost.apex_height_m, rel=1e-6)
    assert len(at_rest.mode_changes) < 10
    _closes(at_rest)


def test_an_event_on_a_tick() -> None:
    """The mass that jams the foot on a tick exactly: a little less and a little more give the same jump."""
    jam = next(c.time_s for c in _jump(accuracy=1e-10).mode_changes if c.after == "jammed")
    rate = 270 / jam  # the 270th tick at that instant
    before, at, after = (_jump(accuracy=1e-9, control_rate=rate * factor) for factor in (1 - 1e-9, 1.0, 1 + 1e-9))
    assert at.outcome == before.outcome == after.outcome == "touchdown"
    assert at.cost_J == pytest.approx(before.cost_J, rel=2e-9)
    assert at.cost_J == pytest.approx(after.cost_J, rel=2e-9)


@pytest.mark.parametrize(
    ("changes", "outcome"),
    [
        ({"initial_velocity": -5.0}, "leg_folded"),
        ({"b_extension": 1e4}, "no_liftoff"),
        ({"k_compression": 1.0}, "leg_folded"),
    ],
)
def test_what_cannot_jump_has_a_named_outcome(changes: dict[str, float], outcome: str) -> None:
    jump = _jump(**changes)
    assert jump.outcome == outcome
    assert jump.apex_height_m is None
    assert np.isfinite(jump.cost_J)


@pytest.mark.parametrize(
    ("changes", "outcome", "jumps"),
    [
        ({"k_extension": 323.36, "k_compression": 180.0}, "no_liftoff", 1),
        ({"k_extension": 323.36, "k_compression": 160.0}, "carried", 1),
        ({"k_extension": 567.36 / 4.3}, "no_liftoff", None),
        ({"shortest_hold": 2.0}, "leg_folded", None),
        ({"reset_time": 0.02}, "touchdown", 100),
        ({"release_time": 0.0}, "touchdown", 100),
    ],
)
def test_the_emulators_ways_to_fail(changes: dict[str, float], outcome: str, jumps: int | None) -> None:
    result = simulate(load_scene("emulator").changed(changes))
    assert result.jump.outcome == outcome
    assert jumps is None or len(result.jumps) == jumps


def test_a_leg_too_short_for_the_plates_gains_straightens() -> None:
    published = {"k_extension": 650.0, "k_compression": 250.0, "b_compression": 0.5, "b_extension": 5.0}
    assert _jump("force_plate", **published).outcome == "leg_straight"


@pytest.mark.parametrize("many", [1000, pytest.param(10_000, marks=pytest.mark.soak)])
def test_many_jumps_in_a_row_do_not_drift(many: int) -> None:
    result = simulate(load_scene("emulator").changed(jumps=many), 1e-9)
    apexes = np.array([jump.apex_height_m for jump in result.jumps])
    assert len(apexes) == many
    assert abs(apexes[-1] - apexes[99]) < 1e-9
    assert max(abs(jump.energy_residual_J) for jump in result.jumps) < 1e-7
    assert max(jump.max_depth_m for jump in result.jumps) <= 0.07


GRAZES_FROM_M = (1e-6, 1e-10, 1e-14, 1e-16, 5e-20)
"""Heights of a drop: the foot meets the ground at 4 mm/s down to 1e-9 m/s."""
MET = ("liftoff_time_s", "apex_height_m", "cost_J")


@pytest.mark.parametrize("name", ["bed", "force_plate", "emulator"])
def test_contact_is_met_however_slow_the_foot_is(name: str) -> None:
    """As a jump that starts on the ground with the speed of that drop, or rounding of heights is told."""
    scene = load_scene(name)
    for height_m in GRAZES_FROM_M:
        speed_m_s = -math.sqrt(2.0 * GRAVITY_M_S2 * height_m)
        on_ground = scene.changed({"initial_height": 0.0, "initial_velocity": speed_m_s}, jumps=1)
        dropped = scene.changed({"initial_height": height_m, "initial_velocity": 0.0}, jumps=1)
        wanted = simulate(on_ground, 1e-11).jump
        for accuracy in (1e-4, 1e-6, 1e-7, 1e-10):
            jump = simulate_with_errors(dropped, accuracy).jump
            errors = [abs(getattr(jump, one) / getattr(wanted, one) - 1.0) for one in MET]
            assert jump.ill_conditioned if accuracy == 1e-10 and height_m < 1e-13 else max(errors) < accuracy
            assert accuracy < 1e-9 or not jump.ill_conditioned
