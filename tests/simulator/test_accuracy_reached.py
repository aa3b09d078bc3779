"""`accuracy` is a goal that the outputs keep: 99 of 100 unflagged scenes, without wasting much more than it needs."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.compiled import Row
from simulator.jump import ill_conditioned, parameter_row
from simulator.kernel.build import kernel_for
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import COLUMN
from simulator.scene_file import load_scene
from tests.helpers.kernels import batch_rows

JUDGED = 1000
SCENES = 1900
"""As many as give `JUDGED` jumps with the flagged and those that end otherwise left out."""
FINEST = 1e-12
RANGES = {
    "k_compression": (150.0, 300.0),
    "k_extension": (300.0, 1600.0),
    "b_compression": (5.0, 25.0),
    "b_extension": (0.5, 25.0),
    "b_ad": (0.0, 400.0),
    "foot_radius": (0.012, 0.06),
    "kg_scale": (0.5, 20.0),
    "bg_scale": (0.2, 5.0),
    "body_mass": (1.0, 2.5),
    "foot_mass": (0.05, 0.4),
}
STARTS = {
    "sim2": {"initial_velocity": (-2.0, -0.2)},
    "sim1": {"initial_velocity": (-2.0, -0.2)},
    "bed": {"initial_velocity": (-0.5, 0.0), "initial_height": (0.02, 0.2)},
}
OUTPUTS = ("max_depth_m", "liftoff_time_s", "apex_height_m")
TOUCHDOWN = OUTCOMES.index("touchdown")
ACCURACIES = [1e-6, *(pytest.param(accuracy, marks=pytest.mark.soak) for accuracy in (1e-4, 1e-8))]
RESIDUAL_FACTOR = 5.0
"""Most that the worst energy residual of some thousand unflagged jumps may be in units of the accuracy."""


def _outputs(rows: Row) -> Row:
    cost = sum(rows[:, COLUMN[f"stance_{part}_J"]] for part in ("heat", "mechanical", "drag"))
    return np.stack([*(rows[:, COLUMN[name]] for name in OUTPUTS), cost])


@pytest.mark.parametrize("accuracy", ACCURACIES)
@pytest.mark.parametrize("name", ["sim2", *(pytest.param(name, marks=pytest.mark.soak) for name in ("sim1", "bed"))])
def test_the_goal_is_kept_and_not_overdone_and_the_energy_book_closes_within_it(name: str, accuracy: float) -> None:
    scene = load_scene(name)
    kernel = kernel_for(scene.effects)
    names = [parameter.name for parameter in kernel.composition.parameters]
    table = np.repeat(parameter_row(kernel, scene)[np.newaxis], SCENES, axis=0)
    random = np.random.default_rng(7)
    for parameter, (low, high) in (STARTS[name] | RANGES).items():
        table[:, names.index(parameter)] = random.uniform(low, high, SCENES)
    reference, rows = (batch_rows(kernel.batch, table, goal)[0][:, 0] for goal in (FINEST, accuracy))

    flagged = np.asarray(ill_conditioned(rows[:, COLUMN["decision_margin"]], rows[:, COLUMN["error_growth"]], accuracy))
    judged = (reference[:, 0] == TOUCHDOWN) & ~flagged
    assert judged.sum() >= JUDGED
    share = np.max(np.abs(_outputs(rows[judged]) / _outputs(reference[judged]) - 1), axis=0) / accuracy
    share[rows[judged, 0] != TOUCHDOWN] = np.inf
    assert np.mean(share <= 1) >= 0.99
    assert np.median(share) >= 0.01
    assert np.mean(rows[~flagged, 0] == reference[~flagged, 0]) >= 0.998

    turned_over = np.abs(rows[:, COLUMN["leg_work_J"]]) + np.abs(rows[:, COLUMN["ground_loss_J"]])
    residual = (np.abs(rows[:, COLUMN["energy_residual_J"]]) / turned_over)[~flagged] / accuracy
    assert np.max(residual) < RESIDUAL_FACTOR
    assert np.quantile(residual, 0.99) < 1.0
    assert np.median(residual) < 0.1
