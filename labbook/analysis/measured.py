"""What was measured of the runs of a selection, before anything is compared, and what came of these runs in counts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.queries.study import CheckRow, PlannedRow
from data_schema.vocabulary import ReasonCode, RunKind, RunState, Verdict
from data_schema.where import names_in, parse
from labbook.analysis.outcomes.conditions import ConditionValues, condition_values, measure_all, number_of
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import Judgement, RunApexes, as_protocol, run_apexes
from labbook.analysis.outcomes.run_energy import passive_drains, run_energies
from labbook.analysis.results import Results, RunResults
from labbook.analysis.study_data import StudyData
from reports.numbers import Result
from reports.results import Day, Drain, Flow, Run


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured of the runs of a selection.

    By run uid, `judgements` says which jumps count and `apexes` what that gives; `results` and `conditions` have the
    outcomes that every run is expected to have, and those that any of its runs has.
    """

    evidence: StudyData
    drains: dict[str, Drain]
    judgements: Mapping[str, Judgement]
    apexes: Mapping[str, RunApexes]
    results: dict[Outcome, RunResults[Result]]
    conditions: dict[Outcome, list[ConditionValues]]

    @property
    def every_condition(self) -> list[ConditionValues]:
        """The conditions of all outcomes, one after the other."""
        return [condition for several in self.conditions.values() for condition in several]


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


def analysed_runs(measured: Measured) -> dict[str, Run]:
    """Return the analysed runs by name."""
    used = {item.run.uid: item.run for one in measured.every_condition for item in one.runs}
    return {run.name: _run(run, measured.judgements.get(uid)) for uid, run in used.items()}


def _run(run: RunRow, judged: Judgement | None) -> Run:
    heights = [(jump.number, jump.apex_height_m) for jump in judged.counted] if judged is not None else []
    known = {number: height_m for number, height_m in heights if height_m is not None}
    return Run(run.day, run.position_in_day, run.battery, run.robot, known)


def runs_by_robot(measured: Measured) -> dict[str, int]:
    """Count the analysed runs of each robot, in the order in which the robots were used."""
    used = {uid for found in measured.results.values() for uid in found.results}
    return dict(Counter(run.robot for run in measured.evidence.runs if run.uid in used))


def days(evidence: StudyData, checks: Mapping[str, Sequence[CheckRow]]) -> tuple[Day, ...]:
    """Return what was measured on each day, and which checks were made before."""
    listed = evidence.configuration.protocol.checks
    found = []
    for date, runs in grouped(evidence.selected, [run.day for run in evidence.selected]).items():
        made = [check.kind for check in checks.get(date, ()) if check.passed]
        found.append(
            Day(
                date=date,
                runs=tuple(run.name for run in runs),
                conditions=tuple(sorted({run.condition_key for run in runs if run.condition_key})),
                packs=tuple(sorted({run.battery for run in runs})),
                checks_made=tuple(made),
                checks_not_made=tuple(kind for kind in listed if kind not in made),
            )
        )
    return tuple(found)


def flow(measured: Measured, planned: Sequence[PlannedRow], withdrawn: Collection[str] = ()) -> Flow:
    """Count runs and jumps from the plan to the numbers; of a selection by factors, planned runs of its conditions."""
    evidence = measured.evidence
    selected, jump_runs = evidence.selected, evidence.runs
    used = {
        outcome: {one.run.uid for condition in conditions for one in condition.runs}
        for outcome, conditions in measured.conditions.items()
    }
    with_heights = [run for run in jump_runs if run.uid in used[Outcome.APEX]]
    judged = [item for run in with_heights for item in measured.judgements[run.uid].jumps]
    jumps_excluded = Counter(item.excluded for item in judged if item.excluded is not None)
    analysed = [item for item in judged if item.excluded is None]
    decided = [item.decision for item in analysed if item.decision is not None]
    with_the_rest = sum(one.reason_code is ReasonCode.WITH_THE_REST for one in decided)
    rejected = [one for item in judged if (one := item.decision) is not None and one.verdict is Verdict.REJECT]
    return Flow(
        runs_planned=_planned_count(evidence, planned) or None,
        runs_done=len(selected),
        runs_void=sum(run.state is RunState.VOID for run in selected),
        runs_idle=sum(run.kind is RunKind.IDLE and run.state is not RunState.VOID for run in selected),
        runs_other=Counter(
            f"{run.kind} run"
            for run in selected
            if run.kind not in (RunKind.JUMPS, RunKind.IDLE) and run.state is not RunState.VOID
        ),
        runs_with={outcome: len(runs) for outcome, runs in used.items()},
        runs_without={
            outcome: Counter(
                missing[run.uid].reason if run.uid in missing else outcome.undefined_because
                for missing in [measured.results[outcome].missing]
                for run in jump_runs
                if run.uid not in runs
            )
            for outcome, runs in used.items()
        },
        jumps_made=sum(run.jumps_made for run in with_heights),
        jumps_detected=len(judged),
        jumps_excluded=dict(jumps_excluded),
        jumps_analysed=len(analysed),
        runs_withdrawn=0 if evidence.selection else len(withdrawn),
        jumps_reviewed=len(decided) - with_the_rest,
        jumps_with_the_rest=with_the_rest,
        jumps_rejected=len(rejected),
        verdicts_blind=sum(one.blind for one in (*decided, *rejected)),
    )


def _planned_count(evidence: StudyData, planned: Sequence[PlannedRow]) -> int:
    """Count the plan's runs; those of a selection are known where it is by factors alone, which the plan has too."""
    if not evidence.selection:
        return len(planned)
    if not names_in(parse(evidence.selection)) <= {row.name for row in evidence.factors}:
        return 0
    conditions = {run.condition_key for run in evidence.selected}
    return sum((row.condition_key or "") in conditions for row in planned)
