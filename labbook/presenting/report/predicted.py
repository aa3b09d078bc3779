"""Predictions beside measurements, as a report shows them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from data_schema.outcomes import Outcome
from data_schema.vocabulary import StudyKind, Undefined
from labbook.analysis.prediction.condition_scenes import study_scene, unconverted_factors
from labbook.analysis.prediction.predicting import PredictionResult
from labbook.analysis.study import StudyAnalysis
from labbook.config.model import SimulationSettings
from labbook.presenting.report.campaign import factor_title
from reports.evidence import POOLED
from reports.numbers import Value
from reports.predicted import (
    AssumedInput,
    Hypothesis,
    Judged,
    PredictedQuantity,
    Prediction,
    Predictions,
)

if TYPE_CHECKING:
    from simulator.steady.published_results import PublishedResult


def predictions(analysis: StudyAnalysis) -> Predictions:
    """Return what was predicted; nothing where the study names no scene or has nothing measured."""
    settings = analysis.evidence.configuration.simulation
    found = list(analysis.predicted.values())
    if settings is None or not found:
        return Predictions()
    from simulator.declared import all_parameters

    items = tuple(replace(item, published=_published(analysis, item)) for item in _in_order(analysis))
    measured = {name for several in analysis.conditions.values() for item in several for name in item.levels}
    mapped = {*settings.factors, *settings.levels}
    return Predictions(
        scene=found[0].scene,
        accuracy=settings.accuracy,
        effects=found[0].effects,
        unmapped=tuple(
            factor_title(analysis, row.name)
            for row in analysis.evidence.factors
            if row.name in measured and row.name not in mapped
        ),
        unconverted=unconverted_factors(analysis.evidence.configuration, analysis.evidence.factors),
        units={factor: all_parameters()[name].unit for factor, name in settings.factors.items()},
        items=items,
        judged=_judged(analysis),
        assumed=_assumed(analysis, settings),
        branched=_conditions(analysis, lambda one: one.branched),
        on_edge=_conditions(analysis, lambda one: one.close_decision and not one.branched),
        grown=_conditions(analysis, lambda one: one.relative_error > one.accuracy),
        under_surface=_conditions(analysis, lambda one: one.under_surface),
        open_book=_conditions(analysis, lambda one: one.open_book),
        ends_otherwise=_conditions(analysis, lambda one: one.ends_otherwise),
    )


def hypotheses(analysis: StudyAnalysis) -> tuple[Hypothesis, ...]:
    """Return the study's hypotheses, each with its comparisons in the order of groups."""
    return tuple(
        replace(one, parts=tuple(sorted(one.parts, key=lambda part: _place(analysis, part.of))))
        for one in analysis.hypotheses
    )


def _conditions(analysis: StudyAnalysis, holds: Callable[[PredictionResult], bool]) -> int:
    """Count the conditions for which something holds of the prediction with any robot."""
    return len({key for (key, _robot), one in analysis.predicted.items() if holds(one)})


def _in_order(analysis: StudyAnalysis) -> list[Prediction]:
    """Sort as conditions are shown: by the factors' levels, the swept one last, what is pooled after its levels."""
    swept = [level.label for row in analysis.evidence.factors if row.name == analysis.swept for level in row.levels]

    def place(item: Prediction) -> tuple[int, list[int], int]:
        level = swept.index(item.level) if item.level in swept else len(swept)
        return list(PredictedQuantity).index(item.quantity), _place(analysis, item.group), level

    return sorted(analysis.checked, key=place)


def _place(analysis: StudyAnalysis, group: Mapping[str, str]) -> list[int]:
    """Return where a group stands among all, by the levels of each factor that is not swept."""
    labels = {row.name: [level.label for level in row.levels] for row in analysis.evidence.factors}
    return [
        known.index(group[name]) if name in group else -1 for name, known in labels.items() if name != analysis.swept
    ]


_WITH_FOOT = {StudyKind.BED: True, StudyKind.EMULATOR: False}
"""Studies of which single conditions are published, and whether a foot was varied."""


def _published(analysis: StudyAnalysis, item: Prediction) -> PublishedResult | None:
    """Return what the thesis has of the apex or saving at these gains, and on the bed with this foot, if anything."""
    from simulator.steady.published_results import result_of

    configuration, swept = analysis.evidence.configuration, analysis.swept
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
    of_group = [one for one in analysis.conditions[Outcome.JOULES] if item.group.items() <= one.levels.items()]
    pooled = [one.levels[swept] for one in of_group if not one.is_control]
    damping_gains = tuple(sorted(map(float, pooled if item.level == POOLED else [item.level])))
    return result_of(item.group.get(foot, ""), float(item.group[gain]), damping_gains, of_apex=of_apex)


def _judged(analysis: StudyAnalysis) -> tuple[Judged, ...]:
    return tuple(
        replace(one, groups=tuple(sorted(one.groups, key=lambda each: _place(analysis, each.group))))
        for one in analysis.biases
    )


def _assumed(analysis: StudyAnalysis, settings: SimulationSettings) -> tuple[AssumedInput, ...]:
    """Return every assumed input, with the most that varying it changed in any condition."""
    study = analysis.evidence.configuration.study.name
    fitted = {name for name, value in study_scene(settings).values.items() if value.fitted_to == study}
    inputs = {name: about for one in analysis.predicted.values() for name, about in one.assumed.items()}
    return tuple(
        AssumedInput(
            name,
            about.value,
            about.unit,
            about.why,
            about.varied_by,
            {quantity: _most(analysis, quantity, name) for quantity in PredictedQuantity},
            fitted=name in fitted,
        )
        for name, about in sorted(inputs.items())
    )


def _most(analysis: StudyAnalysis, quantity: PredictedQuantity, source: str) -> Value | None:
    """Return the largest part of an error by a source; undefined where one of them is, None where there is none."""
    checks = [item.check.errors for item in analysis.checked if item.quantity is quantity]
    values = [errors[source].value for errors in checks if source in errors]
    undefined = next((value for value in values if isinstance(value, Undefined)), None)
    if undefined is not None:
        return undefined
    return max((value for value in values if isinstance(value, float)), default=None)
