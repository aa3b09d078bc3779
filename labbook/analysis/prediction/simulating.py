"""Scenes simulated, with means over their jumps: once, many times over with parameters changed, for each condition."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from data_schema.errors import LabbookError
from data_schema.outcomes import Outcome
from data_schema.queries.facts import read_fact
from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.analysis.prediction.condition_scenes import ROBOT_PARAMETERS, condition_scene, study_scene
from labbook.analysis.study_data import StudyData

if TYPE_CHECKING:  # the simulator is loaded by those who simulate: compiling takes its time
    from simulator.result import JumpResult
    from simulator.scene import Scene
    from simulator.sweep.chunks import Recipe


SIMULATING = "simulating each condition (compiling the simulator before, up to 30 s)"
"""What is done while simulations are waited for."""

ALWAYS = (Outcome.JOULES, Outcome.APEX)
SIMULATED = (*ALWAYS, Outcome.CONTACT_TIME, Outcome.IMPULSE_HEIGHT)
"""The outcomes that a simulation has: those of a plate where it was measured. A peak force is none of them: the foot's
impact is an impulse there, and a peak on the plate.
"""


@dataclass(frozen=True, slots=True)
class Simulated:
    """One simulation of a scene: a value a quantity (None where a jump has no apex), and how the jump ended.

    `close_decision`: whether a decision hangs on a knife's edge; `branch` holds the values had it fallen otherwise,
    where that was simulated. `rounding`: what rounding has grown to, 0 where the accuracy has room for it.
    `under_surface`: whether the body gets under the grains; `open_book`: whether an energy book does not close.
    """

    values: Mapping[str, float | None]
    outcome: str
    close_decision: bool
    rounding: float
    under_surface: bool
    open_book: bool
    branch: Mapping[str, float | None] | None = None


def simulate_varied(
    scene: Scene, name: str, factor: float, accuracy: float, outcomes: Sequence[Outcome]
) -> Mapping[str, float | None]:
    """Simulate with one parameter times a factor; the values are None where no scene can have that."""
    try:
        changed = scene.changed({name: scene[name] * factor})
    except LabbookError:
        return dict.fromkeys(map(str, outcomes))
    return simulate_means(changed, accuracy, outcomes).values


def simulate_means(scene: Scene, accuracy: float, outcomes: Sequence[Outcome]) -> Simulated:
    """Simulate a scene and take the mean over its jumps."""
    from simulator.jump import close_decision, grown_rounding, simulate

    jumps = simulate(scene, accuracy).jumps
    ended = next((jump.outcome for jump in jumps if jump.apex_height_m is None), jumps[-1].outcome)
    branch = None
    if any(jump.other_branch is not None for jump in jumps):
        branch = mean_values(scene, [jump.other_branch or jump for jump in jumps], outcomes)
    rounding = max(grown_rounding(jump, accuracy) for jump in jumps)
    return Simulated(
        mean_values(scene, jumps, outcomes),
        ended,
        any(map(close_decision, jumps)),
        rounding,
        any(jump.under_surface for jump in jumps),
        any(jump.open_book for jump in jumps),
        branch,
    )


def mean_values(scene: Scene, jumps: Sequence[JumpResult], outcomes: Sequence[Outcome]) -> dict[str, float | None]:
    """Return each outcome's mean over the jumps of a scene, None where a jump has none."""
    found: dict[str, float | None] = dict.fromkeys(map(str, outcomes))
    if any(jump.apex_height_m is None for jump in jumps):
        return found
    for outcome in outcomes:
        known = [value for jump in jumps if (value := _VALUES[outcome](scene, jump)) is not None]
        found[outcome] = math.fsum(known) / len(jumps) if len(known) == len(jumps) else None
    return found


def _impulse_height_m(scene: Scene, jump: JumpResult) -> float | None:
    """Return how high the centre of mass rises above lift-off by its speed there, as a plate's impulse gives it."""
    body_m_s, foot_m_s = jump.liftoff_body_velocity_m_s, jump.liftoff_foot_velocity_m_s
    if body_m_s is None or foot_m_s is None:
        return None
    body_kg, foot_kg = scene["body_mass"], scene["foot_mass"]
    speed_m_s = (body_kg * body_m_s + foot_kg * foot_m_s) / (body_kg + foot_kg)
    return speed_m_s**2 / (2.0 * STANDARD_GRAVITY_M_S2)


_VALUES: Mapping[Outcome, Callable[[Scene, JumpResult], float | None]] = {
    Outcome.JOULES: lambda _scene, jump: jump.cost_J,
    Outcome.APEX: lambda _scene, jump: jump.apex_height_m,
    Outcome.CONTACT_TIME: lambda _scene, jump: jump.liftoff_time_s,
    Outcome.IMPULSE_HEIGHT: _impulse_height_m,
}


Floats = NDArray[np.float64]

_OUTPUT = {Outcome.JOULES: "cost_J", Outcome.APEX: "apex_height_m"}


@dataclass(frozen=True, slots=True, eq=False)
class ManyScenes:
    """Scenes with the same effects as rows of parameters, and where in a row those stand that are changed."""

    recipe: Recipe
    rows: Floats
    places: tuple[int, ...]

    def means(self, values: Floats) -> Mapping[Outcome, Floats]:
        """Simulate every scene with each of m sets of values, shape (m, parameters).

        Returns by outcome the means over a scene's jumps, shape (m, scenes); NaN where the robot does not jump.
        """
        from simulator.sweep.chunks import PLACE, simulate_on_all_cores

        n, m = len(self.rows), len(values)
        table = np.tile(self.rows, (m, 1))
        table[:, self.places] = np.repeat(values, n, axis=0)
        block = simulate_on_all_cores(self.recipe, table).reshape(m, n, self.recipe.jumps, -1)
        found = {outcome: block[..., PLACE[name]].mean(axis=2) for outcome, name in _OUTPUT.items()}
        jumps = np.isfinite(found[Outcome.APEX])
        return {outcome: np.where(jumps, means, np.nan) for outcome, means in found.items()}


def many_scenes(scenes: Sequence[Scene], names: Sequence[str], accuracy: float) -> ManyScenes:
    """Prepare scenes with the same effects, and compile their kernel; `names` are the parameters to change."""
    from simulator.jump import parameter_row
    from simulator.kernel.build import kernel_for
    from simulator.sweep.chunks import recipe_of_rows

    kernel = kernel_for(scenes[0].effects)
    columns = [parameter.name for parameter in kernel.composition.parameters]
    return ManyScenes(
        recipe_of_rows(scenes[0], accuracy),
        np.array([parameter_row(kernel, scene) for scene in scenes]),
        tuple(columns.index(name) for name in names),
    )


@dataclass(frozen=True, slots=True)
class PlainPredictions:
    """Joules a jump and apex height (`ALWAYS`) by the condition's key, means over all jumps, without errors.

    `why_not` says why there are none, or none of some conditions.
    """

    values: Mapping[str, Mapping[str, float | None]]
    why_not: str = ""

    def value(self, condition_key: str, outcome: Outcome) -> float | None:
        """Return what is predicted, None where nothing is."""
        return self.values.get(condition_key, {}).get(outcome)


def plain_predictions(
    connection: sa.Connection, evidence: StudyData, progress: Callable[[str], None]
) -> PlainPredictions:
    """Simulate each condition once, as its first robot ran it; nothing is varied, kept or refused."""
    settings = evidence.configuration.simulation
    if settings is None:
        return PlainPredictions({}, "labbook.toml has no [simulation].")
    try:
        start = study_scene(settings)
    except LabbookError as error:
        return PlainPredictions({}, str(error))
    progress(SIMULATING)
    found: dict[str, Mapping[str, float | None]] = {}
    failed: dict[str, str] = {}
    for run in {run.condition_key: run for run in reversed(evidence.runs) if run.levels}.values():
        facts = read_fact(connection, "robot", run.robot_uid, list(ROBOT_PARAMETERS.values()))
        robot = (run.robot, facts)
        try:
            scene = condition_scene(start, evidence.configuration, evidence.factors, run.levels, robot)
            found[run.condition_key] = simulate_means(scene, settings.accuracy, ALWAYS).values
        except LabbookError as error:
            failed.setdefault(str(error), run.condition_key)
    return PlainPredictions(found, " ".join(f"{condition}: {reason}" for reason, condition in failed.items()))
