"""Headlines computed another way: without exclusions, by another detector or other rules, without each day, adjusted
for position in the day.

There is one result for each estimate and each day left out. It depends on the estimate of all days and the runs that
were left out. Intermediate results, such as each run's joules by another drain line, have no ids: they would be
those of every run again for every day.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from data_schema.outcomes import Outcome
from data_schema.queries.sources import InputRow
from data_schema.vocabulary import RunKind, Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.deciding import (
    DECISION,
    about_pair,
    contrast_of,
    decide,
    decide_pair,
    depends_on,
    fingerprints_of_contrast,
)
from labbook.analysis.comparison.order import ADJUSTED, adjusted_for_position, fingerprints_of_positions
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.charger_step import with_rounding_of
from labbook.analysis.outcomes.conditions import (
    ConditionValues,
    condition_values,
    measure,
    measure_all,
    number_of,
    same_conditions,
)
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import as_protocol, without_exclusions
from labbook.analysis.outcomes.run_energy import (
    RunEnergy,
    drain_lines,
    energies_with_drains,
    idle_charges,
    passive_drains,
    run_energies,
)
from labbook.analysis.outcomes.run_force import RunForce, run_forces_by_rules
from labbook.analysis.results import Results, RunResults, fingerprint, result_fingerprint
from labbook.analysis.study_data import StudyData
from labbook.config.model import AnalysisSettings
from reports.numbers import Result
from reports.results import WITHOUT_EXCLUSIONS, Decision, Drain, Varied
from stats.apexes.detectors import DETECTORS
from stats.days.decision import Contrast
from stats.lines.passive_drain import why_no_line


def without_day(evidence: StudyData, day: str) -> StudyData:
    """Return the evidence without the jump runs and the idle runs of one day."""
    return replace(
        evidence,
        runs=tuple(run for run in evidence.runs if run.day != day),
        idle=tuple(run for run in evidence.idle if run.day != day),
    )


@dataclass(frozen=True)
class LeftOut:
    """A day to leave out. `lost` are the robots, by uid, that have no drain line without its idle runs."""

    day: str
    evidence: StudyData
    inputs: tuple[InputRow, ...]
    has_runs: bool
    has_idle: bool
    lost: frozenset[str]

    @cached_property
    def joules(self) -> Mapping[str, RunEnergy]:
        """The joules of the other runs by the drain lines of the other days."""
        rest = without_day(self.evidence, self.day)
        return energies_with_drains(rest.runs, rest.charges, drain_lines(rest), rest.study.reference_voltage_v)

    def remains(self, side: Sequence[ConditionValues], quantity: Outcome) -> bool:
        """Whether a side of a comparison has a value left."""
        lost = self.lost if quantity is Outcome.JOULES else ()
        return any(
            one.run.day != self.day and one.run.robot_uid not in lost for condition in side for one in condition.runs
        )

    def changes(self, quantity: Outcome) -> bool:
        """Whether the values of other days are others without its idle runs."""
        return quantity is Outcome.JOULES and self.has_idle

    def rest_of(self, side: Sequence[ConditionValues], quantity: Outcome) -> tuple[ConditionValues, ...]:
        """Return a side with the values that are left; joules are computed anew where idle runs are left out."""
        remaining = [
            replace(condition, runs=tuple(one for one in condition.runs if one.run.day != self.day))
            for condition in side
        ]
        if self.changes(quantity):
            remaining = [self._by_other_lines(condition) for condition in remaining]
        return tuple(condition for condition in remaining if condition.runs)

    def _by_other_lines(self, condition: ConditionValues) -> ConditionValues:
        found = [(one, self.joules[one.run.uid]) for one in condition.runs if one.run.uid in self.joules]
        values = [(one, energy, number_of(energy, Outcome.JOULES).value) for one, energy in found]
        return replace(
            condition,
            runs=tuple(
                replace(one, value=value, shared=with_rounding_of(energy.shared_error, one.shared))
                for one, energy, value in values
                if not isinstance(value, Undefined)
            ),
        )


def _days_to_leave_out(evidence: StudyData, drains: Mapping[str, Drain]) -> list[LeftOut]:
    """Return every day of a jump run or an idle run, in order."""
    runs: dict[str, list[InputRow]] = {}
    for run in (*evidence.runs, *evidence.idle):
        runs.setdefault(run.day, []).append(fingerprint("left out", "run", run.uid, run.day))
    with_runs, with_idle = ({run.day for run in several} for several in (evidence.runs, evidence.idle))
    durations_s = [(run.robot_uid, run.day, run.duration_s or 0.0) for run, _charge in idle_charges(evidence)]
    fitted = [uid for uid, drain in drains.items() if not isinstance(drain.line, Undefined)]

    def lost(day: str) -> frozenset[str]:
        left = {
            uid: [length_s for robot, of_day, length_s in durations_s if robot == uid and of_day != day]
            for uid in fitted
        }
        return frozenset(uid for uid in fitted if why_no_line(left[uid]) is not None)

    return [
        LeftOut(
            day,
            evidence,
            tuple(runs[day]),
            day in with_runs,
            day in with_idle,
            lost(day) if day in with_idle else frozenset(),
        )
        for day in sorted(runs)
    ]


def _estimates_without(
    computed: Results, days: Sequence[LeftOut], pairs: Sequence[Pair], quantity: Outcome, settings: AnalysisSettings
) -> dict[str, list[tuple[Pair, Decision]]]:
    """Compute the pooled comparisons without each of these days: pair and result, by day."""
    whole = decide(computed, pairs, quantity, settings)
    contrasts = [contrast_of(pair) for pair in pairs]

    def without(day: LeftOut, pair: Pair, of_all: Decision, contrast: Contrast) -> Decision:
        if day.changes(quantity):
            rest = replace(pair, a=day.rest_of(pair.a, quantity), b=day.rest_of(pair.b, quantity))
            estimate = decide_pair(rest, quantity, settings)
        else:
            estimate = decide_pair(pair, quantity, settings, contrast.without(day.day))
        inputs = (result_fingerprint("all days", of_all), *day.inputs)
        about, of_day = about_pair(pair, quantity), computed.about(variant=f"without {day.day}")
        return of_day.record(DECISION, about, inputs, estimate, depends_on(settings))

    return {
        day.day: [
            (pair, without(day, pair, of_all, contrast))
            for pair, of_all, contrast in zip(pairs, whole, contrasts, strict=True)
            if day.remains(pair.a, quantity) and day.remains(pair.b, quantity)
        ]
        for day in days
    }


def _adjusted(computed: Results, pairs: Sequence[Pair], quantity: Outcome, settings: AnalysisSettings) -> list[Varied]:
    """Compute the pooled comparisons adjusted for position in the day; none where the runs leave no slope."""
    adjusted = adjusted_for_position(pairs)
    if isinstance(adjusted, Undefined):
        return []
    inputs = (*(row for pair in pairs for row in fingerprints_of_contrast(pair)), *fingerprints_of_positions(pairs))
    found = decide(computed.about(variant=ADJUSTED), adjusted, quantity, settings, lambda _pair: inputs)
    return [Varied(pair.label, ADJUSTED, quantity, each) for pair, each in zip(pairs, found, strict=True)]


@dataclass(frozen=True, slots=True)
class Variations:
    """All recomputed headlines, and by day the robots that have no drain line without that day's idle runs."""

    varied: tuple[Varied, ...] = ()
    fits_lost: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def vary(
    computed: Results,
    detections: Detections,
    evidence: StudyData,
    drains: Mapping[str, Drain],
    results: Mapping[Outcome, RunResults[Result]],
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    swept: str,
    settings: AnalysisSettings,
) -> Variations:
    """Recompute the pooled comparisons; a day is left out with its jump runs and its idle runs."""
    found: list[Varied] = []
    selected = computed.about(selection=evidence.selection)
    everything, with_all = with_void(evidence), computed.about(selection=evidence.selection, variant=WITHOUT_EXCLUSIONS)
    if evidence.void:
        joules = _joules_of(computed, everything, evidence, drains, WITHOUT_EXCLUSIONS)
        of_joules = condition_values(with_all, everything.runs, joules, Outcome.JOULES)
    else:
        of_joules = same_conditions(with_all, conditions[Outcome.JOULES], Outcome.JOULES)
    found += _compared(with_all, WITHOUT_EXCLUSIONS, of_joules, Outcome.JOULES, swept, settings)
    of_jumps = [outcome for outcome in results if outcome.of_jumps]
    protocol = as_protocol(evidence)
    variants = [(WITHOUT_EXCLUSIONS, everything, without_exclusions(evidence))]
    variants += [
        (f"with the {name} detector", evidence, replace(protocol, detector=name))
        for name in DETECTORS
        if name != protocol.detector
    ]
    for label, varied, variant in variants:
        for outcome in of_jumps:
            values = measure(outcome, computed, detections, varied, variant).results
            about = computed.about(selection=evidence.selection, variant=label)
            of_variant = condition_values(about, varied.runs, values, outcome)
            found += _compared(about, label, of_variant, outcome, swept, settings)
    further = [outcome for outcome in results if outcome not in (Outcome.JOULES, *of_jumps)]
    of_all = measure_all(further, computed, detections, everything) if evidence.void else {}
    for outcome in further:
        of_outcome = (
            condition_values(with_all, everything.runs, of_all[outcome].results, outcome)
            if evidence.void
            else same_conditions(with_all, conditions[outcome], outcome)
        )
        found += _compared(with_all, WITHOUT_EXCLUSIONS, of_outcome, outcome, swept, settings)
    found += _by_rules(computed, detections, evidence, results, swept, settings)
    days = _days_to_leave_out(evidence, drains)
    with_runs = [day for day in days if day.has_runs]
    without: dict[Outcome, dict[str, list[tuple[Pair, Decision]]]] = {}
    for outcome in (Outcome.JOULES, *of_jumps, *further):
        pairs = pairing.pairs_pooled(conditions[outcome], swept)
        found += _adjusted(selected, pairs, outcome, settings)
        left_out = days if outcome is Outcome.JOULES else with_runs
        without[outcome] = _estimates_without(selected, left_out, pairs, outcome, settings)
    found += [
        Varied(pair.label, f"without {day.day}", outcome, result, day.day)
        for day in days
        for outcome, by_day in without.items()
        for pair, result in by_day.get(day.day, ())
    ]
    lost = {day.day: tuple(sorted(drains[uid].robot for uid in day.lost)) for day in days if day.lost}
    return Variations(tuple(found), lost)


def _by_rules(
    computed: Results,
    detections: Detections,
    evidence: StudyData,
    results: Mapping[Outcome, RunResults[Result]],
    swept: str,
    settings: AnalysisSettings,
) -> list[Varied]:
    """Compare what single jumps give by every rule of onset with every rule of take-off.

    A time of flight knows no onset.
    """
    of_push_off = [outcome for outcome in results if outcome.of_push_off]
    forces = dict(results[of_push_off[0]].results) if of_push_off else {}
    single = [uid for uid, force in forces.items() if isinstance(force, RunForce) and force.single_jumps]
    if not single:
        return []
    return [
        replace(varied, by_rules=True)
        for rules, by_rules in run_forces_by_rules(computed, detections, evidence, single).items()
        for outcome in of_push_off
        if outcome is not Outcome.FLIGHT_HEIGHT or rules.onset == evidence.configuration.protocol.onset
        for about in [computed.about(selection=evidence.selection, variant=str(rules))]
        for of_rules in [condition_values(about, evidence.runs, {**forces, **by_rules}, outcome)]
        for varied in _compared(about, str(rules), of_rules, outcome, swept, settings)
    ]


def with_void(evidence: StudyData) -> StudyData:
    """Return the evidence with the runs that are void put back."""
    return replace(
        evidence,
        runs=(*evidence.runs, *(run for run in evidence.void if run.kind is RunKind.JUMPS)),
        idle=(*evidence.idle, *(run for run in evidence.void if run.kind is RunKind.IDLE)),
        void=(),
    )


def _joules_of(
    computed: Results, varied: StudyData, evidence: StudyData, drains: Mapping[str, Drain], label: str
) -> Mapping[str, RunEnergy]:
    """Return joules of other runs; where the idle runs are the same, so are the drain lines."""
    if varied.idle == evidence.idle and all(run.robot_uid in drains for run in varied.runs):
        return run_energies(computed, varied, drains).results
    refitted = passive_drains(computed, varied, label)
    return run_energies(computed, varied, refitted, label).results


def _compared(
    computed: Results,
    label: str,
    conditions: Sequence[ConditionValues],
    quantity: Outcome,
    swept: str,
    settings: AnalysisSettings,
) -> list[Varied]:
    """Compare the pooled conditions again, of other runs or of other results of the same runs."""
    pairs = pairing.pairs_pooled(conditions, swept)
    compared = decide(computed, pairs, quantity, settings)
    return [Varied(pair.label, label, quantity, each) for pair, each in zip(pairs, compared, strict=True)]
