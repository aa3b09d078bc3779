"""Golden values of thirty digits or more are met, and errors shrink with the step and with the accuracy asked for."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.compiled import Row
from simulator.jump import parameter_row, simulate
from simulator.kernel.build import kernel_for
from simulator.kernel.rows import COLUMN
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import CASES, batch_rows, errors, interpreted, reference, relative_error, scene_of, spent_j

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


@pytest.mark.parametrize("accuracy", [1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("key", WELL_CONDITIONED, ids=", ".join)
def test_a_stored_case_is_met_within_the_accuracy(key: tuple[str, str], accuracy: float) -> None:
    for name, error in worst_errors([key], accuracy)[key].items():
        assert error < accuracy, name
    if accuracy == 1e-9:  # what is printed of the others, the stored jumps are held to in `test_storage`
        scene = scene_of(*key)
        for jump, wanted in zip(simulate(scene, accuracy).jumps, reference(*key), strict=True):
            found_j = spent_j(jump, whole_jump="cost_of_whole_jump" in scene.effects)
            assert max(map(relative_error, found_j, (wanted.heat_j, wanted.mechanical_j))) < 1e-7
            assert scene.jumps == 1 or relative_error(jump.next_touchdown_time_s, wanted.duration_s) < 1e-7


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


NAMES = "max_depth_m", "liftoff_time_s", "liftoff_body_velocity_m_s", "apex_height_m", "jump_heat_J", "leg_work_J"
OUTPUTS = [COLUMN[name] for name in NAMES]
ORDER = 5
FINEST = 1e-13
EASY = {"foot_mass": 0.6, "platform_damping": 10.0, "platform_drag": 5.0}
"""A foot that the platform brakes over many milliseconds, so that steps of some are fine already."""
LIGHT_GRAINS = {"bg_scale": 0.05, "rho": 100.0, "added_mass_constant": 0.1, "kg_scale": 0.5}
"""So do grains of little drag and mass under a heavy foot."""


ONE_JAM = {**LIGHT_GRAINS, "foot_mass": 1.0, "bg_scale": 0.2, "rho": 50.0, "initial_velocity": -0.4}
STEPPED: dict[str, tuple[str, dict[str, float], float, float]] = {
    "emulator, touchdown to touchdown": ("emulator", EASY, 6e-3, 1.0),
    "emulator, on the cap": ("emulator", {**EASY, "k_extension": 1091.36}, 6e-3, 1.0),
    "emulator, damped": ("emulator", {**EASY, "b_ad": 20.0}, 6e-3, 1.2),
    "grains, one jam": ("sim2", ONE_JAM, 4e-3, 0.3),
    "grains, dropped on them": ("bed", {**LIGHT_GRAINS, "foot_mass": 0.6, "foot_radius": 0.03}, 4e-3, 0.3),
}
"""A scene, its values, the longest step (s) over which its order shows, and how far over the method's it may lie."""


def outputs(scene: Scene, step_s: float) -> Row:
    """Outputs of one jump, with steps of one length, or as fine as can be (0); events are met to rounding."""
    kernel = kernel_for(scene.effects)
    rows, _ = batch_rows(kernel.batch, parameter_row(kernel, scene)[np.newaxis, :], FINEST, step_s=step_s)
    found: Row = rows[0, 0, OUTPUTS]
    return found


def slope(across: Row, error: Row) -> float:
    return float(np.polyfit(np.log(across), np.log(error), 1)[0])


@pytest.mark.parametrize("name", STEPPED)
def test_through_events_the_error_shrinks_with_the_fifth_power_of_the_step(name: str) -> None:
    """An event met less well than the steps would cost it. Terms of the next order still show on the emulator."""
    shipped, values, longest_s, above = STEPPED[name]
    scene = load_scene(shipped).changed(values, jumps=1)
    assert len(simulate(scene, 1e-9).jump.mode_changes) >= 3
    wanted = outputs(scene, 0.0)
    steps_s = np.geomspace(4e-4, longest_s, 16)
    found = np.array([np.abs(outputs(scene, step_s) / wanted - 1.0) for step_s in steps_s])
    mean = np.exp(np.log(np.maximum(found, 1e-17)).mean(axis=1))
    assert ORDER - 0.3 < slope(steps_s, mean) < ORDER + above
    assert mean[0] < 3e-12


CONVERGING = [
    ("sim2", "defaults, held gains in flight"),
    ("sim1", "defaults"),
    ("bed", "small foot, gain 400, active gain 150"),
    ("bed", "large foot, gain 300"),
    ("emulator", "gain 200"),
    ("emulator", "gain 400, b_AD = 664/3"),
    ("force_plate", "gain 300"),
    ("force_plate", "gain 600"),
]


def test_errors_follow_the_accuracy_asked_for() -> None:
    accuracies = 10.0 ** -np.arange(3.0, 11.0)
    mean = []
    for accuracy in accuracies:
        logs = []
        for key in CONVERGING:
            scene, wanted = scene_of(*key), reference(*key)
            for jump, stored in zip(simulate(scene, accuracy).jumps, wanted, strict=True):
                found = errors(scene, jump, stored)
                logs += [np.log(max(found[name], 1e-17)) for name in ("lift-off", "apex", "cost")]
        mean.append(np.exp(np.mean(logs)))
    assert 0.75 < slope(accuracies, np.array(mean)) < 1.15
    assert np.all(np.array(mean) < accuracies)
    assert np.all(np.array(mean) > 1e-3 * accuracies)
