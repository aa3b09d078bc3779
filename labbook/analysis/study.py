"""The whole analysis of a selection: from facts and logs to every number that a report shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from data_schema.queries.results import ResultRow
from data_schema.vocabulary import RunKind
from labbook.analysis import pairing
from labbook.analysis.budget import budget
from labbook.analysis.comparing import Pair, analyse_variance, compare
from labbook.analysis.conditions import ConditionValues, condition_values, run_numbers
from labbook.analysis.detections import Detections
from labbook.analysis.gathering import Evidence
from labbook.analysis.packs import pack_deviations
from labbook.analysis.passive_drain import Drain, passive_drains
from labbook.analysis.run_apexes import RunApexes, as_protocol, run_apexes, without_exclusions
from labbook.analysis.run_energy import RunEnergies, run_energies
from labbook.analysis.workbench import Workbench
from reports.numbers import Quantity
from stats.apexes import DETECTORS

WITHOUT_EXCLUSIONS = "without exclusions"


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
    drains: dict[str, Drain]
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
    analysis = StudyAnalysis(evidence, drains, energies, apexes, swept, joules, heights, [], [], [], packs, of_a_joule)
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
    varied = vary(bench, detections, evidence, drains, apexes, swept)
    return replace(analysis, compared=compared, anovas=anovas, varied=varied)


def without_day(evidence: Evidence, day: str) -> Evidence:
    """Return the evidence without the jump runs and the idle runs of one day."""
    return replace(
        evidence,
        runs=tuple(run for run in evidence.runs if run.day != day),
        idle=tuple(run for run in evidence.idle if run.day != day),
    )


def with_void(evidence: Evidence) -> Evidence:
    """Return the evidence with the runs that are void put back."""
    return replace(
        evidence,
        runs=(*evidence.runs, *(run for run in evidence.void if run.kind is RunKind.JUMPS)),
        idle=(*evidence.idle, *(run for run in evidence.void if run.kind is RunKind.IDLE)),
        void=(),
    )


def vary(
    bench: Workbench,
    detections: Detections,
    evidence: Evidence,
    drains: dict[str, Drain],
    apexes: RunApexes,
    swept: str,
) -> list[Varied]:
    """Recompute the pooled comparisons without exclusions, with the other detector, and without each day."""
    found: list[Varied] = []
    protocol = as_protocol(evidence)
    everything = with_void(evidence)
    joules = _energies_of(bench, everything, evidence, drains, WITHOUT_EXCLUSIONS)
    found += _vary_with(bench, WITHOUT_EXCLUSIONS, everything, Quantity.JOULES, joules.results, swept)
    variants = [(WITHOUT_EXCLUSIONS, everything, without_exclusions(evidence))]
    variants += [
        (f"with the {name} detector", evidence, replace(protocol, detector=name))
        for name in DETECTORS
        if name != protocol.detector
    ]
    for label, varied, variant in variants:
        other = run_apexes(bench, detections, varied, variant)
        found += _vary_with(bench, label, varied, Quantity.APEX, other.results, swept)
    for day in sorted({run.day for run in evidence.runs}):
        label = f"without {day}"
        rest = without_day(evidence, day)
        joules = _energies_of(bench, rest, evidence, drains, label)
        found += _vary_with(bench, label, rest, Quantity.JOULES, joules.results, swept)
        found += _vary_with(bench, label, rest, Quantity.APEX, apexes.results, swept)
    return found


def _compare_all(bench: Workbench, pairs: Sequence[Pair], quantity: Quantity, scope: dict[str, str]) -> list[Compared]:
    rows = compare(bench, pairs, quantity, scope)
    return [Compared(pair, quantity, row) for pair, row in zip(pairs, rows, strict=True)]


def _energies_of(
    bench: Workbench, varied: Evidence, evidence: Evidence, drains: dict[str, Drain], label: str
) -> RunEnergies:
    """Return the joules of other runs; where the idle runs are the same, so are the drain lines."""
    if varied.idle == evidence.idle and all(run.robot_uid in drains for run in varied.runs):
        return run_energies(bench, varied, drains)
    return run_energies(bench, varied, passive_drains(bench, varied, label), label)


def _vary_with(
    bench: Workbench,
    label: str,
    evidence: Evidence,
    quantity: Quantity,
    results: Mapping[str, ResultRow],
    swept: str,
) -> list[Varied]:
    """Compare the pooled conditions again with other runs, or other results of the same runs."""
    scope = {"selection": evidence.selection, "variant": label}
    conditions = condition_values(bench, run_numbers(evidence.runs, results, quantity), quantity, scope)
    return [
        Varied(item.pair.label, label, quantity, item.result)
        for item in _compare_all(bench, pairing.pairs_pooled(conditions, swept), quantity, scope)
    ]
