"""Factors, levels and conditions as a report shows them: physical units with the gains beside them."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping

from data_schema.queries.study import FactorRow
from data_schema.vocabulary import FactorKind
from labbook.analysis.comparison.condition_order import place
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.analysis.study import StudyAnalysis
from labbook.presenting.numbers import Shown
from reports.content import Condition, Factor, Level, RunValue, Summary


def factors(analysis: StudyAnalysis) -> tuple[Factor, ...]:
    """Return the study's factors with the formulas that turn gains into physical values."""
    shown = []
    for row in _considered(analysis):
        gain = analysis.evidence.configuration.gains.get(row.name)
        settings = analysis.evidence.configuration.factors.get(row.name)
        shown.append(
            Factor(
                name=row.name,
                title=factor_title(analysis, row.name),
                symbol=gain.symbol if gain else "",
                unit=gain.unit if gain else _number_unit(analysis, row),
                slope=gain.slope if gain else None,
                offset=gain.offset if gain else None,
                control=settings.control if settings else None,
                swept=row.name == analysis.swept,
            )
        )
    return tuple(shown)


def factor_title(analysis: StudyAnalysis, name: str) -> str:
    """Return what a factor is called in text: its title in labbook.toml, or its name."""
    settings = analysis.evidence.configuration.factors.get(name)
    return (settings.title if settings else None) or name.replace("_", " ")


def _number_unit(analysis: StudyAnalysis, row: FactorRow) -> str:
    """Return the unit of levels that are plain numbers, as labbook.toml names it."""
    settings = analysis.evidence.configuration.factors.get(row.name)
    return (settings.unit or "") if settings is not None and settings.kind is FactorKind.NUMBER else ""


def _considered(analysis: StudyAnalysis) -> list[FactorRow]:
    """Leave out what labbook.toml no longer names and no condition has: a name that was mistyped at first."""
    measured = {name for several in analysis.conditions.values() for item in several for name in item.levels}
    named = analysis.evidence.configuration.factors.keys() | measured
    return [row for row in analysis.evidence.factors if row.name in named]


def conditions(analysis: StudyAnalysis, shown: Shown) -> tuple[Condition, ...]:
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
                outcome: _summary(items[item.key], shown) for outcome, items in measured.items() if item.key in items
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
        if radius_m is None:
            found.append(Level(row.name, level.label, level.value, _number_unit(analysis, row)))
        else:
            found.append(Level(row.name, level.label, radius_m, "m"))
    return tuple(found)


def _summary(values: ConditionValues, shown: Shown) -> Summary:
    jumps = [len(item.result.heights_m) for item in values.runs if isinstance(item.result, RunApexes)]
    return Summary(
        mean=shown.number(values.summary.mean),
        sd=shown.value(values.summary.sd),
        runs=tuple(RunValue(item.run.name, item.value) for item in values.runs),
        jumps=sum(jumps) or None,
        robots=dict(Counter(item.run.robot for item in values.runs)),
    )
