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

from data_schema.outcomes import Outcome
from data_schema.queries.sources import InputRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.prediction.predicting import PredictionResult, error_parts, in_quadrature
from labbook.analysis.prediction.simulating import SIMULATED
from labbook.analysis.results import Algorithm, Results, result_fingerprint
from reports.content import (
    COVERAGE_FACTOR,
    ConditionSummary,
    Decision,
    PredictedQuantity,
    Prediction,
    PredictionCheck,
)
from reports.numbers import Number, Value
from stats.tails import t_quantile


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
