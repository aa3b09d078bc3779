"""Contrasts of condition means: what levels of a factor differ by, and what the saving depends on.

Without contrasts in the plan those are made that its factors suggest, exploratory: of every further factor the
differences between its levels and the interaction with the saving, and the trend over the levels of the treatment.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import ContrastKind, Rule, Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import adjust
from labbook.analysis.comparison.deciding import estimate_number, fingerprints_of_contrast, runs_of
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.preregistration.planned import Planned
from labbook.analysis.results import Algorithm, Results
from labbook.config.model import ContrastSettings, Side
from reports.numbers import Number
from reports.results import MeansContrast
from stats.days.contrasts import Effect, linear_contrast
from stats.days.decision import CONTROL, TREATED, blocks_of_runs

ALGORITHM = Algorithm("contrast", 2)
_SIDES = {TREATED: "the level", CONTROL: "the reference"}
"""What reasons call the sides of a difference between levels."""


@dataclass(frozen=True, slots=True)
class AskedContrast:
    """What is asked, of which pairs of conditions with which weights.

    `levels` are those that are compared, the second with the first, or that a line goes through, none where the runs
    have fewer than two; without `terms` runs of it are missing, and `left_out` counts combinations of other levels that
    one side lacks. The estimate is in percentage points of savings (`percent`) or in the outcome's unit; a trend's is
    for each `per` of the factor.
    """

    settings: ContrastSettings
    levels: tuple[str, ...]
    terms: tuple[tuple[float, Pair], ...]
    percent: bool
    per: float = 1.0
    left_out: int = 0

    @property
    def label(self) -> str:
        """Its name among the contrasts of a study."""
        settings = self.settings
        return ", ".join([str(replace(settings, levels=())), settings.outcome.key, " ".join(self.levels)])

    @property
    def conditions(self) -> tuple[str, ...]:
        """The keys of the conditions that enter."""
        keys = (item.key for _weight, pair in self.terms for item in (*pair.a, *pair.b))
        return tuple(dict.fromkeys(keys))


def contrast_means(
    computed: Results,
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    swept: str,
    values: Mapping[str, float],
    planned: Planned,
    *,
    selected: bool,
) -> list[MeansContrast]:
    """Compute the contrasts of the plan, or those that the factors suggest; `values` are those of the swept levels.

    Several are a family, whose p is adjusted by Holm's method.
    """
    settings = planned.settings
    asked = asked_contrasts(settings.contrasts, conditions, swept, values)
    tested = {label: _recorded(computed, one, swept, settings.alpha) for label, one in asked.items()}
    family = adjust(computed, tested, "contrasts", settings.alpha)
    found = []
    for label, result in tested.items():
        one = asked[label]
        why = planned.exploratory_contrast(one.settings.outcome, one.conditions, selected=selected) or ""
        if family is None:
            found.append(replace(result, exploratory=why))
        else:
            adjusted, rejected = family.adjusted_p[label], family.rejected[label]
            found.append(replace(result, exploratory=why, adjusted=adjusted, rejected=rejected))
    return found


def asked_contrasts(
    planned: Sequence[ContrastSettings],
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    swept: str,
    values: Mapping[str, float],
) -> dict[str, AskedContrast]:
    """Return the contrasts that are planned, or else those that the factors suggest, by their labels."""
    every = (
        one
        for each in planned or _suggested(conditions, swept, values)
        for one in contrasts_of(each, conditions.get(each.outcome, ()), swept, values)
        if one.terms or planned
    )
    return {one.label: one for one in every}


def _suggested(
    conditions: Mapping[Outcome, Sequence[ConditionValues]], swept: str, values: Mapping[str, float]
) -> Iterator[ContrastSettings]:
    for outcome, several in conditions.items():
        if not outcome.has_savings:
            continue
        for factor in pairing.other_factors(several, swept):
            for side in Side:
                yield ContrastSettings(ContrastKind.DIFFERENCE, outcome, factor, side)
            yield ContrastSettings(ContrastKind.INTERACTION, outcome, factor)
        if len(values) > 2:
            yield ContrastSettings(ContrastKind.TREND, outcome)


def contrasts_of(
    settings: ContrastSettings, conditions: Sequence[ConditionValues], swept: str, values: Mapping[str, float]
) -> list[AskedContrast]:
    """Return the contrasts that were asked for; without terms where their runs are missing.

    They are one for each further level, one of a trend, and beside a trend that may level off that from there on.
    """
    percent = settings.outcome.has_savings and settings.kind is not ContrastKind.DIFFERENCE
    if settings.kind is ContrastKind.DIFFERENCE:
        side = [one for one in conditions if one.is_control is (settings.side is Side.CONTROL)]
        names = [*pairing.other_factors(side, swept), swept]
        cells = [Pair("", "", of, "", (), tuple(each)) for of, each in pairing.by_levels(side, names)]
        return list(_between_levels(settings, cells, _difference, percent))
    pairs = pairing.pairs_each(conditions, swept)
    if settings.kind is ContrastKind.INTERACTION:
        return list(_between_levels(settings, pairs, _interaction, percent))
    levels = sorted({each for each in settings.levels or values if each in values}, key=values.__getitem__)
    levels = [level for level in levels if any(pair.level == level for pair in pairs)]
    at = settings.at
    if at is None:
        return [_trend(settings, pairs, [levels], values, percent)]
    below, beyond = ([each for each in levels if (values[each] - at) * sign >= 0.0] for sign in (-1.0, 1.0))
    flat = replace(settings, kind=ContrastKind.TREND, levels=tuple(beyond), at=None)
    return [
        _trend(settings, pairs, [below, beyond], values, percent),
        _trend(flat, pairs, [beyond], values, percent),
    ]


_Terms = list[tuple[float, Pair]]
_Compare = Callable[[Pair, Pair, float], _Terms]
"""The terms that set the pair of a level against that of the first, with a weight."""


def _between_levels(
    settings: ContrastSettings, pairs: Sequence[Pair], compare: _Compare, percent: bool
) -> Iterator[AskedContrast]:
    """Set every level of a factor against the first, as the mean over all levels of the others that hold both."""
    factor = settings.factor
    by_level: dict[str, dict[tuple[tuple[str, str], ...], Pair]] = {}
    for pair in pairs:
        others = tuple((name, label) for name, label in pair.group.items() if name != factor)
        by_level.setdefault(pair.group.get(factor, ""), {})[(*others, ("", pair.level))] = pair
    first, *further = settings.levels or sorted(by_level, key=pairing.sort_key) or [""]
    if not further:
        yield AskedContrast(settings, (), (), percent)
    of_first = by_level.get(first, {})
    for level in further:
        both = [(of_first[others], pair) for others, pair in by_level.get(level, {}).items() if others in of_first]
        terms = tuple(term for pair in both for term in compare(*pair, 1.0 / len(both)))
        left_out = len(of_first.keys() ^ by_level.get(level, {}).keys())
        yield AskedContrast(settings, (first, level), terms, percent, left_out=left_out)


def _difference(first: Pair, level: Pair, weight: float) -> _Terms:
    return [(weight, replace(level, a=first.b))]


def _interaction(first: Pair, level: Pair, weight: float) -> _Terms:
    return [(weight, level), (-weight, first)]


def _trend(
    settings: ContrastSettings,
    pairs: Sequence[Pair],
    stretches: Sequence[Sequence[str]],
    values: Mapping[str, float],
    percent: bool,
) -> AskedContrast:
    """Return the slope over one stretch of levels, or that over the first less that over the second.

    It is the mean over the groups that have two levels in every stretch, for each power of ten within the longest.
    """
    spans = [values[each[-1]] - values[each[0]] for each in stretches if len(each) > 1]
    per = 10.0 ** math.floor(math.log10(max(spans))) if spans else 1.0
    groups = grouped(pairs, [tuple(pair.group.items()) for pair in pairs])
    sloped = [
        in_stretches
        for own in groups.values()
        for in_stretches in [[[pair for pair in own if pair.level in each] for each in stretches]]
        if all(len(each) > 1 for each in in_stretches)
    ]
    terms = [
        (sign * per * weight / len(sloped), pair)
        for in_stretches in sloped
        for sign, own in zip((1.0, -1.0), in_stretches, strict=False)
        for weight, pair in _slope(own, values)
    ]
    levels = tuple(dict.fromkeys(level for each in stretches for level in each))
    return AskedContrast(settings, levels, tuple(terms), percent, per)


def _slope(pairs: Sequence[Pair], values: Mapping[str, float]) -> _Terms:
    """Return the weights of the least-squares slope over a group's levels."""
    middle = math.fsum(values[pair.level] for pair in pairs) / len(pairs)
    squares = math.fsum((values[pair.level] - middle) ** 2 for pair in pairs)
    return [((values[pair.level] - middle) / squares, pair) for pair in pairs]


def _recorded(computed: Results, asked: AskedContrast, swept: str, alpha: float) -> MeansContrast:
    return computed.record(
        ALGORITHM,
        {"quantity": str(asked.settings.outcome), "label": asked.label},
        dict.fromkeys(row for _weight, pair in asked.terms for row in fingerprints_of_contrast(pair)),
        contrast_result(asked, swept, alpha),
        {
            "terms": [[weight, _name(pair.b), _name(pair.a)] for weight, pair in asked.terms],
            "percent": asked.percent,
            "alpha": alpha,
        },
    )


def contrast_result(asked: AskedContrast, swept: str, alpha: float) -> MeansContrast:
    """Compute a contrast, with an interval of level 1 - alpha."""
    settings, unit = asked.settings, "%" if asked.percent else asked.settings.outcome.unit
    none = Undefined(Reason.CONTRAST_WITHOUT_RUNS)
    estimate, t, p = Number(none, unit), Number(none, "1"), Number(none, "1")
    rule, days = Rule.NONE, tuple[str, ...]()
    if asked.terms:
        sides = {_name(side): runs_of(side) for _weight, pair in asked.terms for side in (pair.a, pair.b)}
        runs = {
            name: blocks_of_runs(
                name,
                [item.value for item in items],
                [item.run.day for item in items],
                None,
                [item.shared for item in items],
            )
            for name, items in sides.items()
        }
        effects = [Effect(weight, _name(pair.b), _name(pair.a)) for weight, pair in asked.terms]
        found = linear_contrast(runs, effects, percent=asked.percent, level=1.0 - alpha)
        rule, days, one = found.rule, found.days, found.estimate
        estimate = estimate_number(one, unit, found.n, shares_error=settings.outcome.shares_error)
        t, p = (Number(each, "1", df=one.df, n=found.n) for each in (one.t, one.p))
        if settings.kind is ContrastKind.DIFFERENCE:  # of levels: neither is a control
            estimate, t, p = (each.called(_SIDES, "run") for each in (estimate, t, p))
    return MeansContrast(
        kind=settings.kind,
        quantity=settings.outcome,
        factor=settings.factor or swept,
        levels=asked.levels,
        side=str(settings.side or ""),
        per=asked.per,
        at=settings.at,
        left_out=asked.left_out,
        estimate=estimate,
        t=t,
        p=p,
        rule=rule,
        days=days,
        rejected=None if isinstance(p.value, Undefined) else p.value <= alpha,
    )


def _name(side: Sequence[ConditionValues]) -> str:
    return "; ".join(item.key for item in side)
