"""The same scene gives the same bits: repeated, in any company, and on any thread."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from simulator.jump import limits_for, parameter_row, simulate
from simulator.kernel.build import Kernel, kernel_for
from simulator.kernel.limits import JUMPS_WANTED
from simulator.kernel.rows import COLUMNS
from simulator.scene import Scene
from simulator.scene_file import load_scene, shipped_scenes
from tests.helpers.kernels import interpreted

Row = NDArray[np.float64]
JUMPS = 3
GROUND = {"foot_radius": 0.034, "kg_scale": 1.7}
OTHER_VALUES = {
    "bed": ({}, {"k_extension": 700.0}, GROUND, {"b_ad": 90.0, "initial_height": 0.21}),
    "sim1": ({"b_ad": 20.0}, {"b_ad": 0.0, "k_extension": 900.0}, {"b_ad": 60.0, **GROUND}),
    "sim2": ({}, {"k_extension": 1091.36}, GROUND, {"b_ad": 90.0, "initial_velocity": -1.4}),
    "emulator": ({}, {"k_extension": 579.36}, {"b_ad": 90.0}, {"k_compression": 160.0, "k_extension": 323.36}),
    "force_plate": ({}, {"k_extension": 1603.36}, {"b_compression": 30.0}, {"body_mass": 1.5}),
}
"""Scenes beside the shipped one, some of which end otherwise."""


def scenes(name: str) -> list[Scene]:
    shipped = load_scene(name)
    return [shipped.changed(values, jumps=min(shipped.jumps, JUMPS)) for values in OTHER_VALUES[name]]


def run(kernel: Kernel, table: Row, jumps: int) -> tuple[Row, NDArray[np.int64]]:
    rows, counts = np.zeros((len(table), jumps, len(COLUMNS))), np.zeros(len(table), np.int64)
    limits = limits_for(1e-6)
    limits[JUMPS_WANTED] = jumps
    kernel.batch(table, limits, rows, counts, np.full((0, 4), -1.0), np.zeros((0, 0)))
    return rows, counts


@dataclass(frozen=True, slots=True)
class Case:
    kernel: Kernel
    table: Row
    jumps: int
    rows: Row
    counts: NDArray[np.int64]


@pytest.fixture(scope="module", params=shipped_scenes())
def case(request: pytest.FixtureRequest) -> Case:
    """A table of scenes with the effects of a shipped one, simulated once."""
    found = scenes(request.param)
    kernel = kernel_for(found[0].effects)
    table = np.array([parameter_row(kernel, scene) for scene in found])
    return Case(kernel, table, found[0].jumps, *run(kernel, table, found[0].jumps))


def test_a_repeat_is_the_same_bit_for_bit(case: Case) -> None:
    rows, counts = run(case.kernel, case.table, case.jumps)
    assert rows.tobytes() == case.rows.tobytes()
    assert counts.tobytes() == case.counts.tobytes()


def test_a_scene_alone_is_the_same_as_in_any_company(case: Case) -> None:
    backwards, _ = run(case.kernel, np.ascontiguousarray(case.table[::-1]), case.jumps)
    for place, values in enumerate(case.table):
        alone, count = run(case.kernel, values[np.newaxis, :], case.jumps)
        assert count[0] == case.counts[place]
        assert alone[0].tobytes() == case.rows[place].tobytes()
        assert backwards[len(case.table) - 1 - place].tobytes() == case.rows[place].tobytes()


def test_threads_side_by_side_give_the_same(case: Case) -> None:
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: run(case.kernel, case.table, case.jumps)[0].tobytes(), range(12)))
    assert set(found) == {case.rows.tobytes()}


def test_results_repeat_too() -> None:
    scene = load_scene("sim2").changed({"b_ad": 100.0})
    first, second = simulate(scene, 1e-8), simulate(scene, 1e-8)
    assert first.jumps == second.jumps
    assert replace(first.jump, steps=0) != first.jump


def rows_of_all(names: tuple[str, ...]) -> dict[str, Row]:
    found = {}
    for name in names:
        some = scenes(name)
        kernel = kernel_for(some[0].effects)
        table = np.array([parameter_row(kernel, scene) for scene in some])
        found[name] = run(kernel, table, some[0].jumps)[0]
    return found


def test_interpreted_the_same_code_gives_the_same_numbers() -> None:
    """Only the mathematical library of the compiler rounds otherwise, in the last digit."""
    compiled, plain = rows_of_all(shipped_scenes()), interpreted(rows_of_all, shipped_scenes())
    exact = [COLUMNS.index(name) for name in ("outcome", "steps", "rhs_evaluations", "mode_changes")]
    residual = [COLUMNS.index(name) for name in ("energy_residual_J", "decision_margin", "error_growth")]
    for name, rows in compiled.items():
        np.testing.assert_array_equal(plain[name][..., exact], rows[..., exact], name)
        rest = np.delete(np.arange(len(COLUMNS)), residual)
        np.testing.assert_allclose(plain[name][..., rest], rows[..., rest], rtol=1e-11, atol=1e-13, err_msg=name)
