"""A chunk's numbers: those of single simulations, bit for bit, whoever its neighbours are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from data_schema.errors import UsageError
from simulator.error_bars import simulate_with_errors
from simulator.jump import simulate
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.limits import MOST_STEPS, REPEATS
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.sweep.chunks import ERRORS, OUTPUTS, PLACE, Recipe, recipe_for, simulate_rows
from simulator.sweep.design import Design
from simulator.sweep.sweep import Sweep
from tests.helpers.kernels import interpreted
from tests.helpers.sweeps import grid_sweep, sobol_sweep
from tests.helpers.wording import refuses


def recipe_of(sweep: Sweep) -> Recipe:
    return recipe_for(sweep.scene, sweep.design, sweep.accuracy)


def as_row(jump: JumpResult) -> dict[str, float]:
    """A jump's numbers as a sweep stores them; the time of the jump and its mode changes are not in the result."""
    numbers = {output.name: getattr(jump, output.name, None) for output in OUTPUTS} | jump.counters
    numbers["outcome"] = OUTCOMES.index(jump.outcome)
    numbers["decision_margin"] = math.inf if jump.decision_margin is None else jump.decision_margin
    numbers["decision_tick"] = -1 if jump.decision_tick is None else jump.decision_tick
    rest = {"jump_time_s", "mode_changes"}
    return {name: math.nan if value is None else value for name, value in numbers.items() if name not in rest}


def assert_same_jump(row: np.ndarray, jump: JumpResult) -> None:
    expected = as_row(jump)
    found = {name: row[PLACE[name]] for name in expected}
    assert np.array_equal(list(found.values()), list(expected.values()), equal_nan=True), (found, expected)


def test_the_numbers_are_those_of_single_simulations() -> None:
    """Among them is one whose body gets under the surface, and is marked."""
    sweep = grid_sweep("kg_scale=1,1.95", "k_extension=600,5254", "foot_radius=0.0073,0.038", accuracy=1e-6)
    block = simulate_rows(recipe_of(sweep), sweep.design.rows(0, 8))
    assert block.shape == (8, 1, len(OUTPUTS))
    for row, values in zip(block[:, 0], sweep.design.rows(0, 8).tolist(), strict=True):
        scene = sweep.scene.changed(dict(zip(("kg_scale", "k_extension", "foot_radius"), values, strict=True)))
        assert_same_jump(row, simulate(scene, 1e-6).jump)
    assert set(block[:, 0, PLACE["under_surface"]]) == {0.0, 1.0}


def simulated_again(limits: Mapping[int, float]) -> dict[str, float]:
    """The outputs of a scene of which the energy book does not close at the first run."""
    values = {"body_mass": 0.07638, "foot_mass": 0.0008137, "kg_scale": 3018.0, "force_cap": 2.068e5}
    recipe = recipe_for(load_scene("sim2").changed(values), Design(()), 1e-6)
    for place, limit in limits.items():
        recipe.limits[place] = limit
    return dict(zip(PLACE, simulate_rows(recipe, np.zeros((1, 0)))[0, 0].tolist(), strict=True))


def test_what_is_simulated_again_says_so_and_whether_that_was_enough() -> None:
    closed, unclosed = simulated_again({}), simulated_again({REPEATS: 0})
    assert (unclosed["repeats"], unclosed["open_book"]) == (0, 1)
    assert (closed["repeats"], closed["open_book"]) == (1, 0)
    assert closed["steps"] > unclosed["steps"]
    too_many = simulated_again({MOST_STEPS: unclosed["steps"] + 1})
    assert OUTCOMES[int(too_many["outcome"])] == "step_limit"
    assert too_many["repeats"] > 0


def test_scenes_with_several_jumps_and_with_jumps_that_are_not_made() -> None:
    scene = load_scene("emulator").changed({}, jumps=3)
    sweep = grid_sweep("k_extension=20,200,1000", scene=scene)
    block = simulate_rows(recipe_of(sweep), sweep.design.rows(0, 3))
    assert block[:, :, PLACE["outcome"]].tolist() == [[4, -1, -1], [3, -1, -1], [2, 2, 2]]
    for rows, stiffness in zip(block, (20.0, 200.0, 1000.0), strict=True):
        jumps = simulate(scene.changed({"k_extension": stiffness}), sweep.accuracy).jumps
        for row, jump in zip(rows, jumps, strict=False):
            assert_same_jump(row, jump)
        for output, number in zip(OUTPUTS, rows[len(jumps) :].T, strict=True):
            assert np.isnan(number).all() if output.kind == "f8" else (number == -1).all()


def assert_same_errors(row: np.ndarray, jump: JumpResult) -> None:
    assert_same_jump(row, jump)
    assert jump.errors is not None
    for error, number in zip(ERRORS, row[len(OUTPUTS) :], strict=True):
        name = error.name.removesuffix("_error")
        if name != "jump_time_s":  # which a result does not have
            assert number == jump.errors.get(name, number) or math.isnan(number), name
            assert math.isnan(number) == (name not in jump.errors), name


ON_EDGE = {"k_compression": 437.7, "k_extension": 1091.0, "b_compression": 2.707, "b_extension": 16.27}
"""With soft gains in flight: scenes of which some end otherwise when they are simulated finer."""


def flags_with_errors_alike(scene: Scene, over: str, accuracy: float) -> set[bool]:
    """Compare a sweep's rows with single simulations; return which of both flags their jumps have."""
    sweep = grid_sweep(over, scene=scene, accuracy=accuracy, error_bars=True)
    rows = sweep.design.rows(0, sweep.design.row_count)
    recipe = recipe_for(scene, sweep.design, accuracy, error_bars=True)
    block = simulate_rows(recipe, rows)
    assert block.shape[-1] == len(sweep.outputs) == len(OUTPUTS) + len(ERRORS)
    flagged = set()
    for found, values in zip(block, rows.tolist(), strict=True):
        changed = scene.changed(dict(zip([axis.parameter for axis in sweep.design.axes], values, strict=True)))
        jumps = simulate_with_errors(changed, accuracy).jumps
        flagged |= {jump.ill_conditioned for jump in jumps}
        for row, jump in zip(found, jumps, strict=False):
            assert_same_errors(row, jump)
        assert np.isnan(found[len(jumps) :, len(OUTPUTS) :]).all()
    return flagged


def test_error_bars_are_those_of_single_simulations_jump_by_jump() -> None:
    emulator = load_scene("emulator").changed({}, jumps=3)
    flagged = flags_with_errors_alike(load_scene("sim2"), "foot_radius=0.02,0.038", 1e-6)
    flagged |= flags_with_errors_alike(load_scene("sim1"), "b_ad=0,650", 1e-9)
    flagged |= flags_with_errors_alike(emulator, "k_extension=20,200,1000", 1e-4)
    soft = load_scene("sim2").changed(ON_EDGE, effects_off=["held_gains_in_flight"])  # no shipped scene's effects
    flagged |= interpreted(flags_with_errors_alike, soft, "b_ad=0,1e4,1e5", 1e-1)
    assert flagged == {False, True}


def test_the_passive_draw_is_each_row_s_own_and_all_of_it_runs_uncompiled() -> None:
    scene = load_scene("sim2").changed({}, effects_on=["passive_draw"])
    sweep = grid_sweep("passive_power=5,10", scene=scene, accuracy=1e-2)
    block = interpreted(simulate_rows, recipe_of(sweep), sweep.design.rows(0, 2))
    for row, power_w in zip(block[:, 0], (5.0, 10.0), strict=True):
        jump = interpreted(simulate, scene.changed({"passive_power": power_w}), 1e-2).jump
        assert jump.passive_J == power_w * row[PLACE["jump_time_s"]] > 0
        assert (row[PLACE["passive_J"]], row[PLACE["cost_J"]]) == (jump.passive_J, jump.cost_J)


def test_a_row_does_not_depend_on_its_neighbours() -> None:
    sweep = sobol_sweep(64, "b_ad=0:300", "foot_radius=0.02:0.04", "initial_velocity=-2:-0.1")
    recipe, values = recipe_of(sweep), sweep.design.rows(0, 64)
    together = simulate_rows(recipe, values)
    alone = np.concatenate([simulate_rows(recipe, values[place : place + 1]) for place in range(64)])
    backwards = simulate_rows(recipe, values[::-1].copy())[::-1]
    assert alone.tobytes() == together.tobytes()
    assert backwards.tobytes() == together.tobytes()


def test_another_simulator_s_recipe_is_refused() -> None:
    sweep = grid_sweep("b_ad=0,100")
    with refuses(UsageError, "another version of"):
        simulate_rows(replace(recipe_of(sweep), simulator="0" * 20), sweep.design.rows(0, 2))
