"""Kernels in lanes: the bits of the scalar kernel, whatever the scenes beside, their order and the number of lanes."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.compiled import Row
from simulator.jump import parameter_row
from simulator.kernel.build import kernel_for, why_no_lanes
from simulator.kernel.composition import compose
from simulator.kernel.lanes.pool import LANES, make_batch_in_lanes
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.sweep.chunks import FEWEST_IN_LANES, recipe_for, simulate_rows, why_scalar
from tests.helpers.kernels import batch_rows
from tests.helpers.random_scenes import drawn
from tests.helpers.sweeps import grid_sweep, sobol_sweep

SCENE = load_scene("sim2")
FEW_STEPS = 20_000


def table_of(scene: Scene, count: int, seed: int) -> Row:
    """Parameters of scenes from the whole legal box."""
    kernel = kernel_for(scene.effects)
    return np.array([parameter_row(kernel, each) for each in drawn(scene, count, np.random.default_rng(seed))[0]])


def assert_same_bits(scene: Scene, table: Row, accuracy: float, jumps: int = 1) -> Row:
    """Compare a kernel in lanes with the scalar one; return the latter's rows."""
    scalar, in_lanes = (kernel_for(scene.effects, lanes=lanes).batch for lanes in (False, True))
    rows, counts = batch_rows(scalar, table, accuracy, jumps, FEW_STEPS)
    beside, counts_beside = batch_rows(in_lanes, table, accuracy, jumps, FEW_STEPS)
    assert np.array_equal(counts, counts_beside)
    different = ~((rows == beside) | (np.isnan(rows) & np.isnan(beside)))
    assert not different.any(), {name: int(different[:, :, place].sum()) for place, name in enumerate(COLUMNS)}
    return rows


@pytest.mark.parametrize("accuracy", [1e-4, *(pytest.param(goal, marks=pytest.mark.soak) for goal in (1e-3, 1e-6))])
def test_scenes_from_the_whole_box_have_the_bits_of_the_scalar_kernel(accuracy: float) -> None:
    rows = assert_same_bits(SCENE, table_of(SCENE, 600, int(-np.log10(accuracy))), accuracy)
    ended = {OUTCOMES[int(outcome)] for outcome in rows[:, 0, COLUMN["outcome"]]}
    assert {"touchdown", "no_liftoff", "leg_folded", "leg_straight", "step_limit"} <= ended
    assert (rows[:, 0, COLUMN["repeats"]] > 0).any()


@pytest.mark.parametrize("name", ["sim2", "bed", pytest.param("sim1", marks=pytest.mark.soak)])
def test_ticks_that_are_passed_unseen_would_have_changed_nothing(name: str) -> None:
    """A kernel that is to turn a decision round looks at every tick; the one named here never comes."""
    scene, never = load_scene(name), 1e9
    table, batch = table_of(scene, 300, 9), kernel_for(scene.effects).batch
    noted = 0
    for accuracy in (1e-2, 1e-4, 1e-8):
        rows, _ = batch_rows(batch, table, accuracy, 1, FEW_STEPS)
        seen, _ = batch_rows(batch, table, accuracy, 1, FEW_STEPS, flip_tick=never)
        assert np.array_equal(rows, seen, equal_nan=True)
        noted += int(np.isfinite(rows[:, 0, COLUMN["decision_margin"]]).sum())
    assert noted > 0


@pytest.mark.soak
@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_a_hundred_thousand_scenes_have_the_bits_of_the_scalar_kernel(accuracy: float) -> None:
    for seed in range(100, 120):
        assert_same_bits(SCENE, table_of(SCENE, 5000, seed), accuracy)


def test_several_jumps_have_the_bits_of_the_scalar_kernel() -> None:
    rows = assert_same_bits(SCENE, table_of(SCENE, 100, 5), 1e-3, jumps=3)
    assert np.isfinite(rows[:, 2, COLUMN["outcome"]]).any()


def test_neither_neighbours_nor_their_order_change_a_bit() -> None:
    table, batch = table_of(SCENE, 200, 6), kernel_for(SCENE.effects, lanes=True).batch
    order = np.random.default_rng(0).permutation(len(table))
    parts = table, table[order], table[: LANES - 1]
    whole, shuffled, some = (batch_rows(batch, part, 1e-4, 1, FEW_STEPS)[0] for part in parts)
    assert np.array_equal(whole[order], shuffled, equal_nan=True)
    assert np.array_equal(whole[: LANES - 1], some, equal_nan=True)


@pytest.mark.soak
@pytest.mark.parametrize("lanes", [2, 4, 16])
def test_any_number_of_lanes_gives_the_same_bits(lanes: int) -> None:
    table = table_of(SCENE, 300, 7)
    batches = make_batch_in_lanes(compose(SCENE.effects), lanes), kernel_for(SCENE.effects).batch
    assert np.array_equal(*(batch_rows(batch, table, 1e-4, 1, FEW_STEPS)[0] for batch in batches), equal_nan=True)


OTHERS = {
    "torque cap": (
        {"torque_cap", "drag", "cost_of_whole_jump", "passive_draw"},
        {"constant_force_cap", "cost_of_commanded_force"},
    ),
    "contact at the print": (set(), {"contact_once_risen", "held_gains_in_flight", "added_mass"}),
}


@pytest.mark.soak
@pytest.mark.parametrize("name", OTHERS)
def test_other_effects_have_the_bits_of_the_scalar_kernel(name: str) -> None:
    on, off = OTHERS[name]
    scene = SCENE.changed({}, on, off)
    assert why_no_lanes(scene.effects) is None
    assert_same_bits(scene, table_of(scene, 1000, 8), 1e-4)


def test_a_large_sweep_is_in_lanes_and_a_small_one_says_why_it_is_not() -> None:
    kernel_for(SCENE.effects, lanes=True)
    small, large = sobol_sweep(64), sobol_sweep(FEWEST_IN_LANES)
    assert why_scalar(large.scene, large.design) is None
    assert str(FEWEST_IN_LANES) in str(why_scalar(small.scene, small.design))
    latched = grid_sweep(f"b_ad=0:100:{FEWEST_IN_LANES}", scene=load_scene("bed"))
    assert "latched_switching" in str(why_scalar(latched.scene, latched.design))
    recipes = [recipe_for(sweep.scene, sweep.design, sweep.accuracy) for sweep in (small, large)]
    assert [recipe.why_scalar is None for recipe in recipes] == [False, True]
    blocks = [simulate_rows(recipe, large.design.rows(0, 64)) for recipe in recipes]
    assert np.array_equal(blocks[0], blocks[1], equal_nan=True)
