"""Where sampled damping lets errors grow: goals are kept all the same, or the jump is flagged."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene

SIM2 = load_scene("sim2")
GOAL, FINEST = 1e-4, 1e-10
DRAWN = 300


def drawn() -> list[Scene]:
    """Scenes around sim2 with much active damping, light feet and slow clocks."""
    random = np.random.default_rng(2)
    return [
        SIM2.changed(
            {
                "b_ad": float(random.uniform(100.0, 1500.0)),
                "k_extension": float(random.uniform(400.0, 1600.0)),
                "foot_mass": math.exp(random.uniform(math.log(0.02), math.log(0.3))),
                "control_rate": float(random.choice([200.0, 500.0, 1000.0])),
                "initial_velocity": float(random.uniform(-2.0, -0.2)),
                "foot_radius": float(random.uniform(0.012, 0.06)),
            }
        )
        for _ in range(DRAWN)
    ]


def error(found: JumpResult, wanted: JumpResult) -> float:
    """Largest relative error of the four outputs; infinite where the jump ends otherwise."""
    if found.outcome != wanted.outcome:
        return math.inf
    each = [found.max_depth_m / wanted.max_depth_m, found.cost_J / wanted.cost_J]
    if wanted.liftoff_time_s and wanted.apex_height_m:
        each.append((found.liftoff_time_s or math.inf) / wanted.liftoff_time_s)
        each.append((found.apex_height_m or math.inf) / wanted.apex_height_m)
    return max(abs(one - 1.0) for one in each)


@functools.cache
def jumps() -> list[tuple[JumpResult, JumpResult]]:
    """Each scene's jump at the goal and at the finest accuracy."""
    return [(simulate(scene, GOAL).jump, simulate(scene, FINEST).jump) for scene in drawn()]


def test_the_goal_is_kept_wherever_it_is_not_flagged() -> None:
    """Of jumps that come to an end: the cost until a leg folds has a pole there."""
    judged = [pair for pair in jumps() if not pair[0].ill_conditioned and pair[1].outcome == "touchdown"]
    errors = [error(found, wanted) for found, wanted in judged]
    assert len(errors) > 100
    assert np.mean(np.array(errors) <= GOAL) >= 0.99


def test_where_errors_grow_by_thousands_the_scene_is_simulated_more_finely() -> None:
    """And again, where the finer jump lets them grow more: never is the work of a plain jump taken for enough."""
    grown = [found for found, _ in jumps() if found.error_growth > 1e3 and not found.ill_conditioned]
    plain = [found for found, _ in jumps() if found.error_growth < 3.0]
    assert len(grown) > 10

    def evaluations_1_s(some: list[JumpResult]) -> float:
        return float(np.median([jump.rhs_evaluations / jump.liftoff_time_s for jump in some if jump.liftoff_time_s]))

    assert evaluations_1_s(grown) > 2.0 * evaluations_1_s(plain)


HUMP = {
    "body_mass": 0.3556,
    "foot_mass": 0.036,
    "k_compression": 180.0,
    "initial_velocity": -1.8,
    "foot_radius": 0.00896,
    "mu": 0.44,
    "k_sh": 372.0,
    "sigma": 30000.0,
    "kg_scale": 1.395478066551043,
    "added_mass_constant": 0.643,
    "b_g": 7.9,
    "c_g": 0.548,
    "bg_scale": 1.03,
    "b_compression": 0.23,
    "b_ad": 500.0,
    "control_rate": 204.0,
    "force_cap": 17.0,
}
"""The lifted foot rises from its print for some microseconds, and the ground then meets it."""


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-8])
def test_a_rise_shorter_than_a_step_is_seen(accuracy: float) -> None:
    finest, found = simulate(SIM2.changed(HUMP), 1e-11).jump, simulate(SIM2.changed(HUMP), accuracy).jump
    lifted_s, touched_s = (
        next(change.time_s for change in found.mode_changes if mode == getattr(change, side) and change.time_s > 0.16)
        for side, mode in (("after", "flight"), ("before", "flight"))
    )
    assert 0.0 <= touched_s - lifted_s < 1e-4
    assert error(found, finest) < accuracy
    if accuracy < 1e-4:  # there one hop of microseconds more is within the error
        assert len(found.mode_changes) == len(finest.mode_changes)


@pytest.mark.parametrize(("b_ad", "chatters"), [(610.0, True), (5000.0, True), (1e5, False)])
def test_a_leg_that_chatters_is_flagged_and_one_too_damped_to_is_right(b_ad: float, chatters: bool) -> None:
    """From some damping on the sampled foot is stopped within each tick: errors grow no more."""
    scene = SIM2.changed({"k_extension": 1091.36, "b_ad": b_ad})
    found, finer = (simulate(scene, accuracy).jump for accuracy in (1e-6, 1e-9))
    assert found.outcome == "touchdown"
    assert (found.error_growth > 1e6) == chatters
    assert found.ill_conditioned == chatters
    assert error(found, finer) < (1e-3 if chatters else 1e-6)


def test_growth_at_a_slow_touchdown_is_multiplied_by_that_of_sampled_damping() -> None:
    """What rounding grew to before the foot touched is what each tick lets grow on."""
    chatter = {"b_ad": 600.0, "foot_mass": 0.02, "control_rate": 200.0}
    slow = {"initial_velocity": 0.0, "initial_height": 1e-5}
    both, one, other = (
        simulate(SIM2.changed(changes), GOAL).jump.error_growth for changes in (chatter | slow, chatter, slow)
    )
    assert both > 10.0 * max(one, other)
