"""A jump that stiff dampers keep from any end within the steps allowed is given up after a look ahead; no other is."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from numpy.typing import NDArray

from simulator.jump import MOST_STEPS_A_JUMP, limits_for, parameter_row
from simulator.kernel.build import kernel_for
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.limits import FIRST_LOOK, MOST_STEPS, SURE
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.scene_file import load_scene

Row = NDArray[np.float64]
SCENE = load_scene("sim2")
FEW = 40_000.0
SURELY_MORE = FIRST_LOOK + SURE * (FEW - FIRST_LOOK)


@functools.cache
def stiff(count: int) -> Row:
    """Parameters of scenes with light feet and much drag: some take a thousand steps, some thousands of millions."""
    kernel, random = kernel_for(SCENE.effects), np.random.default_rng(3)
    drawn = {"bg_scale": 10.0 ** random.uniform(1, 6, count), "foot_mass": 10.0 ** random.uniform(-6, -2, count)}
    names = [parameter.name for parameter in kernel.composition.parameters]
    table = np.repeat(parameter_row(kernel, SCENE)[np.newaxis], count, axis=0)
    for name, values in drawn.items():
        table[:, names.index(name)] = values
    return table


def simulated(table: Row, most_steps: float, fixed_step_s: float = 0.0) -> Row:
    """Every column of one jump of each scene, at 1e-4."""
    rows, none = np.zeros((len(table), 1, len(COLUMNS))), np.zeros((0, 4))
    limits = limits_for(1e-4, fixed_step_s=fixed_step_s)
    limits[MOST_STEPS] = most_steps
    kernel_for(SCENE.effects).batch(table, limits, rows, np.zeros(len(table), np.int64), none, none)
    return rows[:, 0]


def ended(rows: Row, outcome: str) -> NDArray[np.bool_]:
    return np.asarray(rows[:, 0] == OUTCOMES.index(outcome))


@pytest.mark.parametrize(
    ("count", "few", "more"),
    [
        (60, FEW, SURELY_MORE),
        pytest.param(2000, MOST_STEPS_A_JUMP, 1.5 * MOST_STEPS_A_JUMP, marks=pytest.mark.soak),
    ],
)
def test_what_is_given_up_has_no_end_within_the_limit_and_nothing_else_changes(
    count: int, few: float, more: float
) -> None:
    rows, beside = simulated(stiff(count), few), simulated(stiff(count), more)
    given_up, limited = ended(rows, "too_stiff"), ended(rows, "step_limit")
    assert given_up.sum() > 3 * limited.sum() > 0, "most of the work is saved"
    finished, later = ~given_up & ~limited, ~ended(beside, "too_stiff")
    assert finished.sum() > count / 10
    assert np.array_equal(rows[finished], beside[finished], equal_nan=True)
    assert np.all(beside[given_up & later, COLUMN["steps"]] >= few)
    assert np.all(np.isin(np.log2(rows[given_up, COLUMN["steps"]] / FIRST_LOOK), range(8)))


def test_steps_of_a_fixed_length_are_not_counted_ahead() -> None:
    table = stiff(60)
    table = table[ended(simulated(table, FEW), "too_stiff")][:2]
    assert np.all(ended(simulated(table, FEW, 1e-13), "step_limit"))
