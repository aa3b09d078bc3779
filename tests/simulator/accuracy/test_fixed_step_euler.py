"""The fixed-step scheme of the thesis: what it gives, how it converges, what it does not cover."""

from __future__ import annotations

import math

import pytest

from data_schema.errors import UsageError
from simulator.accuracy.fixed_step_euler import fixed_step_euler_run, why_not
from simulator.scene_file import load_scene
from tests.helpers.fixed_step_euler import Jump, fixed_step_euler_jump, outcome
from tests.helpers.kernels import interpreted
from tests.helpers.wording import refuses, says

SCENE = load_scene("sim2")
TRUE = {
    "max_depth_m": 0.0707555505702115,
    "liftoff_time_s": 0.31374130706118,
    "apex_height_m": 0.303334225186479,
    "stance_heat_J": 26.8783689454916,
    "stance_mechanical_J": 3.65279414276101,
}
"""Scene sim2 by Taylor series to 36 digits."""


COARSE_STEP_S, FINER_STEP_S = 1e-4, 3e-5
"""Of which plain Python takes the thousands that a jump has; those of the thesis are compiled, in a soak."""


@pytest.fixture(scope="module")
def coarse() -> Jump:
    return interpreted(fixed_step_euler_jump, SCENE, COARSE_STEP_S)


@pytest.fixture(scope="module")
def finer() -> Jump:
    return interpreted(fixed_step_euler_jump, SCENE, FINER_STEP_S)


def test_it_converges_to_the_truth(coarse: Jump, finer: Jump) -> None:
    assert outcome(coarse) == outcome(finer) == "apex"
    for name, true in TRUE.items():
        assert coarse[name] == pytest.approx(true, rel=0.02)
    error, smaller = (abs(jump["max_depth_m"] / TRUE["max_depth_m"] - 1.0) for jump in (coarse, finer))
    assert error / smaller == pytest.approx(COARSE_STEP_S / FINER_STEP_S, rel=0.5)  # at first order


def test_a_resting_foot_flips_the_more_often_the_finer_the_step(coarse: Jump, finer: Jump) -> None:
    assert coarse["mode_changes"] < 200
    assert finer["mode_changes"] > 2 * coarse["mode_changes"]


def test_a_robot_too_weak_to_jump_is_an_outcome() -> None:
    weak = interpreted(fixed_step_euler_jump, SCENE.changed({"force_cap": 1.0}), COARSE_STEP_S)
    assert outcome(weak) in ("no_liftoff", "leg_folded")
    assert math.isnan(weak["liftoff_time_s"])
    assert math.isnan(weak["apex_height_m"])


@pytest.mark.soak
def test_at_the_thesis_step_it_is_what_the_published_code_gives(coarse: Jump) -> None:
    at_thesis_step, compiled = fixed_step_euler_jump(SCENE), fixed_step_euler_jump(SCENE, COARSE_STEP_S)
    assert outcome(at_thesis_step) == "apex"
    assert at_thesis_step["max_depth_m"] == pytest.approx(0.0707571, abs=5e-8)
    assert at_thesis_step["mode_changes"] > 5000
    for name, true in TRUE.items():
        assert compiled[name] == pytest.approx(coarse[name], rel=1e-9)
        assert at_thesis_step[name] == pytest.approx(true, rel=2e-4)


def test_other_grounds_and_the_rail_are_refused_with_a_sentence() -> None:
    assert why_not(SCENE) is None
    says(why_not(SCENE.changed(effects_on=("rail_friction",))), "rail")
    for name in ("emulator", "force_plate"):
        with refuses(UsageError, "knows granular ground"):
            fixed_step_euler_run(load_scene(name))
