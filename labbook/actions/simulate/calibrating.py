"""What `labbook calibrate` does: parameters of a scene fitted to what the book measured, and the scene with them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from scipy import stats

from data_schema import journal
from data_schema.errors import InputRefused, UsageError
from data_schema.queries.facts import read_fact
from data_schema.queries.runs import refuse_empty_selection
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.pairing import swept_factor
from labbook.analysis.outcomes.conditions import conditions_by_outcome
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.prediction.calibrating import FITTED, Calibrated, Calibration, calibrate, measured_means
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
from reports.display import count_text, given_text, list_text, p_text, shown_unit, with_unit
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


HEAD = ("parameter", "value", "std. error", "profile likelihood", "from")


def sentences(found: Calibration) -> list[str]:
    """Say how well the scene fits, what was identified, and what held-out conditions show."""
    p = float(stats.f.sf(found.chi_squared / found.df, found.df, found.df_of_errors))
    rms = [
        f"{with_unit(f'{_shown(value, outcome.unit):.3g}', shown_unit(outcome.unit)[0])} in {outcome}"
        for outcome, value in found.rms.items()
    ]
    fits = "The scene describes what was measured" if p > 0.05 else "The scene does not describe all that was measured"
    lines = [
        f"{fits}: F({found.df}, {found.df_of_errors}) = {found.chi_squared / found.df:.4g} ({p_text(p)}), "
        f"{list_text(rms)} (root mean square of {count_text(found.n_means, 'mean')})."
    ]
    if found.chi_squared > found.df:
        lines.append(
            f"Standard errors and profiles are widened {math.sqrt(found.chi_squared / found.df):.3g} times for it."
        )
    unknown = [one.name for one in found.parameters if not one.identified]
    if unknown:
        number = f" (condition number {found.condition:.2g})" if math.isfinite(found.condition) else ""
        lines.append(
            f"These data do not identify {list_text(unknown)}{number}: fix what you know better, or fit fewer."
        )
    lines += [
        f"{one.name} is at {one.value:.5g}, a bound of what a scene can have: on that side the data set no end."
        for one in found.parameters
        if one.at_bound
    ]
    lines += [
        f"Held out group by group, {one.within} of {one.of} means of {one.outcome} lie within their "
        f"{level_text_of(found.level)} intervals (root mean square "
        f"{with_unit(f'{_shown(one.rms, one.outcome.unit):.3g}', shown_unit(one.outcome.unit)[0])})."
        for one in found.held_out
    ]
    return lines


def how_to_use(found: Calibration, scene: str) -> str:
    """Write what to put into labbook.toml, so that predictions carry the errors of what was fitted."""
    parts = {one.name: one.se / one.value for one in found.parameters if isinstance(one.se, float)}
    varied = ", ".join(f"{name} = {part:.2g}" for name, part in parts.items() if 0.0 < part < 1.0)
    return f'Under [simulation]: scene = "{scene}"' + (f", varied = {{ {varied} }}" if varied else "")


def level_text_of(level: float) -> str:
    """Write a level: "95 %"."""
    return with_unit(given_text(100.0 * level), "%")


def _shown(value: float, unit: str) -> float:
    return value * shown_unit(unit)[1]


def rows(found: Calibration) -> list[list[str]]:
    """Return a row for each parameter."""
    return [
        [
            f"{one.name} ({one.unit})" if one.unit != "1" else one.name,
            f"{one.value:.5g}",
            "–" if isinstance(one.se, Undefined) else f"{one.se:.2g}",
            _profile_text(one),
            f"{one.started_at:.5g}",
        ]
        for one in found.parameters
    ]


def _profile_text(one: Calibrated) -> str:
    low, high = one.profile
    if low is None and high is None:
        return "not identified"
    if low is None or high is None:
        return f"below {high:.5g}" if low is None else f"above {low:.5g}"
    return f"{low:.5g} to {high:.5g}"


def as_data(found: Calibration) -> dict[str, Any]:
    """Return the same for programs, unrounded."""
    return {
        "parameters": [
            {
                **asdict(one),
                "se": None if isinstance(one.se, Undefined) else one.se,
                "identified": one.identified,
                "at_bound": one.at_bound,
            }
            for one in found.parameters
        ],
        "chi_squared": found.chi_squared,
        "df": found.df,
        "df_of_errors": found.df_of_errors,
        "condition_number": found.condition if math.isfinite(found.condition) else None,
        "rms": {outcome.key: value for outcome, value in found.rms.items()},
        "held_out": [
            {"outcome": one.outcome.key, "within": one.within, "of": one.of, "rms": one.rms} for one in found.held_out
        ],
        "means": found.n_means,
        "runs": {outcome.key: n for outcome, n in found.n_runs.items()},
        "level": found.level,
    }
