"""What a simulation gives for each condition, without errors: to stand beside what a study measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.errors import LabbookError
from data_schema.outcomes import Outcome
from data_schema.queries.facts import read_fact
from labbook.analysis.prediction.condition_scenes import ROBOT_PARAMETERS, condition_scene, study_scene
from labbook.analysis.prediction.simulating import ALWAYS, SIMULATING, simulated
from labbook.analysis.study_data import StudyData


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
    """Simulate each condition once, as its first robot ran it; nothing is varied or stored, and nothing is refused."""
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
            found[run.condition_key] = simulated(scene, settings.accuracy, ALWAYS).values
        except LabbookError as error:
            failed.setdefault(str(error), run.condition_key)
    return PlainPredictions(found, " ".join(f"{condition}: {reason}" for reason, condition in failed.items()))
