"""Golden values: the stored reference of at least thirty digits, which holds the numbers printed for each scene."""

from __future__ import annotations

import pytest

from simulator.jump import simulate
from simulator.scene_file import load_scene
from tests.helpers.kernels import CASES, errors, interpreted, reference, relative_error, scene_of, spent_j

GROWN = ("sim1", "b_AD = 650")
"""Here sampled damping lets rounding grow: no step is fine enough for more than four digits."""
EFFECTS_AS_SHIPPED = [key for key in CASES if scene_of(*key).effects == load_scene(key[0]).effects]
OTHER_EFFECTS = [key for key in CASES if key not in EFFECTS_AS_SHIPPED]
WELL_CONDITIONED = [key for key in EFFECTS_AS_SHIPPED if key != GROWN]


def worst_errors(keys: list[tuple[str, str]], accuracy: float) -> dict[tuple[str, str], dict[str, float]]:
    """Of each case the largest errors of its outputs over its jumps."""
    found: dict[tuple[str, str], dict[str, float]] = {}
    for key in keys:
        scene, wanted = scene_of(*key), reference(*key)
        jumps = simulate(scene, accuracy).jumps
        assert len(jumps) == len(wanted)
        each = [errors(scene, jump, stored) for jump, stored in zip(jumps, wanted, strict=True)]
        found[key] = {name: max(error[name] for error in each) for name in each[0]}
    return found


@pytest.mark.parametrize(("accuracy", "goal"), [(1e-9, 1e-9), (1e-6, 1e-6), (1e-3, 1e-3)])
@pytest.mark.parametrize("key", WELL_CONDITIONED, ids=", ".join)
def test_a_stored_case_is_met_within_the_accuracy(key: tuple[str, str], accuracy: float, goal: float) -> None:
    for name, error in worst_errors([key], accuracy)[key].items():
        assert error < goal, name


def test_cases_with_other_effects_are_met_within_the_accuracy() -> None:
    for key, found in interpreted(worst_errors, OTHER_EFFECTS, 1e-9).items():
        assert max(found.values()) < 1e-9, (key, found)


def test_where_sampled_damping_lets_rounding_grow_the_jump_is_flagged_and_near() -> None:
    scene = scene_of(*GROWN)
    jump = simulate(scene, 1e-9).jump
    assert jump.ill_conditioned
    assert jump.error_growth > 1e9
    assert max(errors(scene, jump, reference(*GROWN)[0]).values()) < 1e-4
    assert not simulate(scene_of("sim1", "defaults"), 1e-9).jump.ill_conditioned


@pytest.mark.parametrize("key", WELL_CONDITIONED, ids=", ".join)
def test_heat_work_and_touchdowns_are_those_of_the_stored_jumps(key: tuple[str, str]) -> None:
    """What is printed of them, the stored jumps are held to in `test_storage`."""
    scene = scene_of(*key)
    for jump, wanted in zip(simulate(scene, 1e-9).jumps, reference(*key), strict=True):
        found_j = spent_j(jump, whole_jump="cost_of_whole_jump" in scene.effects)
        assert max(map(relative_error, found_j, (wanted.heat_j, wanted.mechanical_j))) < 1e-7
        if scene.jumps > 1:
            assert relative_error(jump.next_touchdown_time_s, wanted.duration_s) < 1e-7
