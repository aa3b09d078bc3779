"""What a simulation gives for each condition and robot: joules a jump, apex height and plate numbers, with errors.

The error has three kinds of parts, added in quadrature: the accuracy asked of the simulator, or what rounding grows to
where that is more; each assumed parameter raised and lowered by the part that the study states (the larger of the two
changes counts); and the other branch of a jump that hangs on a knife's edge, where it was simulated. Their sum is taken
as one standard uncertainty. Each condition is also simulated a hundred times finer, which says how far the simulation
itself errs; the value is that of the accuracy asked for.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import sqlalchemy as sa

from data_schema.errors import unknown_name
from data_schema.file_cache import FileCache
from data_schema.journal import canonical
from data_schema.outcomes import Outcome
from data_schema.queries.facts import read_fact
from data_schema.queries.runs import RunRow
from data_schema.queries.sources import InputRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.prediction.condition_scenes import (
    ROBOT_PARAMETERS,
    condition_scene,
    study_scene,
)
from labbook.analysis.prediction.simulating import (
    ALWAYS,
    SIMULATING,
    Simulated,
    mean_values,
    simulate_means,
    simulate_varied,
)
from labbook.analysis.results import Algorithm, Results, condition_input, fingerprint
from labbook.analysis.study_data import StudyData
from labbook.config.model import SimulationSettings
from reports.numbers import Number, NumberNames, Result
from reports.results import ACCURACY, AssumedParameter

if TYPE_CHECKING:
    from simulator.scene import Scene


def error_parts(
    value: float, accuracy_part: float, otherwise: Mapping[str, Sequence[float | None]]
) -> dict[str, float | Undefined]:
    """Return the parts of a predicted value's error: the accuracy's, and the largest change under each variation."""
    parts: dict[str, float | Undefined] = {ACCURACY: accuracy_part}
    for source, values in otherwise.items():
        known = [other for other in values if other is not None]
        parts[source] = (
            max(abs(other - value) for other in known)
            if len(known) == len(values)
            else Undefined(Reason.VARIED_WITHOUT_JUMP, source=source)
        )
    return parts


def in_quadrature(parts: Mapping[str, float | Undefined]) -> float | Undefined:
    """Add the parts of an error in quadrature; undefined where one of them is."""
    known = [part for part in parts.values() if not isinstance(part, Undefined)]
    undefined = next((part for part in parts.values() if isinstance(part, Undefined)), None)
    return math.hypot(*known) if undefined is None else undefined


_BRANCH = "other branch"
"""The part of an error that is due to a decision on a knife's edge, beside the assumed parameters."""


@dataclass(frozen=True, slots=True)
class PredictionResult(Result):
    """A prediction of one condition with one robot: its values, also under everything that was varied.

    `predicted` has the numbers by the names of their outcomes' numbers; `values`, and those that came of each variation
    (`otherwise`, by what was varied), are by outcome, None where the jump has no apex. `outcome` says how the simulated
    jump ended. `close_decision`, `under_surface` and `open_book` are those of `Simulated`;
    `relative_error` is the accuracy, or what rounding grows to where that is more. `finer` has the values of a
    simulation a hundred times finer.
    """

    predicted: Annotated[Mapping[str, Number], NumberNames("predicted_{}")]
    scene: str
    scene_toml: str
    effects: tuple[str, ...]
    accuracy: float
    relative_error: float
    outcome: str
    close_decision: bool
    under_surface: bool
    open_book: bool
    assumed: Mapping[str, AssumedParameter]
    values: Mapping[str, float | None]
    finer: Mapping[str, float | None]
    otherwise: Mapping[str, tuple[Mapping[str, float | None], ...]]

    def value(self, quantity: Outcome) -> float | None:
        """Return the predicted value."""
        return self.values[quantity]

    def varied(self, quantity: Outcome) -> dict[str, list[float | None]]:
        """Return, by what was varied, the values that came of it."""
        return {source: [one[quantity] for one in several] for source, several in self.otherwise.items()}

    @property
    def branched(self) -> bool:
        """Whether the other branch of a decision on a knife's edge was simulated, too."""
        return _BRANCH in self.otherwise

    @property
    def ends_otherwise(self) -> bool:
        """Whether only one of both simulations, to the accuracy and finer, comes to an apex."""
        return any((value is None) != (self.finer[name] is None) for name, value in self.values.items())


ALGORITHM = Algorithm("prediction", 18)


@dataclass(frozen=True, slots=True)
class WantedPrediction:
    """A prediction that is wanted: of what, from what, under which settings, and how to get it."""

    scope: Mapping[str, Any]
    inputs: tuple[InputRow, ...]
    settings: Mapping[str, Any]
    compute: Callable[[], PredictionResult]

    @property
    def name(self) -> str:
        """The name of the file of the cache that holds its simulations."""
        return _name(self.settings)


def predictions(
    computed: Results,
    connection: sa.Connection,
    evidence: StudyData,
    keys: Collection[str],
    progress: Callable[[str], None],
    outcomes: Sequence[Outcome],
) -> dict[tuple[str, str], PredictionResult]:
    """Return a prediction for each condition that is named by its key and each robot that ran it, by key and robot uid.

    `outcomes` are predicted, of `SIMULATED`. Empty where the study names no scene.
    """
    wanted = _wanted(connection, evidence, set(keys), outcomes)
    if not all(SIMULATIONS.has(one.name) for one in wanted.values()):
        progress(SIMULATING)
        SIMULATIONS.forget_unused()
    return {
        place: computed.record(ALGORITHM, one.scope, one.inputs, one.compute(), one.settings)
        for place, one in wanted.items()
    }


def _wanted(
    connection: sa.Connection, evidence: StudyData, keys: Collection[str], outcomes: Sequence[Outcome]
) -> dict[tuple[str, str], WantedPrediction]:
    settings = evidence.configuration.simulation
    if settings is None or not keys:
        return {}
    start = study_scene(settings)
    wanted = {(run.condition_key, run.robot_uid): run for run in evidence.runs if run.condition_key in keys}
    facts = {
        uid: read_fact(connection, "robot", uid, list(ROBOT_PARAMETERS.values()))
        for uid in sorted({uid for _key, uid in wanted})
    }
    return {
        (key, uid): _prediction(evidence, settings, start, run, facts[uid], outcomes)
        for (key, uid), run in wanted.items()
    }


def _prediction(
    evidence: StudyData,
    settings: SimulationSettings,
    start: Scene,
    run: RunRow,
    facts: Mapping[str, float],
    outcomes: Sequence[Outcome],
) -> WantedPrediction:
    from simulator.scene_file import write_scene

    scene = condition_scene(start, evidence.configuration, evidence.factors, run.levels, (run.robot, facts))
    unvaried = [name for name in settings.varied if name not in _unsourced(scene)]
    if unvaried:
        raise unknown_name("assumed parameter of this scene", unvaried[0], _unsourced(scene))
    about = {
        "scene": write_scene(scene),
        "accuracy": settings.accuracy,
        "varied_by": _parts(settings, scene),
        **({"outcomes": list(map(str, outcomes))} if tuple(outcomes) != ALWAYS else {}),
    }
    return WantedPrediction(
        {"condition": run.condition_key, "robot": run.robot, "scene": start.name},
        (
            condition_input(run),
            fingerprint("robot", "robot_body", run.robot_uid, repr(sorted(facts.items()))),
            InputRow("scene", "scene", start.name, _sha256(settings.scene_toml or write_scene(start))),
        ),
        about,
        lambda: _predicted(scene, settings, outcomes, _name(about)),
    )


def _unsourced(scene: Scene) -> tuple[str, ...]:
    """Return the parameters to vary: also those that a scene of one's own has as set by who used another."""
    return scene.assumed + scene.set_by_user


def _parts(settings: SimulationSettings, scene: Scene) -> dict[str, float]:
    """Return the part by which each assumed parameter is varied."""
    return {name: settings.varied.get(name, settings.varied_by) for name in _unsourced(scene)}


@dataclass(frozen=True, slots=True)
class _Simulations:
    """A scene as it is, with what was varied (`otherwise`, by what), and a hundred times finer."""

    found: Simulated
    otherwise: Mapping[str, tuple[Mapping[str, float | None], ...]]
    finer: Mapping[str, float | None]


SIMULATIONS = FileCache(
    "predictions",
    ("simulator/**/*.py", "labbook/analysis/prediction/*.py", "data_schema/outcomes.py", "data_schema/units.py"),
    ("numpy", "numba", "scipy"),
)


def _name(settings: Mapping[str, Any]) -> str:
    """Name the file of the cache that holds the simulations of these settings."""
    return _sha256(canonical(settings))


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _simulated(scene: Scene, settings: SimulationSettings, outcomes: Sequence[Outcome], name: str) -> _Simulations:
    """Return the simulations of a scene, from the cache where they are there."""
    if (cached := SIMULATIONS.read(name)) is not None:
        return msgspec.msgpack.decode(cached, type=_Simulations)
    from simulator.error_bars import simulate_finer
    from simulator.kernel.build import kernel_for

    kernel_for(scene.effects)
    found = simulate_means(scene, settings.accuracy, outcomes)
    otherwise = {
        varied: tuple(
            simulate_varied(scene, varied, 1.0 + sign * part, settings.accuracy, outcomes) for sign in (-1.0, 1.0)
        )
        for varied, part in _parts(settings, scene).items()
    }
    if found.branch is not None:
        otherwise[_BRANCH] = (found.branch,)
    finer = mean_values(scene, simulate_finer(scene, settings.accuracy).jumps, outcomes)
    simulations = _Simulations(found, otherwise, finer)
    SIMULATIONS.write(name, msgspec.msgpack.encode(simulations))
    return simulations


def _predicted(
    scene: Scene, settings: SimulationSettings, outcomes: Sequence[Outcome], name_in_cache: str
) -> PredictionResult:
    from simulator.declared import all_parameters
    from simulator.scene_file import write_scene

    simulations = _simulated(scene, settings, outcomes, name_in_cache)
    found, otherwise, parts = simulations.found, simulations.otherwise, _parts(settings, scene)
    error = max(settings.accuracy, found.rounding)
    predicted: dict[str, Number] = {}
    for quantity in outcomes:
        value, name = found.values[quantity], quantity.number_name
        if value is None:
            none = Undefined(Reason.SIMULATED_ENDS_OTHERWISE, ends=found.outcome)
            predicted[name] = Number(none, quantity.unit)
        else:
            by_source = {source: [one[quantity] for one in several] for source, several in otherwise.items()}
            errors = error_parts(value, error * abs(value), by_source)
            predicted[name] = Number(value, quantity.unit, se=in_quadrature(errors))
    return PredictionResult(
        predicted=predicted,
        scene=scene.name,
        scene_toml=write_scene(scene),
        effects=tuple(sorted(scene.effects)),
        accuracy=settings.accuracy,
        relative_error=error,
        outcome=found.outcome,
        close_decision=found.close_decision,
        under_surface=found.under_surface,
        open_book=found.open_book,
        assumed={
            name: AssumedParameter(
                value=scene[name],
                unit=all_parameters()[name].unit,
                why=scene.values[name].why or "set where the scene was used",
                varied_by=part,
            )
            for name, part in parts.items()
        },
        values=dict(found.values),
        finer=simulations.finer,
        otherwise=otherwise,
    )
