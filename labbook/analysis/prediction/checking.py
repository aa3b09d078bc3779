"""Predictions held against measurements: of every condition's mean, and of savings, for the runs as they were made.

The difference is divided by the expanded uncertainty of both, the error ratio E_n of ISO 13528: of the measured value
the half width of its 95 % interval on the side of the prediction, of the prediction two standard uncertainties, added
in quadrature. They agree where the ratio lies within -1 to 1.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from data_schema.outcomes import Outcome
from data_schema.queries.sources import InputRow
from data_schema.reasons import Reason
from data_schema.vocabulary import StudyKind, Undefined
from labbook.analysis.comparison.pairing import Pair, place, study_factor
from labbook.analysis.measured import Measured
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.prediction.condition_scenes import study_scene, unconverted_factors
from labbook.analysis.prediction.predicting import PredictionResult, error_parts, in_quadrature
from labbook.analysis.prediction.simulating import SIMULATED
from labbook.analysis.results import Algorithm, Results, result_fingerprint
from labbook.config.model import SimulationSettings
from labbook.config.parsing import Configuration
from reports.numbers import Number, Value
from reports.results import (
    COVERAGE_FACTOR,
    POOLED,
    AssumedInput,
    ConditionSummary,
    Decision,
    Judged,
    PredictedQuantity,
    Prediction,
    PredictionCheck,
    Predictions,
)
from stats.tails import t_quantile

if TYPE_CHECKING:
    from simulator.steady.published_results import PublishedResult


def agreement(measured: Number, value: Value, error: Value) -> tuple[Number, Number]:
    """Return the difference and the error ratio."""
    if isinstance(value, Undefined) or isinstance(measured.value, Undefined):
        none = value if isinstance(value, Undefined) else measured.value
        return Number(none, measured.unit), Number(none, "1")
    difference = value - measured.value
    return Number(difference, measured.unit), Number(_ratio(measured, measured.value, difference, error), "1")


def _ratio(measured: Number, value: float, difference: float, error: Value) -> Value:
    end = measured.ci_high if difference > 0.0 else measured.ci_low
    if not isinstance(end, float):
        return Undefined(Reason.MEASURED_WITHOUT_INTERVAL)
    if isinstance(error, Undefined):
        return error
    expanded = math.hypot(_to_95_percent(measured) * (end - value), COVERAGE_FACTOR * error)
    return difference / expanded if expanded > 0.0 else Undefined(Reason.BOTH_EXACT)


def _to_95_percent(measured: Number) -> float:
    """Return by what an interval of another level is multiplied to be one of 95 %."""
    if not isinstance(measured.df, float) or measured.ci_level == 0.95:
        return 1.0
    return t_quantile(0.95, measured.df) / t_quantile(measured.ci_level, measured.df)


ALGORITHM = Algorithm("prediction_check", 8)

AllPredicted = Mapping[tuple[str, str], PredictionResult]
"""Predictions by a condition's key and a robot's uid."""

Side = Sequence[tuple[PredictionResult, int]]
"""Predictions with the number of runs that each stands for."""

_PREDICTED = {outcome: PredictedQuantity(outcome) for outcome in SIMULATED}


def check_conditions(
    computed: Results,
    conditions: Sequence[ConditionValues],
    predicted: AllPredicted,
    quantity: Outcome,
    swept: str | None,
) -> list[Prediction]:
    """Compute the check of every condition's mean against its prediction; nothing where nothing was predicted."""
    return [
        Prediction(
            _PREDICTED[quantity],
            {factor: label for factor, label in condition.levels.items() if factor != swept},
            condition.levels.get(swept or "", ""),
            condition.is_control,
            len(condition.runs),
            condition.result.mean,
            computed.record(
                ALGORITHM,
                {"quantity": str(_PREDICTED[quantity]), "condition": condition.key},
                (result_fingerprint("measured", condition.result), *inputs_of("predicted", side)),
                _check_mean(condition.result, side, quantity),
                {"runs": [runs for _one, runs in side]},
            ),
        )
        for condition in (conditions if predicted else ())
        for side in [side_of([condition], predicted)]
    ]


def check_savings(
    computed: Results, compared: Sequence[tuple[Pair, Decision]], predicted: AllPredicted
) -> list[Prediction]:
    """Compute the check of measured savings: each level's, and all levels' pooled; nothing without predictions.

    `compared` has the savings that the report claims.
    """
    return [
        Prediction(
            PredictedQuantity.SAVINGS,
            pair.group,
            pair.level,
            False,
            measured.n_control + measured.n_treatment,
            measured.savings,
            computed.record(
                ALGORITHM,
                {"quantity": str(PredictedQuantity.SAVINGS), "label": pair.label},
                (
                    result_fingerprint("measured", measured),
                    *inputs_of("control", control),
                    *inputs_of("treatment", treated),
                ),
                _check_savings(measured.savings, control, treated),
                {"runs": [[runs for _one, runs in side] for side in (control, treated)]},
            ),
        )
        for pair, measured in (compared if predicted else ())
        if measured.savings is not None
        for control, treated in [(side_of(pair.a, predicted), side_of(pair.b, predicted))]
    ]


def side_of(conditions: Sequence[ConditionValues], predicted: AllPredicted) -> Side:
    """Return the predictions that stand for conditions as they were run, each with the number of its runs."""
    counts = Counter((item.run.condition_key, item.run.robot_uid) for one in conditions for item in one.runs)
    return [(predicted[where], runs) for where, runs in counts.items()]


def inputs_of(role: str, side: Side) -> Iterator[InputRow]:
    """Name the predictions of a side."""
    return (result_fingerprint(role, one) for one, _runs in side)


def _check_mean(measured: ConditionSummary, side: Side, quantity: Outcome) -> PredictionCheck:
    """Predict the mean of a condition's runs, and hold the measured mean against it."""
    value, finer = mean_of(values_of_side(side, quantity)), mean_of(_finer(side, quantity))
    accuracy_part = 0.0 if value is None else accuracy_of([side]) * abs(value)
    otherwise = varied_means([side], quantity, lambda means: means[0])
    return _check(measured.mean, value, finer, accuracy_part, otherwise, [side])


def _check_savings(savings: Number, control: Side, treated: Side) -> PredictionCheck:
    """Predict the savings of the runs as they were made: joules of each side are the mean over its runs."""
    sides = [control, treated]
    value = _percent([mean_of(values_of_side(side, Outcome.JOULES)) for side in sides])
    finer = _percent([mean_of(_finer(side, Outcome.JOULES)) for side in sides])
    # a relative error in both sides, as it comes out in a ratio of the two
    accuracy_part = 0.0 if value is None else math.sqrt(2.0) * accuracy_of(sides) * abs(100.0 - value)
    otherwise = varied_means(sides, Outcome.JOULES, _percent)
    return _check(savings, value, finer, accuracy_part, otherwise, sides)


def _check(
    measured: Number,
    value: float | None,
    finer: float | None,
    accuracy_part: float,
    otherwise: Mapping[str, Sequence[float | None]],
    sides: Sequence[Side],
) -> PredictionCheck:
    """Put the prediction with its error and its parts beside what was measured."""
    if value is None:
        ends = sorted({one.outcome for side in sides for one, _runs in side if one.value(Outcome.JOULES) is None})
        none = Undefined(Reason.SIMULATED_CONTROL_FREE)
        if ends:
            none = Undefined(Reason.SIMULATED_ENDS_OTHERWISE, ends=", ".join(ends))
        return PredictionCheck(Number(none, measured.unit), *agreement(measured, none, none), {}, None)
    parts = error_parts(value, accuracy_part, otherwise)
    error = in_quadrature(parts)
    return PredictionCheck(
        Number(value, measured.unit, se=error),
        *agreement(measured, value, error),
        {source: Number(part, measured.unit) for source, part in parts.items()},
        None if finer is None else max(abs(value - finer), sys.float_info.epsilon * abs(value)),
    )


def varied_means(
    sides: Sequence[Side], quantity: Outcome, of_means: Callable[[list[float | None]], float | None]
) -> dict[str, list[float | None]]:
    """Return the value under each variation: a parameter has one value in all conditions, so all sides change."""
    sources = dict.fromkeys(source for side in sides for one, _runs in side for source in one.otherwise)
    several = {
        source: max(len(one.varied(quantity).get(source, ())) for side in sides for one, _runs in side)
        for source in sources
    }
    return {
        source: [
            of_means([mean_of(values_of_side(side, quantity, source, place)) for side in sides])
            for place in range(count)
        ]
        for source, count in several.items()
    }


def values_of_side(side: Side, quantity: Outcome, source: str = "", place: int = 0) -> list[tuple[float | None, int]]:
    """Return each prediction's value, varied where the source of an error is named and it has one, with its runs."""
    found = []
    for one, runs in side:
        varied = one.varied(quantity).get(source)
        found.append((one.value(quantity) if varied is None else varied[place], runs))
    return found


def _finer(side: Side, quantity: Outcome) -> list[tuple[float | None, int]]:
    return [(one.finer[quantity], runs) for one, runs in side]


def mean_of(values: Sequence[tuple[float | None, int]]) -> float | None:
    """Return the mean over runs, None where a prediction has no value."""
    known = [(value, runs) for value, runs in values if value is not None]
    if len(known) < len(values):
        return None
    return math.fsum(value * runs for value, runs in known) / sum(runs for _value, runs in known)


def _percent(joules: Sequence[float | None]) -> float | None:
    control_j, treated_j = joules
    if control_j is None or treated_j is None or control_j <= 0.0:
        return None
    return 100.0 * (1.0 - treated_j / control_j)


def accuracy_of(sides: Sequence[Side]) -> float:
    """Return the largest relative error of the simulations."""
    return max(one.relative_error for side in sides for one, _runs in side)


def study_predictions(
    measured: Measured,
    swept: str | None,
    predicted: AllPredicted,
    checked: Sequence[Prediction],
    judged: Sequence[Judged],
) -> Predictions:
    """Return what was predicted and what came of it; nothing where no scene is named or nothing was measured.

    Predictions are in the order in which conditions are shown, what is pooled after its levels.
    """
    evidence, found = measured.evidence, list(predicted.values())
    settings = evidence.configuration.simulation
    if settings is None or not found:
        return Predictions()
    from simulator.declared import all_parameters

    labels = evidence.labels
    levels = labels.get(swept or "", [])

    def shown_at(item: Prediction) -> tuple[int, list[int], int]:
        level = levels.index(item.level) if item.level in levels else len(levels)
        return list(PredictedQuantity).index(item.quantity), place(labels, swept, item.group), level

    def conditions(holds: Callable[[PredictionResult], bool]) -> int:
        """Count the conditions for which something holds of the prediction with any robot."""
        return len({key for (key, _robot), one in predicted.items() if holds(one)})

    used = {name for one in measured.every_condition for name in one.levels}
    return Predictions(
        scene=found[0].scene,
        accuracy=settings.accuracy,
        effects=found[0].effects,
        unmapped=tuple(
            study_factor(evidence.configuration, name).title
            for name in labels
            if name in used and name not in {*settings.factors, *settings.levels}
        ),
        unconverted=unconverted_factors(evidence.configuration, evidence.factors),
        units={factor: all_parameters()[name].unit for factor, name in settings.factors.items()},
        items=tuple(
            replace(
                item, published=_published(evidence.configuration, swept, measured.conditions[Outcome.JOULES], item)
            )
            for item in sorted(checked, key=shown_at)
        ),
        judged=tuple(judged),
        assumed=_assumed(settings, evidence.configuration.study.name, found, checked),
        branched=conditions(lambda one: one.branched),
        on_edge=conditions(lambda one: one.close_decision and not one.branched),
        grown=conditions(lambda one: one.relative_error > one.accuracy),
        under_surface=conditions(lambda one: one.under_surface),
        open_book=conditions(lambda one: one.open_book),
        ends_otherwise=conditions(lambda one: one.ends_otherwise),
    )


_WITH_FOOT = {StudyKind.BED: True, StudyKind.EMULATOR: False}
"""Studies of which single conditions are published, and whether a foot was varied."""


def _published(
    configuration: Configuration, swept: str | None, conditions: Sequence[ConditionValues], item: Prediction
) -> PublishedResult | None:
    """Return what the thesis has of the apex or saving at these gains, and on the bed with this foot, if anything.

    `conditions` are those with joules.
    """
    from simulator.steady.published_results import result_of

    factors = {} if configuration.simulation is None else configuration.simulation.factors
    of_parameter = {parameter: factor for factor, parameter in factors.items()}
    gain, foot = of_parameter.get("k_extension", ""), of_parameter.get("foot_radius", "")
    if _WITH_FOOT.get(configuration.study.kind) is not (foot in item.group):
        return None
    if swept is None or of_parameter.get("b_ad") != swept or not {gain, swept} <= configuration.gains.keys():
        return None
    of_apex = item.quantity is PredictedQuantity.APEX
    if not (of_apex or item.quantity is PredictedQuantity.SAVINGS) or not item.group.keys() <= {gain, foot}:
        return None
    of_group = [one for one in conditions if item.group.items() <= one.levels.items()]
    pooled = [one.levels[swept] for one in of_group if not one.is_control]
    damping_gains = tuple(sorted(map(float, pooled if item.level == POOLED else [item.level])))
    return result_of(item.group.get(foot, ""), float(item.group[gain]), damping_gains, of_apex=of_apex)


def _assumed(
    settings: SimulationSettings, study: str, predicted: Sequence[PredictionResult], checked: Sequence[Prediction]
) -> tuple[AssumedInput, ...]:
    """Return every assumed input, with the most that varying it changed in any condition; robots may have their own."""
    fitted = {name for name, value in study_scene(settings).values.items() if value.fitted_to == study}
    inputs = {(name, about.value): about for one in predicted for name, about in one.assumed.items()}
    return tuple(
        AssumedInput(
            name,
            about,
            {quantity: _most(checked, quantity, name) for quantity in PredictedQuantity},
            fitted=name in fitted,
        )
        for (name, _value), about in sorted(inputs.items(), key=lambda item: item[0])
    )


def _most(checked: Sequence[Prediction], quantity: PredictedQuantity, source: str) -> Value | None:
    """Return the largest part of an error by a source; undefined where one of them is, None where there is none."""
    errors = [item.check.errors for item in checked if item.quantity is quantity]
    values = [parts[source].value for parts in errors if source in parts]
    undefined = next((value for value in values if isinstance(value, Undefined)), None)
    if undefined is not None:
        return undefined
    return max((value for value in values if isinstance(value, float)), default=None)
