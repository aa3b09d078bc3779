"""The whole analysis of a selection: from facts and logs to every number that a report shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from data_schema.queries.results import ResultRow
from labbook.analysis import pairing
from labbook.analysis.budget import budget
from labbook.analysis.comparing import Pair, analyse_variance, compare
from labbook.analysis.conditions import ConditionValues, condition_values, run_numbers
from labbook.analysis.detections import Detections
from labbook.analysis.gathering import Evidence
from labbook.analysis.packs import pack_deviations
from labbook.analysis.passive_drain import passive_drain
from labbook.analysis.run_apexes import ApexVariant, RunApexes, as_protocol, run_apexes, without_exclusions
from labbook.analysis.run_energy import RunEnergies, run_energies
from labbook.analysis.workbench import Workbench
from reports.numbers import Quantity
from stats.apexes import DETECTORS


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
class Varied:
    """One headline recomputed another way."""

    headline: str
    variant: str
    quantity: Quantity
    result: ResultRow


@dataclass(frozen=True, slots=True)
class StudyAnalysis:
    """Everything computed for one selection."""

    evidence: Evidence
    drain: ResultRow
    energies: RunEnergies
    apexes: RunApexes
    swept: str | None
    joules: list[ConditionValues]
    apex_heights: list[ConditionValues]
    compared: list[Compared]
    anovas: list[VarianceAnalysed]
    varied: list[Varied]
    packs: dict[str, ResultRow]
    budget: ResultRow | None


def analyse(
    bench: Workbench, detections: Detections, evidence: Evidence, progress: Callable[[str], None]
) -> StudyAnalysis:
    """Compute everything that is not stored; `progress` is told what is being done."""
    progress("passive drain and joules a jump")
    drain = passive_drain(bench, evidence)
    energies = run_energies(bench, evidence, drain)
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
    of_a_joule = budget(bench, evidence, drain, joules, scope)
    analysis = StudyAnalysis(evidence, drain, energies, apexes, swept, joules, heights, [], [], [], packs, of_a_joule)
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
    progress("what the headlines depend on")
    varied = vary(bench, detections, evidence, energies, apexes, swept)
    return replace(analysis, compared=compared, anovas=anovas, varied=varied)


def without_day(evidence: Evidence, day: str) -> Evidence:
    """Return the evidence without the jump runs and the idle runs of one day."""
    return replace(
        evidence,
        runs=tuple(run for run in evidence.runs if run.day != day),
        idle=tuple(run for run in evidence.idle if run.day != day),
    )


def vary(
    bench: Workbench,
    detections: Detections,
    evidence: Evidence,
    energies: RunEnergies,
    apexes: RunApexes,
    swept: str,
) -> list[Varied]:
    """Recompute the pooled comparisons without exclusions, with the other detector, and without each day."""
    found: list[Varied] = []
    protocol = as_protocol(evidence)
    variants: list[tuple[str, ApexVariant]] = [("without exclusions", without_exclusions(evidence))]
    variants += [
        (f"with the {name} detector", replace(protocol, detector=name))
        for name in DETECTORS
        if name != protocol.detector
    ]
    for label, variant in variants:
        other = run_apexes(bench, detections, evidence, variant)
        numbers = run_numbers(evidence.runs, other.results, Quantity.APEX)
        scope = {"selection": evidence.selection, "variant": label}
        conditions = condition_values(bench, numbers, Quantity.APEX, scope)
        found += _varied(bench, label, pairing.pairs_pooled(conditions, swept), Quantity.APEX, scope)
    for day in sorted({run.day for run in evidence.runs}):
        label = f"without {day}"
        scope = {"selection": evidence.selection, "variant": label}
        rest = without_day(evidence, day)
        # Without an idle run of that day the drain line stays, and with it every run's joules.
        refit = len(rest.idle) < len(evidence.idle)
        joules = run_energies(bench, rest, passive_drain(bench, rest, label), label) if refit else energies
        for quantity, results in ((Quantity.JOULES, joules.results), (Quantity.APEX, apexes.results)):
            conditions = condition_values(bench, run_numbers(rest.runs, results, quantity), quantity, scope)
            found += _varied(bench, label, pairing.pairs_pooled(conditions, swept), quantity, scope)
    return found


def _compare_all(bench: Workbench, pairs: Sequence[Pair], quantity: Quantity, scope: dict[str, str]) -> list[Compared]:
    rows = compare(bench, pairs, quantity, scope)
    return [Compared(pair, quantity, row) for pair, row in zip(pairs, rows, strict=True)]


def _varied(
    bench: Workbench, label: str, pairs: Sequence[Pair], quantity: Quantity, scope: dict[str, str]
) -> list[Varied]:
    return [
        Varied(item.pair.label, label, quantity, item.result) for item in _compare_all(bench, pairs, quantity, scope)
    ]
