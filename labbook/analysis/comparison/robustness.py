"""Headlines computed another way: without the exclusions, with the other detector, without each day."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import RunKind, Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparing import ComparisonResult, compare, pairs_in_units
from labbook.analysis.comparison.deciding import DecisionResult, decide
from labbook.analysis.outcomes.conditions import condition_values, unit_scope
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.measuring import measure
from labbook.analysis.outcomes.run_apexes import as_protocol, run_apexes, without_exclusions
from labbook.analysis.outcomes.run_energy import Drain, RunEnergy, passive_drains, run_energies
from labbook.analysis.results.codec import StoredResult
from labbook.analysis.results.result_cache import ResultCache, RunResults
from labbook.analysis.study_data import StudyData
from labbook.config.model import AnalysisSettings, UnitOfAnalysis
from stats.apexes.detectors import DETECTORS

WITHOUT_EXCLUSIONS = "without exclusions"


@dataclass(frozen=True, slots=True)
class Varied:
    """One headline recomputed another way."""

    headline: str
    variant: str
    quantity: Outcome
    result: ComparisonResult | DecisionResult


@dataclass(frozen=True, slots=True)
class Variations:
    """All recomputed headlines, and by day the robots that have no drain line without that day's idle runs."""

    varied: tuple[Varied, ...] = ()
    fits_lost: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def vary(
    cache: ResultCache,
    detections: Detections,
    evidence: StudyData,
    drains: Mapping[str, Drain],
    results: Mapping[Outcome, RunResults[StoredResult]],
    swept: str,
    settings: AnalysisSettings,
) -> Variations:
    """Recompute the pooled comparisons; a day is left out with its jump runs and its idle runs."""
    found: list[Varied] = []
    everything = with_void(evidence)
    _drains, joules = _joules_of(cache, everything, evidence, drains, WITHOUT_EXCLUSIONS)
    found += _compared(cache, WITHOUT_EXCLUSIONS, everything, Outcome.JOULES, joules, swept, settings)
    protocol = as_protocol(evidence)
    variants = [(WITHOUT_EXCLUSIONS, everything, without_exclusions(evidence))]
    variants += [
        (f"with the {name} detector", evidence, replace(protocol, detector=name))
        for name in DETECTORS
        if name != protocol.detector
    ]
    for label, varied, variant in variants:
        heights = run_apexes(cache, detections, varied, variant).results
        found += _compared(cache, label, varied, Outcome.APEX, heights, swept, settings)
    with_variants = {Outcome.JOULES, Outcome.APEX}
    further = [outcome for outcome in results if outcome not in with_variants]
    for outcome in further:
        with_all = measure(outcome, cache, detections, everything).results
        found += _compared(cache, WITHOUT_EXCLUSIONS, everything, outcome, with_all, swept, settings)
    fits_lost: dict[str, tuple[str, ...]] = {}
    for day in sorted({run.day for run in (*evidence.runs, *evidence.idle)}):
        label, rest = f"without {day}", without_day(evidence, day)
        left, joules = _joules_of(cache, rest, evidence, drains, label)
        found += _compared(cache, label, rest, Outcome.JOULES, joules, swept, settings)
        for outcome in (Outcome.APEX, *further) if len(rest.runs) < len(evidence.runs) else ():
            found += _compared(cache, label, rest, outcome, results[outcome].results, swept, settings)
        lost = _fitted(drains) - _fitted(left)
        if lost:
            fits_lost[day] = tuple(sorted(lost))
    return Variations(tuple(found), fits_lost)


def without_day(evidence: StudyData, day: str) -> StudyData:
    """Return the evidence without the jump runs and the idle runs of one day."""
    return replace(
        evidence,
        runs=tuple(run for run in evidence.runs if run.day != day),
        idle=tuple(run for run in evidence.idle if run.day != day),
    )


def with_void(evidence: StudyData) -> StudyData:
    """Return the evidence with the runs that are void put back."""
    return replace(
        evidence,
        runs=(*evidence.runs, *(run for run in evidence.void if run.kind is RunKind.JUMPS)),
        idle=(*evidence.idle, *(run for run in evidence.void if run.kind is RunKind.IDLE)),
        void=(),
    )


def _joules_of(
    cache: ResultCache, varied: StudyData, evidence: StudyData, drains: Mapping[str, Drain], label: str
) -> tuple[Mapping[str, Drain], Mapping[str, RunEnergy]]:
    """Return drain lines and joules of other runs; where the idle runs are the same, so are the lines."""
    if varied.idle == evidence.idle and all(run.robot_uid in drains for run in varied.runs):
        return drains, run_energies(cache, varied, drains).results
    refitted = passive_drains(cache, varied, label)
    return refitted, run_energies(cache, varied, refitted, label).results


def _fitted(drains: Mapping[str, Drain]) -> set[str]:
    return {drain.robot for drain in drains.values() if not isinstance(drain.line, Undefined)}


def _compared(
    cache: ResultCache,
    label: str,
    evidence: StudyData,
    quantity: Outcome,
    results: Mapping[str, StoredResult],
    swept: str,
    settings: AnalysisSettings,
) -> list[Varied]:
    """Compare the pooled conditions again with other runs, or other results of the same runs."""
    scope = {"selection": evidence.selection, "variant": label}
    unit = settings.unit_of_analysis
    conditions = condition_values(cache, evidence.runs, results, quantity, scope)
    pairs = pairing.pairs_pooled(conditions, swept)
    compared: list[ComparisonResult | DecisionResult] = []
    if unit is UnitOfAnalysis.SHARED_DAYS:
        compared += decide(cache, pairs, quantity, scope, settings.alpha)
    else:
        units = pairs_in_units(cache, pairs, quantity, unit, scope)
        compared += compare(cache, units, quantity, unit_scope(scope, unit), settings.alpha)
    return [Varied(pair.label, label, quantity, each) for pair, each in zip(pairs, compared, strict=True)]
