"""The whole analysis of a selection: from facts and logs to every number that a report shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from data_schema.queries.results import ResultRow
from labbook.analysis import pairing
from labbook.analysis.budget import budget
from labbook.analysis.checking import Checked, check_conditions, check_savings
from labbook.analysis.comparing import Pair, analyse_variance, compare
from labbook.analysis.comparing_jumps import compare_jumps
from labbook.analysis.conditions import ConditionValues, condition_values, run_numbers
from labbook.analysis.detections import Detections
from labbook.analysis.gathering import Evidence
from labbook.analysis.packs import pack_deviations
from labbook.analysis.passive_drain import Drain, passive_drains
from labbook.analysis.predicting import Predicted, predictions
from labbook.analysis.run_apexes import RunApexes, as_protocol, run_apexes
from labbook.analysis.run_energy import RunEnergies, run_energies
from labbook.analysis.varying import Variations, vary
from labbook.analysis.workbench import Workbench
from reports.numbers import Quantity


@dataclass(frozen=True, slots=True)
class Compared:
    """A pair, the quantity compared, and the stored comparison."""

    pair: Pair
    quantity: Quantity
    result: ResultRow


@dataclass(frozen=True, slots=True)
class VarianceAnalysed:
    """An analysis of variance over the swept factor within one group."""

    label: str
    group: dict[str, str]
    quantity: Quantity
    result: ResultRow


@dataclass(frozen=True, slots=True)
class StudyAnalysis:
    """Everything computed for one selection."""

    evidence: Evidence
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


def analyse(
    bench: Workbench, detections: Detections, evidence: Evidence, progress: Callable[[str], None]
) -> StudyAnalysis:
    """Compute everything that is not stored; `progress` is told what is being done."""
    progress("passive drain and joules a jump")
    drains = passive_drains(bench, evidence)
    energies = run_energies(bench, evidence, drains)
    progress("apex heights")
    apexes = run_apexes(bench, detections, evidence, as_protocol(evidence))
    progress("comparisons")
    scope = {"selection": evidence.selection}
    joules = condition_values(
        bench, run_numbers(evidence.runs, energies.results, Quantity.JOULES), Quantity.JOULES, scope
    )
    heights = condition_values(bench, run_numbers(evidence.runs, apexes.results, Quantity.APEX), Quantity.APEX, scope)
    swept = pairing.swept_factor(evidence.configuration)
    packs = pack_deviations(bench, joules, scope)
    of_a_joule = budget(bench, evidence, joules, scope)
    measured = list(dict.fromkeys(item.key for item in (*joules, *heights)))
    predicted = predictions(bench, evidence, measured, progress)
    checked = [
        *check_conditions(bench, joules, predicted, Quantity.JOULES, swept, scope),
        *check_conditions(bench, heights, predicted, Quantity.APEX, swept, scope),
    ]
    analysis = StudyAnalysis(
        evidence, drains, energies, apexes, swept, joules, heights, [], [], Variations(), [], packs, of_a_joule,
        predicted, checked,
    )  # fmt: skip
    if swept is None:
        return analysis
    compared = [
        *_compare_all(bench, [*pairing.pairs_each(joules, swept), *pairing.pairs_pooled(joules, swept),
                              *pairing.pairs_across(joules, swept), *pairing.pairs_between(joules, swept)],
                      Quantity.JOULES, scope),
        *_compare_all(bench, [*pairing.pairs_each(heights, swept), *pairing.pairs_pooled(heights, swept)],
                      Quantity.APEX, scope),
    ]  # fmt: skip
    anovas = [
        VarianceAnalysed(label, group, quantity, analyse_variance(bench, label, treated, swept, quantity, scope))
        for quantity, conditions in ((Quantity.JOULES, joules), (Quantity.APEX, heights))
        for group, items in pairing.groups(conditions, swept)
        for treated, _control in [pairing.treated_and_control(items)]
        for label in [pairing.group_label(group)]
        if len(treated) > 1
    ]
    pooled = pairing.pairs_pooled(heights, swept)
    jump_tests = [
        Compared(pair, Quantity.APEX, row)
        for pair, row in zip(pooled, compare_jumps(bench, pooled, scope), strict=True)
    ]
    progress("what the headlines depend on")
    variations = vary(bench, detections, evidence, drains, apexes, swept)
    of_savings = [(item.pair, item.result) for item in compared if item.quantity is Quantity.JOULES]
    return replace(
        analysis,
        compared=compared,
        anovas=anovas,
        variations=variations,
        jump_tests=jump_tests,
        checked=[*checked, *check_savings(bench, of_savings, predicted, scope)],
    )


def _compare_all(bench: Workbench, pairs: Sequence[Pair], quantity: Quantity, scope: dict[str, str]) -> list[Compared]:
    rows = compare(bench, pairs, quantity, scope)
    return [Compared(pair, quantity, row) for pair, row in zip(pairs, rows, strict=True)]
