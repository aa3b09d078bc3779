"""What was measured, in physical units, and how it went: conditions, days, counts, order in the day, robots."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.queries.study import CheckRow, FactorRow, PlannedRow
from data_schema.vocabulary import FactorKind, RunKind, RunState
from data_schema.where.parsing import names_in, parse
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.pairing import place
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.analysis.study import StudyAnalysis
from labbook.config.parsing import Configuration
from reports.content import Condition, Day, Factor, Flow, Level, ReportContent, RunValue, Summary
from reports.display import in_sentence, list_text
from reports.evidence import Order, PackMean, RunPoint
from reports.naming import levels_name


def factors(analysis: StudyAnalysis) -> tuple[Factor, ...]:
    """Return the study's factors with the formulas that turn gains into physical values."""
    return tuple(study_factor(analysis.evidence.configuration, row.name) for row in _considered(analysis))


def study_factor(configuration: Configuration, name: str) -> Factor:
    """Return a factor as labbook.toml names it; levels that are plain numbers have its unit."""
    settings, gain = configuration.factors.get(name), configuration.gains.get(name)
    number_unit = settings.unit if settings and settings.kind is FactorKind.NUMBER else None
    return Factor(
        name=name,
        title=(settings.title if settings else None) or name.replace("_", " "),
        symbol=gain.symbol if gain else "",
        unit=gain.unit if gain else number_unit or "",
        slope=gain.slope if gain else None,
        offset=gain.offset if gain else None,
        control=settings.control if settings else None,
        swept=name == pairing.swept_factor(configuration),
        treatment=(settings.treatment if settings else None) or "",
        control_name=(settings.control_name if settings else None) or "",
    )


def factor_title(analysis: StudyAnalysis, name: str) -> str:
    """Return what a factor is called in text: its title in labbook.toml, or its name."""
    return study_factor(analysis.evidence.configuration, name).title


def _considered(analysis: StudyAnalysis) -> list[FactorRow]:
    """Leave out what labbook.toml no longer names and no condition has: a name that was mistyped at first."""
    measured = {name for several in analysis.conditions.values() for item in several for name in item.levels}
    named = analysis.evidence.configuration.factors.keys() | measured
    return [row for row in analysis.evidence.factors if row.name in named]


def conditions(analysis: StudyAnalysis) -> tuple[Condition, ...]:
    """Return every condition that has a measured quantity, in the order of the factors' levels, the swept one last.

    So the control and the treated conditions of one group stand together.
    """
    measured = {outcome: {item.key: item for item in several} for outcome, several in analysis.conditions.items()}
    every = {key: item for items in measured.values() for key, item in items.items()}
    known = {row.name: [level.label for level in row.levels] for row in analysis.evidence.factors}
    ordered = sorted(every.values(), key=lambda item: place(known, analysis.swept, item.levels))
    return tuple(
        Condition(
            levels=_levels(analysis, item.levels),
            control=item.is_control,
            summaries={
                outcome: _summary(analysis, items[item.key]) for outcome, items in measured.items() if item.key in items
            },
        )
        for item in ordered
    )


def _levels(analysis: StudyAnalysis, labels: Mapping[str, str]) -> tuple[Level, ...]:
    gains = analysis.evidence.configuration.gains
    found = []
    for row in analysis.evidence.factors:
        level = next((level for level in row.levels if level.label == labels.get(row.name)), None)
        if level is None:
            continue
        gain = gains.get(row.name)
        if gain is not None and level.value is not None:
            found.append(Level(row.name, level.label, gain.physical(level.value), gain.unit, level.value))
            continue
        radius_m = json.loads(level.attributes_json).get("radius_m")
        unit = study_factor(analysis.evidence.configuration, row.name).unit
        found.append(Level(row.name, level.label, *((level.value, unit) if radius_m is None else (radius_m, "m"))))
    return tuple(found)


def _summary(analysis: StudyAnalysis, values: ConditionValues) -> Summary:
    jumps = [len(item.result.heights_m) for item in values.runs if isinstance(item.result, RunApexes)]
    return Summary(
        mean=values.result.mean,
        sd=values.result.sd,
        runs=tuple(_run_value(analysis, item) for item in values.runs),
        jumps=sum(jumps) or None,
        robots=dict(Counter(item.run.robot for item in values.runs)),
    )


def _run_value(analysis: StudyAnalysis, item: RunNumber) -> RunValue:
    if not isinstance(item.result, RunApexes):
        return RunValue(item.run.name, item.value)
    jumps = analysis.judgements[item.run.uid].counted
    return RunValue(item.run.name, item.value, item.result.heights_m, tuple(jump.number for jump in jumps))


def days(analysis: StudyAnalysis, checks: Mapping[str, Sequence[CheckRow]]) -> tuple[Day, ...]:
    """Return what was measured on each day, and which checks were made before."""
    listed = analysis.evidence.configuration.protocol.checks
    by_day: dict[str, list[RunRow]] = {}
    for run in analysis.evidence.selected:
        by_day.setdefault(run.day, []).append(run)
    found = []
    for date, runs in by_day.items():
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


def flow(analysis: StudyAnalysis, planned: Sequence[PlannedRow], withdrawn: Collection[str] = ()) -> Flow:
    """Count runs and jumps from the plan to the numbers; of a selection by factors, planned runs of its conditions."""
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
                missing[run.uid].reason if run.uid in missing else outcome.undefined_because
                for missing in [analysis.results[outcome].missing]
                for run in jump_runs
                if run.uid not in runs
            )
            for outcome, runs in used.items()
        },
        jumps_made=sum(run.jumps_made for run in with_heights),
        jumps_detected=len(judged),
        jumps_excluded=dict(jumps_excluded),
        jumps_analysed=sum(item.excluded is None for item in judged),
        runs_withdrawn=0 if analysis.evidence.selection else len(withdrawn),
    )


def _planned_count(analysis: StudyAnalysis, planned: Sequence[PlannedRow]) -> int:
    """Count the plan's runs; those of a selection are known where it is by factors alone, which the plan has too."""
    selection = analysis.evidence.selection
    if not selection:
        return len(planned)
    if not names_in(parse(selection)) <= {row.name for row in analysis.evidence.factors}:
        return 0
    conditions = {run.condition_key for run in analysis.evidence.selected}
    return sum((row.condition_key or "") in conditions for row in planned)


def order(analysis: StudyAnalysis) -> Order:
    """Set every run's joules against its position in the day and its pack, as deviations from its condition."""
    points = [
        _point(item, item.value - mean)
        for condition in analysis.conditions[Outcome.JOULES]
        for mean in [sum(condition.values) / len(condition.values)]
        for item in condition.runs
    ]
    packs = tuple(PackMean(pack, found.deviation) for pack, found in analysis.packs.items())
    return Order(tuple(points), packs, tuple(confounded_with_day(analysis)))


def confounded_with_day(analysis: StudyAnalysis) -> list[str]:
    """Say which factors are confounded with the day, because most days saw one level of them only.

    A day with a single run shows nothing of the kind and does not count.
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
            title = in_sentence(factor_title(analysis, factor.name))
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


def runs_by_robot(analysis: StudyAnalysis) -> dict[str, int]:
    """Count the analysed runs of each robot, in the order in which the robots were used."""
    used = {uid for found in analysis.results.values() for uid in found.results}
    return dict(Counter(run.robot for run in analysis.evidence.runs if run.uid in used))


def robot_limitations(analysis: StudyAnalysis, content: ReportContent) -> tuple[str, ...]:
    """Say in which groups the control and the treated runs are not of the same robots; `content` names groups."""
    found = []
    for item in analysis.compared:
        if item.pair.family != pairing.POOLED:
            continue
        control, treated = _robots(item.pair.a), _robots(item.pair.b)
        if control.keys() != treated.keys():
            name = levels_name(content, item.pair.group)
            found.append(
                f"{f'With {name}' if name else 'In this selection'} the control runs are of {_listed(control)} and the "
                f"treated runs of {_listed(treated)}: the differences may be the robots'."
            )
    return tuple(dict.fromkeys(found))


def _robots(side: Iterable[ConditionValues]) -> Mapping[str, int]:
    return Counter(item.run.robot for condition in side for item in condition.runs)


def _listed(robots: Mapping[str, int]) -> str:
    return list_text([f"{robot} ({runs})" for robot, runs in robots.items()])
