"""What `labbook calibrate` does: parameters of a scene fitted to what the book measured, and the scene with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from data_schema import journal
from data_schema.errors import InputRefused, UsageError
from data_schema.queries.facts import read_fact
from data_schema.queries.runs import refuse_empty_selection
from labbook.analysis.comparison.pairing import swept_factor
from labbook.analysis.outcomes.conditions import conditions_by_outcome
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.prediction.calibrating import FITTED, Calibration, calibrate, measured_means
from labbook.analysis.prediction.condition_scenes import (
    ROBOT_PARAMETERS,
    condition_scene,
    study_scene,
    unconverted_factors,
)
from labbook.analysis.prediction.simulating import ALWAYS
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather
from labbook.book.opening import Book
from reports.display import list_text
from reports.tables.predictions import unconverted_text
from simulator.scene import Scene, Value
from stats.lines.nonlinear import NothingAtStart


@dataclass(frozen=True, slots=True)
class CalibratedScene:
    """A calibration, the scene with the fitted values, which cite the book, and the book's name for sentences."""

    calibration: Calibration
    scene: Scene
    study: str


def calibrate_book(
    book: Book,
    where: str | None,
    names: Sequence[str],
    level: float,
    step: Callable[[str], None],
) -> CalibratedScene:
    """Fit parameters of the book's scene to the selected runs; nothing is stored.

    Raises `UsageError` where the book names no scene, or the runs are of several robots, and as `calibrate` does.
    """
    configuration = book.configuration
    if configuration.simulation is None:
        raise UsageError('labbook.toml names no scene to fit: write scene = "bed" under [simulation].')
    start = study_scene(configuration.simulation)
    with book.reading() as connection:
        refuse_empty_selection(connection, where)
        evidence = gather(connection, configuration, where)
        entries, head = journal.head(connection)
        computed, detections = Results(), Detections(connection, book.store, step)
        conditions = conditions_by_outcome(computed, detections, evidence, ALWAYS)
        runs = {
            item.run.condition_key: item.run for several in conditions.values() for one in several for item in one.runs
        }
        robots = {item.run.robot for several in conditions.values() for one in several for item in one.runs}
        if not runs:
            raise UsageError(f"no run of this selection ({where or 'all runs'}) has joules or an apex height to fit.")
        if len(robots) > 1:
            raise UsageError(
                f'these runs are of {len(robots)} robots: choose one, as in --where "robot={min(robots)}".'
            )
        facts = {
            run.robot_uid: read_fact(connection, "robot", run.robot_uid, list(ROBOT_PARAMETERS.values()))
            for run in runs.values()
        }
    scenes = [
        condition_scene(start, configuration, evidence.factors, run.levels, (run.robot, facts[run.robot_uid]))
        for run in runs.values()
    ]
    measured = measured_means(conditions, list(runs), swept_factor(configuration))
    wanted = list(names) or [name for name in FITTED if name in start.read]
    if not wanted:
        raise UsageError(
            f"the scene {start.name} reads neither {' nor '.join(FITTED)}: name what to fit with --fit, such as what "
            f"it assumes ({list_text(start.assumed) or 'nothing'})."
        )
    try:
        found = calibrate(scenes, measured, wanted, level=level, progress=step)
    except NothingAtStart as error:
        unconverted = unconverted_factors(configuration, evidence.factors)
        raise InputRefused(f"{error} {unconverted_text(unconverted)}".rstrip()) from error
    cited = (
        f"fitted to {configuration.study.name}: {len(measured)} means of {len(runs)} conditions, "
        f"configuration {configuration.sha256[:12]}, journal of {entries} entries to {head[:12]}; that these runs "
        "agree with it is no test"
    )
    fitted_to = configuration.study.name
    values = {one.name: Value(one.value, why=cited, fitted_to=fitted_to) for one in found.parameters}
    scene = replace(start, title=f"{start.title}, calibrated", values={**start.values, **values})
    return CalibratedScene(found, scene, configuration.study.name)
