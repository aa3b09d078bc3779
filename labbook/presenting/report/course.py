"""How the measuring went: days, counts of runs and jumps, order in the day, packs, what is confounded with the day."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from data_schema.outcomes import Outcome
from data_schema.queries.plans import PlannedRow
from data_schema.queries.runs import RunRow
from data_schema.queries.study import CheckRow
from data_schema.vocabulary import CheckKind, RunKind, RunState
from labbook.analysis.outcomes.conditions import RunNumber
from labbook.analysis.study import StudyAnalysis
from labbook.presenting.numbers import Shown
from labbook.presenting.report.design import factor_title
from reports.content import Day, Flow, Order, PackMean, RunPoint


def days(analysis: StudyAnalysis, checks: Mapping[str, Sequence[CheckRow]]) -> tuple[Day, ...]:
    """Return what was measured on each day, and which checks were made before."""
    by_day: dict[str, list[RunRow]] = {}
    for run in analysis.evidence.selected:
        by_day.setdefault(run.day, []).append(run)
    found = []
    for date, runs in by_day.items():
        made = {check.kind for check in checks.get(date, ()) if check.passed}
        found.append(
            Day(
                date=date,
                runs=tuple(run.name for run in runs),
                conditions=tuple(sorted({run.condition_key for run in runs if run.condition_key})),
                packs=tuple(sorted({run.battery for run in runs})),
                checks_made=tuple(str(kind) for kind in CheckKind if kind in made),
                checks_not_made=tuple(str(kind) for kind in CheckKind if kind not in made),
            )
        )
    return tuple(found)


def flow(analysis: StudyAnalysis, planned: Sequence[PlannedRow]) -> Flow:
    """Count runs and jumps from the plan to the numbers; with a selection, planned runs of its conditions only."""
    selected = analysis.evidence.selected
    jump_runs = analysis.evidence.runs
    used = {
        outcome: {one.run.uid for condition in conditions for one in condition.runs}
        for outcome, conditions in analysis.conditions.items()
    }
    with_heights = [run for run in jump_runs if run.uid in used[Outcome.APEX]]
    judged = [item for run in with_heights for item in analysis.judgements[run.uid].jumps]
    jumps_excluded = Counter(item.excluded for item in judged if item.excluded is not None)
    return Flow(
        runs_planned=_planned_count(analysis, planned) or None,
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
                analysis.results[outcome].missing.get(run.uid, outcome.undefined_because)
                for run in jump_runs
                if run.uid not in runs
            )
            for outcome, runs in used.items()
        },
        jumps_made=sum(run.jumps_made for run in with_heights),
        jumps_detected=len(judged),
        jumps_excluded=dict(jumps_excluded),
        jumps_analysed=sum(item.excluded is None for item in judged),
    )


def _planned_count(analysis: StudyAnalysis, planned: Sequence[PlannedRow]) -> int:
    if not analysis.evidence.selection:
        return len(planned)
    conditions = {run.condition_key for run in analysis.evidence.selected}
    return sum((row.condition_key or "") in conditions for row in planned)


def order(analysis: StudyAnalysis, shown: Shown, *, told: bool) -> Order:
    """Set every run's joules against its position in the day and its pack, as deviations from its condition.

    `told`: the claims say already that levels of the swept factor cannot be told from their days.
    """
    points = [
        _point(item, item.value - sum(condition.values) / len(condition.values))
        for condition in analysis.conditions[Outcome.JOULES]
        for item in condition.runs
    ]
    packs = tuple(PackMean(pack, shown.number(found.deviation)) for pack, found in analysis.packs.items())
    return Order(tuple(points), packs, None, tuple(confounded_with_day(analysis, told=told)))


def confounded_with_day(analysis: StudyAnalysis, *, told: bool = False) -> list[str]:
    """Say which factors cannot be told from the day, because most days saw one level of them only.

    A day with a single run shows nothing of the kind and does not count. The swept factor is left out where it was
    `told` that none of its comparisons can be told from days.
    """
    runs = [run for run in analysis.evidence.runs if run.levels]
    by_day: dict[str, list[RunRow]] = {}
    for run in runs:
        by_day.setdefault(run.day, []).append(run)
    days_of = [of_day for of_day in by_day.values() if len(of_day) > 1]
    sentences, named = [], set()
    for factor in analysis.evidence.factors:
        levels = {run.levels.get(factor.name) for run in runs}
        single = sum(len({run.levels.get(factor.name) for run in of_day}) == 1 for of_day in days_of)
        if len(levels) > 1 and 2 * single > len(days_of):
            named.add(factor.name)
            if told and factor.name == analysis.swept:
                continue
            title = factor_title(analysis, factor.name).lower()
            sentences.append(
                f"{_days(single, len(days_of))} all runs had one level of the {title}: "
                f"differences between its levels are {_confounded(single, len(days_of))} differences between days."
            )
    swept = analysis.swept
    if swept is not None and swept not in named and any(run.is_control for run in runs):
        without = sum(not any(run.is_control for run in of_day) for of_day in days_of)
        if 2 * without > len(days_of):
            sentences.append(
                f"{_days(without, len(days_of))} there was no control run: differences from the control are "
                f"{_confounded(without, len(days_of))} differences between days."
            )
    return sentences


def _days(count: int, days: int) -> str:
    """Open a sentence with the days of several runs that it is true of."""
    if count == days:
        return "On the only day with two or more runs" if days == 1 else "On every day with two or more runs"
    return f"On {count} of the {days} days with two or more runs"


def _confounded(count: int, days: int) -> str:
    return "confounded with" if count == days else "largely confounded with"


def _point(item: RunNumber, deviation_j: float) -> RunPoint:
    run = item.run
    return RunPoint(run.name, run.day, run.position_in_day, run.battery, item.value, deviation_j, run.is_control)
