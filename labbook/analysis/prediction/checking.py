"""Predictions held against measurements: of every condition's mean, and of savings, for the runs as they were made."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import InputRow, NumberRow, ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.prediction.agreement import agreement
from labbook.analysis.prediction.error import error_parts, in_all
from labbook.analysis.prediction.predicting import Predicted
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    number,
    result_fingerprint,
)
from reports.predicted import PredictedQuantity

ALGORITHM = Algorithm("prediction_check", 8)

PREDICTED = "predicted"
"""Name of a number of a check: what is predicted of the runs as they were made."""

AllPredicted = Mapping[tuple[str, str], Predicted]
"""Predictions by a condition's key and a robot's uid."""

Side = Sequence[tuple[Predicted, int]]
"""Predictions with the number of runs that each stands for."""

_PREDICTED = {Outcome.JOULES: PredictedQuantity.JOULES, Outcome.APEX: PredictedQuantity.APEX}


@dataclass(frozen=True, slots=True)
class NumberOf:
    """A number by its result and its name there."""

    result: ResultRow
    name: str


@dataclass(frozen=True, slots=True)
class Checked:
    """One quantity of a condition, or of a pair with its control: measured, predicted, and their difference."""

    quantity: PredictedQuantity
    group: Mapping[str, str]
    level: str
    control: bool
    n: int
    measured: NumberOf
    result: ResultRow


def check_conditions(
    cache: ResultCache,
    conditions: Sequence[ConditionValues],
    predicted: AllPredicted,
    quantity: Outcome,
    swept: str | None,
    scope: Mapping[str, Any],
) -> list[Checked]:
    """Ensure the check of every condition's mean against its prediction; nothing where nothing was predicted."""
    if not predicted:
        return []
    sides = [_side([condition], predicted) for condition in conditions]
    rows = cache.ensure(
        [
            Request(
                ALGORITHM,
                {"quantity": str(_PREDICTED[quantity]), "condition": condition.key, **scope},
                (result_fingerprint("measured", condition.result), *_inputs("predicted", side)),
                {"runs": [runs for _one, runs in side]},
                lambda condition=condition, side=side: _mean_outcome(condition.result, side, quantity),  # type: ignore[misc]
            )
            for condition, side in zip(conditions, sides, strict=True)
        ]
    )
    return [
        Checked(
            _PREDICTED[quantity],
            {factor: label for factor, label in condition.levels.items() if factor != swept},
            condition.levels.get(swept or "", ""),
            condition.is_control,
            len(condition.runs),
            NumberOf(condition.result, "mean"),
            row,
        )
        for condition, row in zip(conditions, rows, strict=True)
    ]


def check_savings(
    cache: ResultCache, compared: Sequence[tuple[Pair, ResultRow]], predicted: AllPredicted, scope: Mapping[str, Any]
) -> list[Checked]:
    """Ensure the check of measured savings: each level's, and all levels' pooled; nothing without predictions."""
    families = (pairing.EACH, pairing.POOLED)
    wanted = [(pair, row) for pair, row in compared if predicted and pair.with_savings and pair.family in families]
    sides = [(_side(pair.a, predicted), _side(pair.b, predicted)) for pair, _row in wanted]
    rows = cache.ensure(
        [
            Request(
                ALGORITHM,
                {"quantity": str(PredictedQuantity.SAVINGS), "label": pair.label, **scope},
                (result_fingerprint("measured", row), *_inputs("control", control), *_inputs("treatment", treated)),
                {"runs": [[runs for _one, runs in side] for side in (control, treated)]},
                lambda row=row, control=control, treated=treated: _savings_outcome(row, control, treated),  # type: ignore[misc]
            )
            for (pair, row), (control, treated) in zip(wanted, sides, strict=True)
        ]
    )
    return [
        Checked(
            PredictedQuantity.SAVINGS,
            pair.group,
            pair.level,
            False,
            sum(len(condition.runs) for condition in (*pair.a, *pair.b)),
            NumberOf(measured, "savings"),
            row,
        )
        for (pair, measured), row in zip(wanted, rows, strict=True)
    ]


def error_by(source: str) -> str:
    """Name the part of a prediction's error that one source has."""
    return f"{PREDICTED}, error by {source}"


def _side(conditions: Sequence[ConditionValues], predicted: AllPredicted) -> Side:
    """Return the predictions that stand for conditions as they were run, each with the number of its runs."""
    counts = Counter((item.run.condition_key, item.run.robot_uid) for one in conditions for item in one.runs)
    return [(predicted[where], runs) for where, runs in counts.items()]


def _inputs(role: str, side: Side) -> Iterator[InputRow]:
    return (result_fingerprint(role, one.result) for one, _runs in side)


def _mean_outcome(measured: ResultRow, side: Side, quantity: Outcome) -> Computed:
    """Predict the mean of a condition's runs, and hold the measured mean against it."""
    value = _mean(_values(side, quantity))
    accuracy_part = 0.0 if value is None else _accuracy([side]) * abs(value)
    otherwise = _varied([side], quantity, lambda means: means[0])
    return _outcome(number(measured, "mean"), value, accuracy_part, otherwise, [side])


def _savings_outcome(measured: ResultRow, control: Side, treated: Side) -> Computed:
    """Predict the savings of the runs as they were made: joules of each side are the mean over its runs."""
    sides = [control, treated]
    value = _percent([_mean(_values(side, Outcome.JOULES)) for side in sides])
    # a relative error in both sides, as it comes out in a ratio of the two
    accuracy_part = 0.0 if value is None else math.sqrt(2.0) * _accuracy(sides) * abs(100.0 - value)
    otherwise = _varied(sides, Outcome.JOULES, _percent)
    return _outcome(number(measured, "savings"), value, accuracy_part, otherwise, sides)


def _outcome(
    measured: NumberRow,
    value: float | None,
    accuracy_part: float,
    otherwise: Mapping[str, Sequence[float | None]],
    sides: Sequence[Side],
) -> Computed:
    """Put the prediction with its error and its parts beside what was measured."""
    if value is None:
        ends = sorted({one.ends for side in sides for one, _runs in side if one.value(Outcome.JOULES) is None})
        reason = f"the simulated jump ends otherwise: {', '.join(ends)}" if ends else "the simulated control is free"
        none = Undefined(reason)
        return Computed((NewNumber(PREDICTED, none, measured.unit), *agreement(measured, none, none)))
    parts = error_parts(value, accuracy_part, otherwise)
    error = in_all(parts)
    numbers = [NewNumber(PREDICTED, value, measured.unit, se=error)]
    numbers += [NewNumber(error_by(source), part, measured.unit) for source, part in parts.items()]
    return Computed((*numbers, *agreement(measured, value, error)))


def _varied(
    sides: Sequence[Side], quantity: Outcome, of_means: Callable[[list[float | None]], float | None]
) -> dict[str, list[float | None]]:
    """Return the value under each variation: a parameter has one value in all conditions, so all sides change."""
    sources = dict.fromkeys(source for side in sides for one, _runs in side for source in one.payload["otherwise"])
    several = {
        source: max(len(one.otherwise(quantity).get(source, ())) for side in sides for one, _runs in side)
        for source in sources
    }
    return {
        source: [of_means([_mean(_values(side, quantity, source, place)) for side in sides]) for place in range(count)]
        for source, count in several.items()
    }


def _values(side: Side, quantity: Outcome, source: str = "", place: int = 0) -> list[tuple[float | None, int]]:
    """Return each prediction's value, varied where the source of an error is named and it has one, with its runs."""
    found = []
    for one, runs in side:
        varied = one.otherwise(quantity).get(source)
        found.append((one.value(quantity) if varied is None else varied[place], runs))
    return found


def _mean(values: Sequence[tuple[float | None, int]]) -> float | None:
    known = [(value, runs) for value, runs in values if value is not None]
    if len(known) < len(values):
        return None
    return math.fsum(value * runs for value, runs in known) / sum(runs for _value, runs in known)


def _percent(joules: Sequence[float | None]) -> float | None:
    control_j, treated_j = joules
    if control_j is None or treated_j is None or control_j <= 0.0:
        return None
    return 100.0 * (1.0 - treated_j / control_j)


def _accuracy(sides: Sequence[Side]) -> float:
    return max(float(one.payload["relative_error"]) for side in sides for one, _runs in side)
