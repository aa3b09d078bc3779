"""The whole analysis of a selection: from facts and logs to every number that a report shows."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import Compared, analyses_of_variance, compare_all, unselected_conditions
from labbook.analysis.comparison.contrasts import contrast_means
from labbook.analysis.comparison.deciding import Overall, overall_effects
from labbook.analysis.comparison.order import (
    ADJUSTED,
    OVER_GROUPS,
    adjusted_for_position,
    favoured_by_order,
    fingerprints_of_positions,
)
from labbook.analysis.comparison.robustness import Variations, vary
from labbook.analysis.outcomes.budget import budget, pack_deviations
from labbook.analysis.outcomes.conditions import ConditionValues, condition_values, measure_all, number_of
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import Judgement, RunApexes, as_protocol, run_apexes
from labbook.analysis.outcomes.run_energy import passive_drains, run_energies
from labbook.analysis.prediction.bias import judge
from labbook.analysis.prediction.checking import check_conditions, check_savings
from labbook.analysis.prediction.hypotheses import judge_hypotheses
from labbook.analysis.prediction.predicting import PredictionResult, predictions
from labbook.analysis.prediction.simulating import ALWAYS, SIMULATED
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from labbook.analysis.results import Results, RunResults
from labbook.analysis.study_data import StudyData
from reports.content import Anova, Drain, Hypothesis, JouleBudget, Judged, MeansContrast, PackDeviation, Prediction
from reports.numbers import Result
from stats.days.order import PositionsCompared


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured of the runs of a selection, before anything is compared.

    By run uid, `judgements` says which jumps count and `apexes` what that gives; `results` and `conditions` have the
    outcomes that every run is expected to have, and those that any of its runs has.
    """

    evidence: StudyData
    drains: dict[str, Drain]
    judgements: Mapping[str, Judgement]
    apexes: Mapping[str, RunApexes]
    results: dict[Outcome, RunResults[Result]]
    conditions: dict[Outcome, list[ConditionValues]]


@dataclass(frozen=True, slots=True)
class StudyAnalysis(Measured):
    """Everything computed for one selection.

    `favoured` are the headlines that the order within days favours, and `overall_adjusted` the effects over groups
    adjusted for it, where it favours those.
    """

    planned: Planned
    swept: str | None
    compared: list[Compared]
    anovas: list[Anova]
    variations: Variations
    overall: Overall
    contrasts: list[MeansContrast]
    favoured: Mapping[str, PositionsCompared]
    overall_adjusted: Overall
    packs: dict[str, PackDeviation]
    budget: JouleBudget | None
    predicted: dict[tuple[str, str], PredictionResult]
    checked: list[Prediction]
    biases: list[Judged]
    hypotheses: list[Hypothesis]


def _results(
    computed: Results, detections: Detections, evidence: StudyData, known: Mapping[Outcome, RunResults[Result]]
) -> dict[Outcome, RunResults[Result]]:
    """Measure the other outcomes, and leave out those that no run has and none is expected to have."""
    others = [outcome for outcome in Outcome if outcome not in known]
    every = {**known, **measure_all(others, computed, detections, evidence)}
    return {
        outcome: replace(found, missing=evidence.reasons(found.missing, outcome.source))
        for outcome, found in every.items()
        if outcome.of_every_run
        or any(isinstance(number_of(one, outcome).value, float) for one in found.results.values())
    }


def measure_study(
    computed: Results, detections: Detections, evidence: StudyData, progress: Callable[[str], None]
) -> Measured:
    """Compute every outcome of every run, and each condition's mean; `progress` is called with what is being done."""
    progress("passive drain and joules a jump")
    drains = passive_drains(computed, evidence)
    energies = run_energies(computed, evidence, drains)
    progress("apex heights")
    apexes = run_apexes(computed, detections, evidence, as_protocol(evidence))
    results = _results(computed, detections, evidence, {Outcome.JOULES: energies, Outcome.APEX: apexes})
    selected = computed.about(selection=evidence.selection)
    conditions = {
        outcome: condition_values(selected, evidence.runs, found.results, outcome) for outcome, found in results.items()
    }
    return Measured(evidence, drains, apexes.judgements, apexes.results, results, conditions)


def analyse(
    computed: Results,
    detections: Detections,
    evidence: StudyData,
    progress: Callable[[str], None],
    level: float | None = None,
) -> StudyAnalysis:
    """Compute everything; `progress` is called with what is being done.

    `level` is that of the comparisons' intervals, and alpha of their tests follows; without it they are as planned.
    """
    planned = planned_analysis(
        detections.connection, evidence.configuration, frozenset(run.uid for run in evidence.selected)
    )
    settings = planned.settings
    if level is not None and not math.isclose(level, 1.0 - settings.outside):
        settings = replace(settings, alpha=settings.alpha * (1.0 - level) / settings.outside)
        planned = replace(planned, settings=settings)
    measured = measure_study(computed, detections, evidence, progress)
    results, conditions = measured.results, measured.conditions
    progress("comparisons")
    selected = computed.about(selection=evidence.selection)
    swept = pairing.swept_factor(evidence.configuration)
    packs = pack_deviations(selected, conditions[Outcome.JOULES])
    of_a_joule = budget(selected, evidence, conditions[Outcome.JOULES])
    keys = list(dict.fromkeys(item.key for several in conditions.values() for item in several))
    simulated = [outcome for outcome in SIMULATED if outcome in ALWAYS or conditions.get(outcome)]
    predicted = predictions(computed, detections.connection, evidence, keys, progress, simulated)
    checks = {
        outcome: check_conditions(selected, conditions[outcome], predicted, outcome, swept)
        for outcome in simulated
        if predicted
    }
    biases = [one for outcome, found in checks.items() for one in judge(selected, conditions[outcome], found, outcome)]
    compared: list[Compared] = []
    anovas: list[Anova] = []
    contrasts: list[MeansContrast] = []
    favoured: Mapping[str, PositionsCompared] = {}
    effects, adjusted_effects, variations = Overall(), Overall(), Variations()
    if swept is not None:
        beside = unselected_conditions(computed, detections, evidence, conditions) if planned.stated else {}
        compared = compare_all(selected, conditions, swept, planned, evidence.configuration.study.kind, beside)
        anovas = [
            anova
            for quantity, several in conditions.items()
            for anova in analyses_of_variance(selected, several, swept, quantity)
        ]
        pooled = {outcome: pairing.pairs_pooled(several, swept) for outcome, several in conditions.items()}
        effects = overall_effects(selected, pooled, settings)
        values = pairing.treated_values(evidence.configuration, swept)
        contrasts = contrast_means(selected, conditions, swept, values, planned, selected=bool(evidence.selection))
        every = (pair for pairs in pooled.values() for pair in pairs)
        over_groups = bool(effects.savings) or effects.equivalent is not None
        favoured = favoured_by_order(every, over_groups=over_groups)
        if OVER_GROUPS in favoured:
            adjusted = {outcome: adjusted_for_position(pairs) for outcome, pairs in pooled.items()}
            known = {outcome: pairs for outcome, pairs in adjusted.items() if not isinstance(pairs, Undefined)}
            of_variant = selected.about(variant=ADJUSTED)
            adjusted_effects = overall_effects(of_variant, known, settings, fingerprints_of_positions)
        progress("what the headlines depend on")
        variations = vary(computed, detections, evidence, measured.drains, results, conditions, swept, settings)
    hypotheses = tuple(evidence.configuration.hypotheses.values())
    judged = judge_hypotheses(selected, hypotheses, conditions, compared, predicted, swept or "", settings)
    of_savings = [(item.pair, item.shown.decision) for item in compared if item.shown.quantity is Outcome.JOULES]
    checked = [one for several in checks.values() for one in several]
    return StudyAnalysis(
        evidence=evidence,
        planned=planned,
        drains=measured.drains,
        judgements=measured.judgements,
        apexes=measured.apexes,
        results=results,
        conditions=conditions,
        swept=swept,
        compared=compared,
        anovas=anovas,
        variations=variations,
        overall=effects,
        contrasts=contrasts,
        favoured=favoured,
        overall_adjusted=adjusted_effects,
        packs=packs,
        budget=of_a_joule,
        predicted=predicted,
        checked=[*checked, *check_savings(selected, of_savings, predicted)],
        biases=biases,
        hypotheses=judged,
    )
