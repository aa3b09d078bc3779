"""Every pair of effects that may be on together runs, and an effect that is off publishes zeros."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import fields

import pytest

import simulator.jump
from simulator.effects.registry import EFFECTS
from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted
from tests.helpers.scenes import scene_or_sentence, with_needs

ACCURACY = 1e-4
MOST_RESIDUAL_J = 5e-4
"""What the energy book may lack at this accuracy, of about 5 J that the book turns over."""
SHORTEST_JUMP_S = 0.1
"""A robot that has left the ground to jump is not back sooner."""
MOST_STEPS = 20_000
"""Interpreted, the usual limit would take minutes to reach."""
ON_GROUND = {"hydrostatic_stiffness": "sim2", "rigid_ground": "force_plate", "emulated_ground": "emulator"}
PAIRS = list(itertools.combinations(EFFECTS, 2))
PUBLISHED = {name for effect in EFFECTS.values() for name in effect.outputs}
Found = dict[tuple[str, str], tuple[frozenset[str], tuple[JumpResult, ...]]]


def with_less_damping(scene: Scene) -> Scene:
    """Shipped scenes have none or much; beside few other effects much of it makes a leg chatter."""
    return scene.changed({"b_ad": 60.0}) if "b_ad" in scene.read else scene


def alone(first: str, second: str) -> Scene | None:
    """A scene of nothing but these two, what they need, and the first ground that allows them."""
    for ground, name in ON_GROUND.items():
        on = with_needs(frozenset((first, second)), ground)
        found = scene_or_sentence(load_scene(name).changed, {}, on, set(EFFECTS) - on, jumps=1)
        if isinstance(found, Scene):
            return with_less_damping(found)
    return None


def in_shipped_scenes(first: str, second: str) -> Scene | None:
    """The first shipped scene that can have both beside its own effects, with two jumps where it jumps on."""
    for name in ("sim2", "emulator", "force_plate", "bed", "sim1"):
        shipped = load_scene(name)
        found = scene_or_sentence(shipped.changed, {}, (first, second), jumps=min(shipped.jumps, 2))
        if isinstance(found, Scene):
            return with_less_damping(found)
    return None


def run_pairs(make: Callable[[str, str], Scene | None], every: int = 1) -> Found:
    """The jumps of every pair of which there is a scene, with the effects that it has; or of every nth pair."""
    simulator.jump.MOST_STEPS_A_JUMP = MOST_STEPS
    scenes = {pair: make(*pair) for pair in PAIRS[::every]}
    return {pair: (scene.effects, simulate(scene, ACCURACY).jumps) for pair, scene in scenes.items() if scene}


def faults(effects: frozenset[str], jump: JumpResult) -> list[str]:
    """What is wrong with a jump."""
    numbers = {one.name: getattr(jump, one.name) for one in fields(jump)}
    found = [name for name, value in numbers.items() if isinstance(value, float) and not math.isfinite(value)]
    if jump.outcome in ("step_limit", "timeout"):
        found.append(jump.outcome)
    if abs(jump.energy_residual_J) > MOST_RESIDUAL_J:
        found.append(f"energy residual {jump.energy_residual_J}")
    if jump.outcome == "touchdown":
        times_s = [time for time in (jump.liftoff_time_s, jump.apex_time_s, jump.next_touchdown_time_s) if time]
        if len(times_s) < 3 or times_s != sorted(times_s) or times_s[-1] < SHORTEST_JUMP_S:
            found.append(f"times {times_s}")
    on = {name for effect in effects for name in EFFECTS[effect].outputs}
    return found + [name for name in PUBLISHED - on if numbers[name] != 0.0]


def assert_sound(found: Found) -> None:
    wrong = {pair: [faults(effects, jump) for jump in jumps] for pair, (effects, jumps) in found.items()}
    assert {pair: each for pair, each in wrong.items() if any(each)} == {}


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.soak)])
def test_every_pair_alone_runs_and_what_is_off_reads_zero(every: int) -> None:
    found = interpreted(run_pairs, alone, every)
    assert len(found) > 300 // every
    assert {name for effects, _ in found.values() for name in effects} == set(EFFECTS)
    assert_sound(found)


@pytest.mark.soak
def test_every_pair_in_a_shipped_scene_runs() -> None:
    found = interpreted(run_pairs, in_shipped_scenes)
    assert len(found) > 250
    assert_sound(found)
