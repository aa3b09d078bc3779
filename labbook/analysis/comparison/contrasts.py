"""Contrasts of condition means: what levels of a factor differ by, and what the saving depends on.

Without contrasts in the plan those are made that its factors suggest, exploratory: of every further factor the
differences between its levels and the interaction with the saving, and the trend over the levels of the treatment.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import ContrastKind, Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import FamilyResult, Member, adjust_members
from labbook.analysis.comparison.deciding import fingerprints_of_contrast
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, interval_ends
from labbook.config.model import AnalysisSettings, ContrastSettings, Side, UnitOfAnalysis
from reports.numbers import Number
from stats.days.contrasts import Effect, RunsOfCondition, linear_contrast
from stats.days.decision import Rule
from stats.days.two_by_day import blocks_of_runs


@dataclass(frozen=True, slots=True)
class ContrastResult(StoredResult):
    """A contrast by `stats.days.contrasts`; `rejected` is before Holm's method, None where nothing is tested."""

    estimate: Number
    t: Number
    p: Number
    rule: Rule
    days: tuple[str, ...]
    rejected: bool | None


ALGORITHM = Algorithm("contrast", 1, ContrastResult)


@dataclass(frozen=True, slots=True)
class MeansContrast:
    """What is asked, of which pairs of conditions with which weights.

    `levels` are those that are compared, the second with the first, or that a line goes through, none where the runs
    have fewer than two; without `terms` runs
    of it are missing, and `left_out` counts combinations of other levels that one side lacks. The estimate is in
    percentage points of savings (`percent`) or in the outcome's unit; a trend's is for each `per` of the factor.
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


@dataclass(frozen=True, slots=True)
class Contrasted:
    """A contrast, its result, and p by Holm's method over all contrasts where there are several."""

    asked: MeansContrast
    result: ContrastResult
    adjusted: FamilyResult | None


def contrast_means(
    cache: ResultCache,
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    swept: str,
    values: Mapping[str, float],
    settings: AnalysisSettings,
    scope: Mapping[str, Any],
) -> list[Contrasted]:
    """Ensure the contrasts of the plan, or those that the factors suggest; `values` are those of the swept levels."""
    every = (
        one
        for each in settings.contrasts or _suggested(conditions, swept, values)
        for one in contrasts_of(each, conditions.get(each.outcome, ()), swept, values)
        if one.terms or settings.contrasts
    )
    asked = list({one.label: one for one in every}.values())
    results = cache.ensure([_request(one, settings, scope) for one in asked])
    members = [Member(one.label, result, result.t, result.p) for one, result in zip(asked, results, strict=True)]
    family = adjust_members(cache, members, "contrasts", scope, settings.alpha) if len(members) > 1 else None
    return [Contrasted(one, result, family) for one, result in zip(asked, results, strict=True)]


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
) -> list[MeansContrast]:
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
) -> Iterator[MeansContrast]:
    """Set every level of a factor against the first, as the mean over all levels of the others that hold both."""
    factor = settings.factor
    by_level: dict[str, dict[tuple[tuple[str, str], ...], Pair]] = {}
    for pair in pairs:
        others = tuple((name, label) for name, label in pair.group.items() if name != factor)
        by_level.setdefault(pair.group.get(factor, ""), {})[(*others, ("", pair.level))] = pair
    first, *further = settings.levels or sorted(by_level, key=pairing.sort_key) or [""]
    if not further:
        yield MeansContrast(settings, (), (), percent)
    of_first = by_level.get(first, {})
    for level in further:
        both = [(of_first[others], pair) for others, pair in by_level.get(level, {}).items() if others in of_first]
        terms = tuple(term for pair in both for term in compare(*pair, 1.0 / len(both)))
        left_out = len(of_first.keys() ^ by_level.get(level, {}).keys())
        yield MeansContrast(settings, (first, level), terms, percent, left_out=left_out)


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
) -> MeansContrast:
    """Return the slope over one stretch of levels, or that over the first less that over the second.

    It is the mean over the groups that have two levels in every stretch, for each power of ten within the longest.
    """
    spans = [values[each[-1]] - values[each[0]] for each in stretches if len(each) > 1]
    per = 10.0 ** math.floor(math.log10(max(spans))) if spans else 1.0
    groups: dict[tuple[tuple[str, str], ...], list[Pair]] = {}
    for pair in pairs:
        groups.setdefault(tuple(pair.group.items()), []).append(pair)
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
    return MeansContrast(settings, levels, tuple(terms), percent, per)


def _slope(pairs: Sequence[Pair], values: Mapping[str, float]) -> _Terms:
    """Return the weights of the least-squares slope over a group's levels."""
    middle = math.fsum(values[pair.level] for pair in pairs) / len(pairs)
    squares = math.fsum((values[pair.level] - middle) ** 2 for pair in pairs)
    return [((values[pair.level] - middle) / squares, pair) for pair in pairs]


def _request(asked: MeansContrast, settings: AnalysisSettings, scope: Mapping[str, Any]) -> Request[ContrastResult]:
    by_day = settings.unit_of_analysis is not UnitOfAnalysis.RUN
    return Request(
        ALGORITHM,
        {"quantity": str(asked.settings.outcome), "label": asked.label, **scope},
        tuple(dict.fromkeys(row for _weight, pair in asked.terms for row in fingerprints_of_contrast(pair))),
        {
            "terms": [[weight, _name(pair.b), _name(pair.a)] for weight, pair in asked.terms],
            "percent": asked.percent,
            "alpha": settings.alpha,
            "by_day": by_day,
        },
        lambda: contrast_result(asked, settings.alpha, by_day=by_day),
    )


def contrast_result(asked: MeansContrast, alpha: float, *, by_day: bool = True) -> ContrastResult:
    """Compute a contrast, with an interval of level 1 - alpha; without `by_day` as if all runs were of one day."""
    outcome = asked.settings.outcome
    if not asked.terms:
        none = Undefined(Reason.CONTRAST_WITHOUT_RUNS)
        missing = Number(none, "%" if asked.percent else outcome.unit)
        return ContrastResult(missing, Number(none, "1"), Number(none, "1"), Rule.NONE, (), None)
    sides = {_name(side): side for _weight, pair in asked.terms for side in (pair.a, pair.b)}
    runs = {name: _runs(name, side, by_day) for name, side in sides.items()}
    effects = [Effect(weight, _name(pair.b), _name(pair.a)) for weight, pair in asked.terms]
    found = linear_contrast(runs, effects, percent=asked.percent, level=1.0 - alpha)
    estimate = found.estimate
    low, high = interval_ends(estimate.ci)
    shared = estimate.shared_se if outcome.shares_error or estimate.shared_se else None
    return ContrastResult(
        estimate=Number(
            estimate.value,
            "%" if asked.percent else outcome.unit,
            estimate.se,
            shared,
            low,
            high,
            estimate.level,
            df=estimate.df,
            n=found.n,
        ),
        t=Number(estimate.t, "1", df=estimate.df, n=found.n),
        p=Number(estimate.p, "1", df=estimate.df, n=found.n),
        rule=found.rule,
        days=found.days if by_day else (),
        rejected=None if isinstance(estimate.p, Undefined) else estimate.p <= alpha,
    )


def _name(side: Sequence[ConditionValues]) -> str:
    return "; ".join(item.key for item in side)


def _runs(name: str, side: Sequence[ConditionValues], by_day: bool) -> RunsOfCondition:
    items = [item for condition in side for item in condition.runs]
    return blocks_of_runs(
        name,
        [item.value for item in items],
        [item.run.day for item in items] if by_day else None,
        None,
        [item.shared for item in items],
    )
