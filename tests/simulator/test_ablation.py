"""What the effects of a scene are worth, and which are enough for a tolerance; nothing is compiled for it."""

from __future__ import annotations

import pytest

from data_schema.errors import UsageError
from data_schema.vocabulary import Undefined
from simulator.ablation import ablation_of_effects, tolerance_of
from simulator.jump import simulate
from simulator.scene_file import load_scene
from tests.helpers.scenes import is_sentence
from tests.helpers.wording import refuses, says

PLATE = load_scene("force_plate").changed(effects_off=["cost_of_whole_jump", "torque_cap"], jumps=12)
TOLERANCE, ACCURACY = 0.02, 1e-4


def test_each_effect_alone_and_those_that_are_enough() -> None:
    found = ablation_of_effects(PLATE, TOLERANCE, ACCURACY)
    assert {*found.alone, *found.needed} == PLATE.effects
    says(found.needed["rigid_ground"], "a ground")
    assert found.scene.jumps == len(found.full.jumps) == 10
    heat = found.alone["motor_heat"].changes["cost"]
    assert isinstance(heat, float)
    assert -1.0 < heat < -0.9
    assert all(isinstance(change, Undefined) for change in found.alone["leg_damping"].changes.values())
    without_drag = simulate(PLATE.changed(effects_off=["drag"], jumps=10), ACCURACY).jump
    drag = found.alone["drag"].changes["cost"]
    assert drag == pytest.approx(without_drag.cost_J / found.full.jump.cost_J - 1.0, abs=1e-12)

    gone = found.left_out
    assert gone.effects == ("short_leg_guard", "drag")
    assert gone.largest <= TOLERANCE
    enough = found.scene.changed(effects_off=gone.effects)
    assert {*found.enough} == enough.effects
    assert simulate(enough, found.accuracy).jumps == gone.result.jumps


@pytest.mark.parametrize(
    ("words", "accuracy", "said"),
    [
        *((words, 1e-6, "is no share above 0, to 100%") for words in ("", "%", "0", "-1%", "nan", "1", "101%")),
        ("0.01%", 1e-4, "give at least 0.1%, or --accuracy 1e-05."),
        ("1%", 0.0, "an accuracy of 0 cannot be had"),
    ],
)
def test_a_share_is_read_or_refused(words: str, accuracy: float, said: str) -> None:
    assert [tolerance_of(same, 1e-6) for same in (" 1 % ", "0.01", "1e-2", "1.0%")] == [0.01] * 4
    with refuses(UsageError, said) as refusal:
        tolerance_of(words, accuracy)
    assert is_sentence(str(refusal.value))
