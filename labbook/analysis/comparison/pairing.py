"""Which conditions are compared with which, in which order, and which group of a comparison is the control.

The thesis's families of comparisons, for any study with one swept factor: the one whose configuration names a control
level (the active-damping gain). The others form groups (foot, extension gain).
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from data_schema.errors import InputRefused, unknown_name
from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.vocabulary import FactorKind
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.study_data import StudyData
from labbook.config.parsing import Configuration
from reports.results import Condition, Factor, Level


@dataclass(frozen=True, slots=True)
class Pair:
    """Two sets of conditions to compare: `a` is the control or the first level, `b` what is compared with it."""

    family: str
    label: str
    group: Mapping[str, str]
    level: str
    a: tuple[ConditionValues, ...]
    b: tuple[ConditionValues, ...]


EACH = "each level against the control"
POOLED = "all levels pooled against the control"


def swept_factor(configuration: Configuration) -> str | None:
    """Return the factor with a control level."""
    return next((name for name, factor in configuration.factors.items() if factor.control is not None), None)


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
        swept=name == swept_factor(configuration),
        treatment=(settings.treatment if settings else None) or "",
        control_name=(settings.control_name if settings else None) or "",
    )


def study_factors(evidence: StudyData, conditions: Iterable[ConditionValues]) -> tuple[Factor, ...]:
    """Return the study's factors with the formulas that turn gains into physical values.

    One that labbook.toml no longer names and no condition has is left out: a name that was mistyped at first.
    """
    named = evidence.configuration.factors.keys() | {name for one in conditions for name in one.levels}
    return tuple(study_factor(evidence.configuration, row.name) for row in evidence.factors if row.name in named)


def study_conditions(
    evidence: StudyData, measured: Mapping[Outcome, Sequence[ConditionValues]]
) -> tuple[Condition, ...]:
    """Return every condition that has a measured quantity, in the order of the factors' levels, the swept one last.

    So the control and the treated conditions of one group stand together.
    """
    by_key = {outcome: {item.key: item for item in several} for outcome, several in measured.items()}
    every = {key: item for items in by_key.values() for key, item in items.items()}
    swept = swept_factor(evidence.configuration)
    return tuple(
        Condition(
            levels=_levels(evidence, item.levels),
            control=item.is_control,
            summaries={outcome: items[item.key].result for outcome, items in by_key.items() if item.key in items},
        )
        for item in sorted(every.values(), key=lambda item: place(evidence.labels, swept, item.levels))
    )


def _levels(evidence: StudyData, labels: Mapping[str, str]) -> tuple[Level, ...]:
    found = []
    for row in evidence.factors:
        level = next((level for level in row.levels if level.label == labels.get(row.name)), None)
        if level is None:
            continue
        gain = evidence.configuration.gains.get(row.name)
        if gain is not None and level.value is not None:
            found.append(Level(row.name, level.label, gain.physical(level.value), gain.unit, level.value))
            continue
        radius_m = json.loads(level.attributes_json).get("radius_m")
        unit = study_factor(evidence.configuration, row.name).unit
        found.append(Level(row.name, level.label, *((level.value, unit) if radius_m is None else (radius_m, "m"))))
    return tuple(found)


def treated_values(configuration: Configuration, swept: str) -> dict[str, float]:
    """Return the numbers of the levels of the swept factor but for the control, of those that have one."""
    factor = configuration.factors[swept]
    return {
        level.label: level.value for level in factor.levels if level.value is not None and level.label != factor.control
    }


def groups(conditions: Sequence[ConditionValues], swept: str) -> list[tuple[dict[str, str], list[ConditionValues]]]:
    """Return the groups of conditions that differ in the swept factor only, in order of first occurrence."""
    found = grouped(conditions, [tuple(item for item in one.levels.items() if item[0] != swept) for one in conditions])
    return [(dict(key), items) for key, items in found.items()]


def group_label(group: Mapping[str, str]) -> str:
    """Return a group's name as sentences use it: "foot small, k_gain 400"."""
    return ", ".join(f"{name} {label}" for name, label in group.items()) or "all runs"


def treated_and_control(items: Sequence[ConditionValues]) -> tuple[list[ConditionValues], list[ConditionValues]]:
    """Split a group into treated and control conditions."""
    return [item for item in items if not item.is_control], [item for item in items if item.is_control]


def pairs_with_control(conditions: Sequence[ConditionValues], swept: str) -> list[Pair]:
    """Pair each level with its control, and all together: the families that can be decided on."""
    return [*pairs_each(conditions, swept), *pairs_pooled(conditions, swept)]


def pairs_each(conditions: Sequence[ConditionValues], swept: str) -> list[Pair]:
    """Pair every level of the swept factor with its control, group by group."""
    return [
        Pair(EACH, f"{group_label(group)}: {swept} {item.levels[swept]} against the control", group, item.levels[swept],
             tuple(control), (item,))
        for group, items in groups(conditions, swept)
        for treated, control in [treated_and_control(items)]
        if control
        for item in sorted(treated, key=lambda item: sort_key(item.levels[swept]))
    ]  # fmt: skip


def pairs_pooled(conditions: Sequence[ConditionValues], swept: str) -> list[Pair]:
    """Pair all treated conditions of a group with its control."""
    return [
        Pair(
            POOLED,
            f"{group_label(group)}: pooled against the control",
            group,
            "pooled",
            tuple(control),
            tuple(treated),
        )
        for group, items in groups(conditions, swept)
        for treated, control in [treated_and_control(items)]
        if control and treated
    ]


def other_factors(conditions: Sequence[ConditionValues], swept: str) -> list[str]:
    """Return the factors of the conditions but for the swept one."""
    return list(dict.fromkeys(name for condition in conditions for name in condition.levels if name != swept))


def by_levels(
    conditions: Sequence[ConditionValues], names: Sequence[str]
) -> list[tuple[dict[str, str], list[ConditionValues]]]:
    """Return the groups of conditions with the same levels of these factors, in order of first occurrence."""
    found = grouped(conditions, [tuple((name, one.levels.get(name, "")) for name in names) for one in conditions])
    return [(dict(key), items) for key, items in found.items()]


def place(known: Mapping[str, Sequence[str]], swept: str | None, levels: Mapping[str, str]) -> list[int]:
    """Return what sorts a condition with these levels; `known` has the labels of each factor in their order.

    A level that a condition has not comes first, one that is not known last.
    """
    factors = sorted(known, key=lambda name: name == swept)
    return [_position(known[name], levels[name]) if name in levels else -1 for name in factors]


def place_configured(configuration: Configuration, levels: Mapping[str, str]) -> list[int]:
    """Return what sorts a condition by the factors and levels of labbook.toml."""
    known = {name: [level.label for level in factor.levels] for name, factor in configuration.factors.items()}
    return place(known, swept_factor(configuration), levels)


def _position(labels: Sequence[str], label: str) -> int:
    return labels.index(label) if label in labels else len(labels)


def with_control(control: str | None, by: str, labels: Sequence[str], usual: str | None = None) -> str:
    """Return the label of the control: the one given, the usual one, or the first in order.

    Raises `UnknownName` for a label that no value has.
    """
    if not labels:
        raise InputRefused(f"there is no value to group by {by}: select others with --where.")
    if control is not None and control not in labels:
        raise unknown_name(f"level of {by}", control, labels)
    if control is None and usual in labels:
        return str(usual)
    return min(labels, key=sort_key) if control is None else control


def sort_key(label: str) -> tuple[int, float, tuple[tuple[str, int], ...], str]:
    """Return what sorts numbers by size, and words by alphabet with whole numbers in them by size."""
    try:
        number = float(label)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        parts = re.findall(r"([^0-9]*)([0-9]*)", label)
        return (1, 0.0, tuple((word, int(digits or -1)) for word, digits in parts), label)
    return (0, number, (), label)
