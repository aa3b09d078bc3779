"""Headlines computed another way: without the exclusions, with the other detector, without each day."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import RunKind
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparing import ComparisonResult, compare, pairs_in_units
from labbook.analysis.comparison.deciding import DecisionResult, decide
from labbook.analysis.comparison.left_out_days import days_to_leave_out, estimates_without
from labbook.analysis.outcomes.conditions import ConditionValues, condition_values, unit_scope
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
    """One headline recomputed another way; `day` is the one that is left out, "" where the way is another."""

    headline: str
    variant: str
    quantity: Outcome
    result: ComparisonResult | DecisionResult
    day: str = ""


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
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    swept: str,
    settings: AnalysisSettings,
) -> Variations:
    """Recompute the pooled comparisons; a day is left out with its jump runs and its idle runs."""
    found: list[Varied] = []
    everything = with_void(evidence)
    known = {} if evidence.void else {outcome: of_runs.results for outcome, of_runs in results.items()}
    joules = known.get(Outcome.JOULES) or _joules_of(cache, everything, evidence, drains, WITHOUT_EXCLUSIONS)
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
        with_all = known.get(outcome) or measure(outcome, cache, detections, everything).results
        found += _compared(cache, WITHOUT_EXCLUSIONS, everything, outcome, with_all, swept, settings)
    days = days_to_leave_out(evidence, drains)
    with_runs = [day for day in days if day.has_runs]
    without = {
        outcome: estimates_without(
            cache,
            days if outcome is Outcome.JOULES else with_runs,
            conditions[outcome],
            outcome,
            swept,
            settings,
            evidence.selection,
        )
        for outcome in (Outcome.JOULES, Outcome.APEX, *further)
    }
    found += [
        Varied(pair.label, f"without {day.day}", outcome, result, day.day)
        for day in days
        for outcome, of_day in without.items()
        for pair, result in of_day.get(day.day, ())
    ]
    lost = {day.day: tuple(sorted(drains[uid].robot for uid in day.lost)) for day in days if day.lost}
    return Variations(tuple(found), lost)


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
) -> Mapping[str, RunEnergy]:
    """Return joules of other runs; where the idle runs are the same, so are the drain lines."""
    if varied.idle == evidence.idle and all(run.robot_uid in drains for run in varied.runs):
        return run_energies(cache, varied, drains).results
    refitted = passive_drains(cache, varied, label)
    return run_energies(cache, varied, refitted, label).results


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
