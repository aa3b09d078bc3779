"""Days and the order of runs in them: what is confounded with the day, and headlines that the order favours.

These are adjusted for a drift over the day.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.sources import InputRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.deciding import Overall, overall_effects
from labbook.analysis.comparison.pairing import Pair, group_label, study_factor
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.preregistration.planned import Planned
from labbook.analysis.results import Results, fingerprint
from labbook.analysis.study_data import StudyData
from reports.display import in_sentence
from reports.numbers import Number
from reports.results import Favoured, Varied
from stats.compare.shared_error import SharedError
from stats.days.order import PositionsCompared, adjust_for_position, compare_positions
from stats.groups.multiple import holm

ADJUSTED = "adjusted for position"
OVER_GROUPS = ""
"""What the effect over all groups stands under, beside groups by their labels."""
ALPHA = 0.04
"""How often at most a report of runs in random order says that a headline is favoured: 5 % with room to show it."""


def confounded_with_day(evidence: StudyData, swept: str | None) -> tuple[str, ...]:
    """Say which factors are confounded with the day, because most days saw one level of them only.

    A day with a single run shows nothing of the kind and does not count.
    """
    runs = [run for run in evidence.runs if run.levels]
    days_of = [of_day for of_day in grouped(runs, [run.day for run in runs]).values() if len(of_day) > 1]
    sentences, named = [], set()
    for factor in evidence.factors:
        levels = {run.levels.get(factor.name) for run in runs}
        single = sum(len({run.levels.get(factor.name) for run in of_day}) == 1 for of_day in days_of)
        if len(levels) > 1 and 2 * single > len(days_of):
            named.add(factor.name)
            title = in_sentence(study_factor(evidence.configuration, factor.name).title)
            sentences.append(
                f"On {single} of the {len(days_of)} days with two or more runs all runs had one level of the {title}: "
                f"differences between its levels are {_confounded(single, len(days_of))} differences between days."
            )
    if swept is not None and swept not in named and any(run.is_control for run in runs):
        without = sum(not any(run.is_control for run in of_day) for of_day in days_of)
        if 2 * without > len(days_of):
            sentences.append(
                f"On {without} of the {len(days_of)} days with two or more runs there was no control run: differences "
                f"from the control are {_confounded(without, len(days_of))} differences between days."
            )
    return tuple(sentences)


def _confounded(count: int, days: int) -> str:
    return "confounded with" if count == days else "largely confounded with"


def favoured_headlines(
    computed: Results,
    pooled: Mapping[Outcome, Sequence[Pair]],
    effects: Overall,
    planned: Planned,
    varied: Iterable[Varied],
) -> tuple[Favoured, ...]:
    """Return the headlines that the order within days favours, adjusted: that over all groups, else those of groups.

    `pooled` are the pairs of all levels with the control, `effects` those over all groups, `varied` the recomputed
    headlines.
    """
    every = {pair.label: pair.group for pairs in pooled.values() for pair in pairs}
    over_groups = bool(effects.savings) or effects.equivalent is not None
    tests = favoured_by_order((pair for pairs in pooled.values() for pair in pairs), over_groups=over_groups)
    if OVER_GROUPS in tests:
        moved = {outcome: adjusted_for_position(pairs) for outcome, pairs in pooled.items()}
        known = {outcome: pairs for outcome, pairs in moved.items() if not isinstance(pairs, Undefined)}
        found = overall_effects(computed.about(variant=ADJUSTED), known, planned, fingerprints_of_positions)
        adjusted = {outcome: one.savings for outcome, one in found.savings.items()}
        if found.equivalent is not None:
            adjusted[Outcome.APEX] = found.equivalent.estimate
        return (Favoured(None, tests[OVER_GROUPS], _claimed(adjusted)),)
    of_label: dict[str, dict[Outcome, Number]] = {label: {} for label in every}
    for one in varied:
        if one.variant == ADJUSTED:
            of_label[one.headline][one.quantity] = one.result.headline
    return tuple(
        Favoured(group, tests[group_label(group)], _claimed(of_label[label]))
        for label, group in every.items()
        if group_label(group) in tests
    )


def _claimed(adjusted: Mapping[Outcome, Number]) -> dict[Outcome, Number]:
    return {outcome: adjusted[outcome] for outcome in (Outcome.JOULES, Outcome.APEX) if outcome in adjusted}


def favoured_by_order(pairs: Iterable[Pair], *, over_groups: bool) -> dict[str, PositionsCompared]:
    """Return the groups whose sides lie farther apart in the day than in a random order, by their labels.

    `pairs` are those of all levels with the control, of any outcomes: a run counts once. With `over_groups` the effect
    over all groups is tested, too. Holm's p of these tests is at most `ALPHA`.
    """
    runs = {
        (group_label(pair.group), item.run.uid): (item.run, treated)
        for pair in pairs
        for treated, side in ((False, pair.a), (True, pair.b))
        for condition in side
        for item in condition.runs
    }

    def compared(groups: Iterable[str]) -> PositionsCompared | Undefined:
        own = [
            (f"{label} {run.day}", run, treated) for (label, _uid), (run, treated) in runs.items() if label in groups
        ]
        return compare_positions(
            [run.position_in_day for _day, run, _treated in own],
            [treated for _day, _run, treated in own],
            [day for day, _run, _treated in own],
        )

    labels = list(dict.fromkeys(label for label, _uid in runs))
    families = {label: {label} for label in labels}
    if over_groups and len(labels) > 1:
        families = {OVER_GROUPS: set(labels), **families}
    tests = {name: found for name, own in families.items() if not isinstance(found := compared(own), Undefined)}
    adjusted = holm({name: test.p for name, test in tests.items()}, "order of the runs", alpha=ALPHA)
    p_of = dict(zip(adjusted.names, adjusted.adjusted_p, strict=True))
    return {
        name: replace(test, p=p) for name, test in tests.items() if isinstance(p := p_of[name], float) and p <= ALPHA
    }


def adjusted_for_position(pairs: Sequence[Pair]) -> list[Pair] | Undefined:
    """Return the pairs of one outcome, of different groups, with every run as at the mean position of its group's day.

    Undefined where the runs leave no slope to estimate.
    """
    rows = [
        (f"{group_label(pair.group)} {item.run.day}", item, treated)
        for pair in pairs
        for treated, side in ((False, pair.a), (True, pair.b))
        for condition in side
        for item in condition.runs
    ]
    if not rows:
        return []
    found = adjust_for_position(
        [item.value for _day, item, _treated in rows],
        [item.run.position_in_day for _day, item, _treated in rows],
        [treated for _day, _item, treated in rows],
        [day for day, _item, _treated in rows],
        [item.run.condition_key for _day, item, _treated in rows],
    )
    if isinstance(found, Undefined):
        return found
    adjusted = {
        item.run.uid: replace(item, value=value, shared=_with(item.shared, shared))
        for (_day, item, _treated), value, shared in zip(rows, found.values, found.shared, strict=True)
    }
    return [replace(pair, a=_side(pair.a, adjusted), b=_side(pair.b, adjusted)) for pair in pairs]


def _with(one: SharedError, other: SharedError) -> SharedError:
    return SharedError({**one.terms, **other.terms}, {**one.df, **other.df})


def _side(side: Sequence[ConditionValues], adjusted: Mapping[str, RunNumber]) -> tuple[ConditionValues, ...]:
    return tuple(replace(one, runs=tuple(adjusted[item.run.uid] for item in one.runs)) for one in side)


def fingerprints_of_positions(pairs: Iterable[Pair]) -> tuple[InputRow, ...]:
    """Name the position in its day of every run: what adjusted values rest on beside values and days."""
    runs = [item.run for pair in pairs for side in (pair.a, pair.b) for one in side for item in one.runs]
    return tuple(fingerprint("position", "position", run.uid, str(run.position_in_day)) for run in runs)
