"""The effects' declarations agree with each other, and every pair of them makes a scene or a sentence."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from typing import Any

import pytest

from simulator.compiled import Function
from simulator.declared import GROUNDS, all_parameters
from simulator.effects.effect import MODES, BodyForce, Effect, Energy
from simulator.effects.registry import EFFECTS
from simulator.kernel.composition import compose
from simulator.parameter import BASICS
from simulator.scene import Scene
from simulator.scene_file import PARTS, load_scene, shipped_scenes
from tests.helpers.scenes import is_sentence, scene_or_sentence, with_needs

ON_GROUND = {"hydrostatic_stiffness": "sim2", "rigid_ground": "force_plate", "emulated_ground": "emulator"}


def test_exclusions_and_needs_name_effects_and_exclude_each_other() -> None:
    for name, effect in EFFECTS.items():
        assert effect.name == name
        assert {*effect.excludes, *itertools.chain.from_iterable(effect.needs)} <= set(EFFECTS) - {name}
        for other, sentence in effect.excludes.items():
            assert EFFECTS[other].excludes[name] == sentence


def test_every_parameter_is_declared_once_with_a_box_that_holds_its_shipped_values() -> None:
    for one in [*BASICS, *(parameter for effect in EFFECTS.values() for parameter in effect.parameters)]:
        assert all_parameters()[one.name] is one
        assert one.part in PARTS
        assert one.unit
        assert one.meaning
        assert (one.assumed is None) != bool(one.why)
        for scene in map(load_scene, shipped_scenes()):
            value = scene.values[one.name].value if one.name in scene.values else one.assumed
            assert value is not None
            assert one.low <= value <= one.high


def test_every_pair_of_effects_is_built_or_refused_with_a_sentence() -> None:
    grounds = {ground: load_scene(name) for ground, name in ON_GROUND.items()}
    for first, second in itertools.combinations(EFFECTS, 2):
        pair = frozenset((first, second))
        results = []
        for ground, scene in grounds.items():
            on = with_needs(pair, ground)
            results.append(scene_or_sentence(scene.changed, {}, on, set(EFFECTS) - on, jumps=1))
        scenes = [result for result in results if isinstance(result, Scene)]
        assert not (scenes and second in EFFECTS[first].excludes), pair
        assert all(pair <= scene.effects for scene in scenes), pair
        for sentence in results:
            if isinstance(sentence, str):
                assert re.fullmatch(r"(\w+) and (\w+) cannot be on together, since .+: leave out .+\.", sentence)


LOSS = Energy("wind_loss", "energy lost to the wind", -1, "lost to the wind")
EVERYWHERE = BodyForce(LOSS, MODES, MODES)
WIND: dict[str, Function] = {"body_force_n": lambda p, height_m, velocity_m_s: 1.0}
WRONG: dict[str, tuple[dict[str, Any], dict[str, Function]]] = {
    "says nothing of its force": ({}, WIND),
    "gives no force": ({"body_force": EVERYWHERE}, {}),
    "holds without a guard": ({"body_force": replace(EVERYWHERE, holds=True)}, WIND),
    "has a guard and does not hold": ({"body_force": EVERYWHERE}, {**WIND, "hold_guard": WIND["body_force_n"]}),
    "breaks a closed form where it does not act": ({"body_force": BodyForce(LOSS, ("flight",), ("jammed",))}, WIND),
    "costs without a power": ({"energies": (Energy("gear", "losses of the gear", 0, "gear"),)}, {}),
    "has a power and no energy": ({}, {"gear_w": WIND["body_force_n"]}),
    "fills what another fills": ({}, {"resistance_n": WIND["body_force_n"]}),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_an_effect_leaves_unsaid_is_refused_when_a_kernel_is_built(
    wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    said, functions = WRONG[wrong]
    monkeypatch.setitem(EFFECTS, "wind", Effect("wind", "wind", "none", **said, functions=lambda at: functions))
    with pytest.raises(ValueError, match=r"^wind "):
        compose(("hydrostatic_stiffness", "wind"))
    compose(("hydrostatic_stiffness", "rail_friction"))


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_that_others_need_is_not_left_out_without_a_word(name: str) -> None:
    for scene in map(load_scene, shipped_scenes()):
        needing = {
            effect.name
            for effect in EFFECTS.values()
            for alternatives in effect.needs
            if effect.name in scene.effects and set(alternatives) & scene.effects == {name}
        }
        left = scene_or_sentence(scene.changed, effects_off=(name,))
        if isinstance(left, str):
            assert needing or name in GROUNDS
            assert is_sentence(left)
        else:
            assert name not in left.effects
            assert not needing
