"""Predictions beside measurements, as a report shows them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from data_schema.vocabulary import Undefined
from labbook.analysis.prediction.agreement import DIFFERENCE, RATIO, agrees
from labbook.analysis.prediction.checking import PREDICTED, Checked, error_by
from labbook.analysis.prediction.predicting import BRANCH, Predicted
from labbook.analysis.study import StudyAnalysis
from labbook.presenting.numbers import Shown
from labbook.presenting.report.design import factor_title
from reports.numbers import Value
from reports.predicted import AssumedInput, PredictedQuantity, Prediction, Predictions


def predictions(analysis: StudyAnalysis, shown: Shown) -> Predictions:
    """Return what was predicted; nothing where the study names no scene or has nothing measured."""
    settings = analysis.evidence.configuration.simulation
    found = list(analysis.predicted.values())
    if settings is None or not found:
        return Predictions()
    payload = found[0].payload
    measured = {name for several in analysis.conditions.values() for item in several for name in item.levels}
    mapped = {*settings.factors, *settings.levels}
    return Predictions(
        scene=payload["scene"],
        accuracy=settings.accuracy,
        effects=tuple(payload["effects"]),
        unmapped=tuple(
            factor_title(analysis, row.name)
            for row in analysis.evidence.factors
            if row.name in measured and row.name not in mapped
        ),
        items=tuple(_prediction(item, shown) for item in _in_order(analysis)),
        assumed=_assumed(analysis),
        branched=_conditions(analysis, lambda one: BRANCH in one.payload["otherwise"]),
        on_edge=_conditions(
            analysis, lambda one: one.payload["close_decision"] and BRANCH not in one.payload["otherwise"]
        ),
        grown=_conditions(analysis, lambda one: one.payload["relative_error"] > one.payload["accuracy"]),
        under_surface=_conditions(analysis, lambda one: one.payload["under_surface"]),
        open_book=_conditions(analysis, lambda one: one.payload["open_book"]),
    )


def _conditions(analysis: StudyAnalysis, holds: Callable[[Predicted], bool]) -> int:
    """Count the conditions for which something holds of the prediction with any robot."""
    return len({key for (key, _robot), one in analysis.predicted.items() if holds(one)})


def _in_order(analysis: StudyAnalysis) -> list[Checked]:
    """Sort as conditions are shown: by the factors' levels, the swept one last, what is pooled after its levels."""
    rows = [row for row in analysis.evidence.factors if row.name != analysis.swept]
    swept = [level.label for row in analysis.evidence.factors if row.name == analysis.swept for level in row.levels]
    labels = {row.name: [level.label for level in row.levels] for row in rows}

    def place(item: Checked) -> tuple[int, list[int], int]:
        group = [labels[row.name].index(item.group[row.name]) if row.name in item.group else -1 for row in rows]
        level = swept.index(item.level) if item.level in swept else len(swept)
        return list(PredictedQuantity).index(item.quantity), group, level

    return sorted(analysis.checked, key=place)


def _prediction(item: Checked, shown: Shown) -> Prediction:
    return Prediction(
        quantity=item.quantity,
        group=item.group,
        level=item.level,
        control=item.control,
        n=item.n,
        measured=shown.number(item.measured.result, item.measured.name),
        predicted=replace(shown.number(item.result, PREDICTED), n=None),
        difference=shown.number(item.result, DIFFERENCE),
        error_ratio=shown.value(item.result, RATIO),
        agrees=agrees(item.result),
    )


def _assumed(analysis: StudyAnalysis) -> tuple[AssumedInput, ...]:
    """Return every assumed input, with the most that varying it changed in any condition."""
    inputs = {name: about for one in analysis.predicted.values() for name, about in one.payload["assumed"].items()}
    return tuple(
        AssumedInput(
            name,
            about["value"],
            about["unit"],
            about["why"],
            about["varied_by"],
            *(_most(analysis, quantity, error_by(name)) for quantity in PredictedQuantity),
        )
        for name, about in inputs.items()
    )


def _most(analysis: StudyAnalysis, quantity: PredictedQuantity, name: str) -> Value | None:
    """Return the largest number of this name; undefined where one of them is, None where there is none."""
    results = [item.result for item in analysis.checked if item.quantity is quantity]
    rows = [item for result in results for item in result.numbers if item.name == name]
    reason = next((item.undefined_reason for item in rows if item.undefined_reason is not None), None)
    if reason is not None:
        return Undefined(reason)
    return max((item.value for item in rows if item.value is not None), default=None)
