"""A condition as a scene: the study's scene with the robot and the levels that the condition was run with.

What `labbook.toml` says under `[simulation]` decides; a later line of this list overrides an earlier one: the shipped
scene, the robot's facts in the book, the parameters of all conditions, the parameters of the condition's levels.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from data_schema.errors import LabbookError, UsageError
from data_schema.queries.study import FactorRow, LevelRow
from labbook.config.model import GainSettings, SimulationSettings
from labbook.config.parsing import Configuration

if TYPE_CHECKING:  # the simulator is loaded by those who ask for a scene: compiling takes its time
    from simulator.scene import Scene

ROBOT_PARAMETERS: Mapping[str, str] = {
    "body_mass": "body_mass_kg",
    "foot_mass": "foot_mass_kg",
    "upper_link": "link_1_m",
    "lower_link": "link_2_m",
    "rest_length": "rest_length_m",
}
"""Parameter of a scene -> fact about a robot."""

IN_FILE = "[simulation] of labbook.toml"
_GAIN_UNITS = ("N/m", "kg/s", "kg/m")
"""Units of what a controller has gains for."""


def study_scene(settings: SimulationSettings) -> Scene:
    """Return the scene that all conditions start from.

    Raises `InputRefused` for a file that is no scene, `UsageError` for effects that cannot be together.
    """
    from simulator.changes import changed_by_words
    from simulator.scene_file import load_scene, parse_scene

    own = settings.scene_toml
    scene = load_scene(settings.scene) if own is None else parse_scene(own, settings.scene, settings.scene)
    try:
        return changed_by_words(scene, (), settings.effects)
    except LabbookError as error:
        raise UsageError(f"{IN_FILE}, effects: {error}") from error


def condition_scene(
    start: Scene,
    configuration: Configuration,
    rows: tuple[FactorRow, ...],
    levels: Mapping[str, str],
    robot: tuple[str, Mapping[str, float]],
) -> Scene:
    """Return the scene of one condition; `robot` is its name and the facts that `ROBOT_PARAMETERS` names.

    Raises `UsageError` where the configuration names what the scene does not read, or a level gives no number.
    """
    from simulator.changes import with_changes_in_title

    settings = configuration.simulation
    assert settings is not None  # noqa: S101 - who has a scene has settings
    name, facts = robot
    given = {parameter: (facts[fact], f"robot {name}") for parameter, fact in ROBOT_PARAMETERS.items()}
    given |= {parameter: (value, IN_FILE) for parameter, value in settings.parameters.items()}
    for row in rows:
        level = next((level for level in row.levels if level.label == levels.get(row.name)), None)
        if level is not None:
            found = level_parameters(settings, configuration.gains.get(row.name), row.name, level)
            given |= {parameter: (value, f"{row.name} {level.label}") for parameter, value in found.items()}
    try:
        scene = _sourced(start, given, settings.assumed)
    except LabbookError as error:
        raise UsageError(f"{IN_FILE}: {error}") from error
    return with_changes_in_title(scene, [*(f"{factor}={level}" for factor, level in levels.items()), f"robot {name}"])


def level_parameters(
    settings: SimulationSettings, gain: GainSettings | None, factor: str, level: LevelRow
) -> dict[str, float]:
    """Return the parameters that a level stands for, none where the study says nothing of the factor."""
    found = dict(settings.levels.get(factor, {}).get(level.label, {}))
    parameter = settings.factors.get(factor)
    if parameter is not None and parameter not in found:
        found[parameter] = _physical(gain, factor, level, parameter)
    return found


def unconverted_factors(configuration: Configuration, rows: tuple[FactorRow, ...]) -> tuple[tuple[str, str, str], ...]:
    """Return the factors whose numbers [simulation] takes as stiffness or damping as they stand.

    With each the parameter that it is, and its unit.
    """
    from simulator.declared import all_parameters

    named = {} if configuration.simulation is None else configuration.simulation.factors
    return tuple(
        (row.name, named[row.name], all_parameters()[named[row.name]].unit)
        for row in rows
        if row.name in named and row.name not in configuration.gains
        if all_parameters()[named[row.name]].unit in _GAIN_UNITS
        if any(level.value is not None for level in row.levels)
    )


def _physical(gain: GainSettings | None, factor: str, level: LevelRow, parameter: str) -> float:
    """Return a level's physical value: a gain's by its formula, a number itself, else its only numeric attribute."""
    if level.value is not None:
        return gain.physical(level.value) if gain is not None else level.value
    attributes = [value for value in json.loads(level.attributes_json).values() if isinstance(value, int | float)]
    if len(attributes) == 1:
        return float(attributes[0])
    raise UsageError(
        f"{IN_FILE} says that {factor} is {parameter}, but the level {level.label} has no single number: give it under "
        f"[simulation.levels.{factor}], for example {level.label} = {{ {parameter} = 0.038 }}."
    )


def _sourced(start: Scene, given: Mapping[str, tuple[float, str]], assumed: tuple[str, ...]) -> Scene:
    """Set the values with their sources; what is named as assumed has none, and keeps the scene's reason."""
    from simulator.scene import Value

    scene = start.changed({parameter: value for parameter, (value, _source) in given.items()})
    values = {parameter: Value(scene[parameter], source) for parameter, (_value, source) in given.items()}
    for parameter in assumed:
        known = start.values.get(parameter, Value(scene[parameter]))
        why = known.why or f"named as assumed in {IN_FILE}"
        values[parameter] = Value(scene[parameter], why=why, fitted_to=known.fitted_to)
    return replace(scene, values={**scene.values, **values})
