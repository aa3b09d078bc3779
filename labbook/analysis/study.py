"""The whole analysis of a selection: from facts and logs to every number that a report shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from data_schema.outcomes import Outcome
from data_schema.queries.results import ResultRow
from data_schema.vocabulary import FileRole
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparing import analyse_variance
from labbook.analysis.comparison.comparing_jumps import compare_jumps
from labbook.analysis.comparison.comparisons import Compared, compare_all
from labbook.analysis.comparison.robustness import Variations, vary
from labbook.analysis.comparison.unselected_comparisons import unselected_conditions_of
from labbook.analysis.outcomes.budget import budget
from labbook.analysis.outcomes.conditions import ConditionValues, condition_values, run_numbers
from labbook.analysis.outcomes.day_means import in_units, unit_scope
from labbook.analysis.outcomes.detections import Detections
from labbook.analysis.outcomes.packs import pack_deviations
from labbook.analysis.outcomes.passive_drain import Drain, passive_drains
from labbook.analysis.outcomes.run_apexes import RunApexes, as_protocol, run_apexes
from labbook.analysis.outcomes.run_energy import RunEnergies, run_energies
from labbook.analysis.prediction.checking import Checked, check_conditions, check_savings
from labbook.analysis.prediction.predicting import Predicted, predictions
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from labbook.analysis.results.result_cache import ResultCache
from labbook.analysis.study_data import StudyData


@dataclass(frozen=True, slots=True)
class VarianceAnalysed:
    """An analysis of variance over the swept factor within one group."""

    label: str
    group: dict[str, str]
    quantity: Outcome
    result: ResultRow


@dataclass(frozen=True, slots=True)
class StudyAnalysis:
    """Everything computed for one selection."""

    evidence: StudyData
    planned: Planned
    drains: dict[str, Drain]
    energies: RunEnergies
    apexes: RunApexes
    swept: str | None
    joules: list[ConditionValues]
    apex_heights: list[ConditionValues]
    compared: list[Compared]
    anovas: list[VarianceAnalysed]
    variations: Variations
    jump_tests: list[Compared]
    packs: dict[str, ResultRow]
    budget: ResultRow | None
    predicted: dict[tuple[str, str], Predicted]
    checked: list[Checked]

    def levels_of(self, item: VarianceAnalysed) -> list[ConditionValues]:
        """Return the treated conditions of an analysis of variance with their runs."""
        conditions = self.joules if item.quantity is Outcome.JOULES else self.apex_heights
        return [
            treated
            for group, items in pairing.groups(conditions, self.swept or "")
            if pairing.group_label(group) == item.label
            for treated in pairing.treated_and_control(items)[0]
        ]


def analyse(
    cache: ResultCache, detections: Detections, evidence: StudyData, progress: Callable[[str], None]
) -> StudyAnalysis:
    """Compute everything that is not stored; `progress` is told what is being done."""
    planned = planned_analysis(cache.connection, evidence.configuration, [run.uid for run in evidence.selected])
    progress("passive drain and joules a jump")
    drains = passive_drains(cache, evidence)
    energies = run_energies(cache, evidence, drains)
    energies = replace(energies, missing=evidence.reasons(energies.missing, FileRole.CHARGE))
    progress("apex heights")
    apexes = run_apexes(cache, detections, evidence, as_protocol(evidence))
    apexes = replace(apexes, missing=evidence.reasons(apexes.missing, FileRole.LOG))
    progress("comparisons")
    scope = {"selection": evidence.selection}
    joules = condition_values(
        cache, run_numbers(evidence.runs, energies.results, Outcome.JOULES), Outcome.JOULES, scope
    )
    heights = condition_values(cache, run_numbers(evidence.runs, apexes.results, Outcome.APEX), Outcome.APEX, scope)
    swept = pairing.swept_factor(evidence.configuration)
    packs = pack_deviations(cache, joules, scope)
    of_a_joule = budget(cache, evidence, joules, scope)
    measured = list(dict.fromkeys(item.key for item in (*joules, *heights)))
    predicted = predictions(cache, evidence, measured, progress)
    checked = [
        *check_conditions(cache, joules, predicted, Outcome.JOULES, swept, scope),
        *check_conditions(cache, heights, predicted, Outcome.APEX, swept, scope),
    ]
    analysis = StudyAnalysis(
        evidence, planned, drains, energies, apexes, swept, joules, heights, [], [], Variations(), [], packs,
        of_a_joule, predicted, checked,
    )  # fmt: skip
    if swept is None:
        return analysis
    settings = planned.settings
    beside = unselected_conditions_of(cache, detections, evidence, scope) if planned.stated else {}
    compared = compare_all(cache, joules, heights, swept, settings, scope, beside)
    of_unit = unit_scope(scope, settings.unit_of_analysis)
    anovas = [
        VarianceAnalysed(label, group, quantity, analyse_variance(cache, label, levels, swept, quantity, of_unit))
        for quantity, conditions in ((Outcome.JOULES, joules), (Outcome.APEX, heights))
        for group, items in pairing.groups(conditions, swept)
        for treated, _control in [pairing.treated_and_control(items)]
        for label in [pairing.group_label(group)]
        if len(treated) > 1
        for levels in [in_units(cache, treated, quantity, settings.unit_of_analysis, scope)]
    ]
    pooled = pairing.pairs_pooled(heights, swept)
    jump_tests = [
        Compared(pair, Outcome.APEX, row)
        for pair, row in zip(pooled, compare_jumps(cache, pooled, scope, settings.alpha), strict=True)
    ]
    progress("what the headlines depend on")
    variations = vary(cache, detections, evidence, drains, apexes, swept, settings)
    of_savings = [(item.pair, item.result) for item in compared if item.quantity is Outcome.JOULES]
    return replace(
        analysis,
        compared=compared,
        anovas=anovas,
        variations=variations,
        jump_tests=jump_tests,
        checked=[*checked, *check_savings(cache, of_savings, predicted, of_unit)],
    )
