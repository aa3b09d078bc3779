"""What the effects of scenes are worth, each set simulated without compiling it."""

from __future__ import annotations

import functools
import itertools
from dataclasses import replace

import pytest

from data_schema.errors import UsageError
from data_schema.vocabulary import Undefined
from simulator.ablation.outputs import difference
from simulator.ablation.smallest import refusal
from simulator.ablation.study import (
    MEASURED_JUMPS,
    Ablation,
    ablation_of_effects,
    least_additive_pair,
    outputs_without,
    sets_to_leave_out,
)
from simulator.scene_file import load_scene
from tests.helpers.wording import refuses

SIM2 = load_scene("sim2")
PLATE = load_scene("force_plate").changed(effects_off=["cost_of_whole_jump", "short_leg_guard"], jumps=20)
SCENES = {
    "sim2": SIM2.changed(effects_off=["inertial_drag", "added_mass", "cost_of_commanded_force"]),
    "force_plate": PLATE,
}
NO_GROUND = "a scene without a ground has nothing to jump on"


@functools.cache
def measured(scene: str, tolerance: float) -> Ablation:
    return ablation_of_effects(SCENES[scene], tolerance)


CASES = [("sim2", 0.01), pytest.param("force_plate", 0.02, marks=pytest.mark.soak)]
given_cases = pytest.mark.parametrize(("scene", "tolerance"), CASES)


@given_cases
def test_the_smallest_set_stays_within_the_tolerance_and_no_effect_of_it_can_go(scene: str, tolerance: float) -> None:
    ablation = measured(scene, tolerance)
    enough = ablation.scene.changed(effects_off=ablation.smallest.left_out.effects)
    assert enough.effects == set(ablation.smallest.effects)
    outputs = outputs_without(enough, ablation.accuracy)
    assert ablation.smallest.left_out.effects
    assert difference(outputs(frozenset()), ablation.full).within(tolerance)
    for name in enough.effects:
        if refusal(enough, frozenset({name})) is None:
            assert not difference(outputs(frozenset({name})), ablation.full).within(tolerance), name


@given_cases
def test_every_effect_and_pair_that_may_go_was_left_out(scene: str, tolerance: float) -> None:
    ablation = measured(scene, tolerance)
    assert set(ablation.alone) | set(ablation.needed) == ablation.scene.effects
    assert not set(ablation.alone) & set(ablation.needed)
    assert any(sentence.startswith(NO_GROUND) for sentence in ablation.needed.values())
    for first, second in itertools.combinations(ablation.scene.effects, 2):
        may_go = refusal(ablation.scene, frozenset({first, second})) is None
        assert ((first, second) in ablation.pairs) == may_go
        if may_go:
            assert ablation.pairs[first, second] == ablation.pairs[second, first]
            assert set(ablation.pairs[first, second].effects) == {first, second}


def test_a_jump_of_very_many_steps_is_given_up() -> None:
    outputs = outputs_without(SIM2, 1e-6, steps_more=1)
    full, slower = outputs(frozenset()), outputs(frozenset({"leg_damping"}))
    quicker = outputs(frozenset({"inertial_drag"}))
    assert (full.outcome, slower.outcome, quicker.outcome) == ("touchdown", "step_limit", "touchdown")
    assert slower.most_steps == full.most_steps > quicker.most_steps
    assert not difference(slower, full).within(1.0)


def test_a_scene_that_does_not_jump_is_refused_at_once() -> None:
    """Without its clock this one chatters for two million steps."""
    told: list[str] = []
    with refuses(UsageError, "1", "no_liftoff"):
        ablation_of_effects(SIM2.changed({"k_extension": 100.0}), 0.01, step=told.append)
    assert not told


def test_effects_of_the_cost_alone_change_nothing_else() -> None:
    heat = measured("sim2", 0.01).alone["motor_heat"]
    assert not isinstance(heat.difference.cost, Undefined)
    assert heat.difference.cost < -0.8
    for change in (heat.difference.apex, heat.difference.depth):
        assert not isinstance(change, Undefined)
        assert abs(change) < 1e-5


def test_an_effect_that_does_nothing_can_always_go() -> None:
    ablation = measured("sim2", 0.01)
    assert SIM2["b_ad"] == 0.0
    assert ablation.alone["active_damping"].difference.largest < ablation.accuracy
    assert {"active_damping", "short_leg_guard"} <= set(ablation.smallest.left_out.effects)


def test_a_jump_that_ends_otherwise_is_never_within() -> None:
    damping = measured("force_plate", 0.02).alone["leg_damping"]
    assert damping.outputs.outcome == "leg_straight"
    assert isinstance(damping.difference.cost, Undefined)
    assert "leg_damping" in measured("force_plate", 0.02).smallest.effects


def test_of_many_jumps_the_tenth_is_looked_at_and_the_last_too() -> None:
    ablation = measured("force_plate", 0.02)
    assert PLATE.jumps > MEASURED_JUMPS
    assert ablation.scene == PLATE.changed(jumps=MEASURED_JUMPS)
    assert ablation.full.jumps == MEASURED_JUMPS
    assert ablation.checked.outputs.jumps == PLATE.jumps
    assert ablation.checked.effects == ablation.smallest.left_out.effects
    assert ablation.checked.difference.within(ablation.tolerance)
    assert ablation.searched_within == ablation.tolerance


@pytest.mark.soak
def test_a_difference_that_grows_beyond_the_tolerance_is_not_let_pass() -> None:
    ablation = ablation_of_effects(PLATE, 0.0226)
    both = ablation.pairs["torque_cap", "drag"].difference
    assert both.within(0.0226)  # the tenth jump; their changes cancel in part
    assert ablation.searched_within == 0.0226 / 2
    assert ablation.smallest.left_out.effects == ()
    assert ablation.checked.difference.within(ablation.tolerance)


def test_effects_that_work_on_each_other_are_named() -> None:
    ablation = measured("sim2", 0.01)
    both = least_additive_pair(ablation, "constant_force_cap")
    assert both is not None
    pair = ablation.pairs["constant_force_cap", both.partner].difference
    assert both.change in pair.changes
    assert both.surprise > 0.1 * ablation.tolerance
    assert least_additive_pair(ablation, "hydrostatic_stiffness") is None
    assert least_additive_pair(replace(ablation, tolerance=100.0), "constant_force_cap") is None


def test_every_step_is_told() -> None:
    scene = PLATE.changed(effects_off=["torque_cap", "drag"], jumps=1)
    told: list[str] = []
    ablation_of_effects(scene, 0.01, step=told.append)
    assert len(told) == len(sets_to_leave_out(scene)) + 1
    assert "without motor_heat" in told
