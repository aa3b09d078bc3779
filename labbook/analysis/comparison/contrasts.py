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

    `levels` are those that are compared, the second with the first, or that a line goes through. The estimate is in
    percentage points of savings (`percent`) or in the outcome's unit; a trend's is for each `per` of the factor.
    """

    settings: ContrastSettings
    levels: tuple[str, ...]
    terms: tuple[tuple[float, Pair], ...]
    percent: bool
    per: float = 1.0

    @property
    def label(self) -> str:
        """Its name among the contrasts of a study."""
        settings = self.settings
        return ", ".join([str(replace(settings, levels=())), " ".join(self.levels)])

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
    asked = [
        one
        for each in settings.contrasts or _suggested(conditions, swept, values)
        for one in contrasts_of(each, conditions.get(each.outcome, ()), swept, values)
    ]
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
    """Return the contrasts that were asked for: one for each further level, of a trend one; none without their runs."""
    percent = settings.outcome.has_savings and settings.kind is not ContrastKind.DIFFERENCE
    if settings.kind is ContrastKind.DIFFERENCE:
        side = [one for one in conditions if one.is_control is (settings.side is Side.CONTROL)]
        pairs = [Pair("", "", of, of[settings.factor], (), tuple(each)) for of, each in _by_level(side, swept)]
        return list(_between_levels(settings, pairs, _difference, percent))
    if settings.kind in (ContrastKind.POOLED, ContrastKind.INTERACTION):
        pairs = pairing.pairs_pooled(conditions, swept)
        if settings.kind is ContrastKind.POOLED:
            terms = tuple((1.0 / len(pairs), pair) for pair in pairs)
            return [MeansContrast(settings, (), terms, percent)] if terms else []
        return list(_between_levels(settings, pairs, _interaction, percent))
    levels = sorted(set(settings.levels or values), key=values.__getitem__)
    pairs = [pair for pair in pairing.pairs_each(conditions, swept) if pair.level in levels]
    levels = [level for level in levels if any(pair.level == level for pair in pairs)]
    at = settings.at
    stretches = [levels] if at is None else [
        [level for level in levels if values[level] <= at], [level for level in levels if values[level] >= at]
    ]  # fmt: skip
    spans = [values[each[-1]] - values[each[0]] for each in stretches if len(each) > 1]
    if len(spans) < len(stretches):
        return []
    per = 10.0 ** math.floor(math.log10(max(spans)))
    terms = tuple(
        term
        for sign, each in zip((1.0, -1.0), stretches, strict=False)
        for term in _slopes([pair for pair in pairs if pair.level in each], values, sign * per)
    )
    return [MeansContrast(settings, tuple(levels), terms, percent, per)] if terms else []


def _by_level(side: Sequence[ConditionValues], swept: str) -> list[tuple[dict[str, str], list[ConditionValues]]]:
    """Return the conditions of one side by their levels of the further factors."""
    return pairing.by_levels(side, pairing.other_factors(side, swept))


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
        by_level.setdefault(pair.group.get(factor, ""), {})[others] = pair
    first, *further = settings.levels or sorted(by_level, key=pairing.sort_key) or [""]
    of_first = by_level.get(first, {})
    for level in further:
        both = [(of_first[others], pair) for others, pair in by_level.get(level, {}).items() if others in of_first]
        terms = tuple(term for pair in both for term in compare(*pair, 1.0 / len(both)))
        if terms:
            yield MeansContrast(settings, (first, level), terms, percent)


def _difference(first: Pair, level: Pair, weight: float) -> _Terms:
    return [(weight, replace(level, a=first.b))]


def _interaction(first: Pair, level: Pair, weight: float) -> _Terms:
    return [(weight, level), (-weight, first)]


def _slopes(pairs: Sequence[Pair], values: Mapping[str, float], per: float) -> _Terms:
    """Return the weights of the least-squares slope, for each `per`, as the mean over the groups that have one."""
    groups: dict[tuple[tuple[str, str], ...], list[Pair]] = {}
    for pair in pairs:
        groups.setdefault(tuple(pair.group.items()), []).append(pair)
    several = [each for each in groups.values() if len({pair.level for pair in each}) > 1]
    terms = []
    for each in several:
        middle = math.fsum(values[pair.level] for pair in each) / len(each)
        squares = math.fsum((values[pair.level] - middle) ** 2 for pair in each)
        terms += [(per * (values[pair.level] - middle) / squares / len(several), pair) for pair in each]
    return terms


def _request(asked: MeansContrast, settings: AnalysisSettings, scope: Mapping[str, Any]) -> Request[ContrastResult]:
    by_day = settings.unit_of_analysis is not UnitOfAnalysis.RUN
    return Request(
        ALGORITHM,
        {"quantity": str(asked.settings.outcome), "label": asked.label, **scope},
        tuple(dict.fromkeys(row for _weight, pair in asked.terms for row in fingerprints_of_contrast(pair))),
        {
            "weights": [weight for weight, _pair in asked.terms],
            "percent": asked.percent,
            "alpha": settings.alpha,
            "by_day": by_day,
        },
        lambda: contrast_result(asked, settings.alpha, by_day=by_day),
    )


def contrast_result(asked: MeansContrast, alpha: float, *, by_day: bool = True) -> ContrastResult:
    """Compute a contrast, with an interval of level 1 - alpha; without `by_day` as if all runs were of one day."""
    sides = {_name(side): side for _weight, pair in asked.terms for side in (pair.a, pair.b)}
    runs = {name: _runs(name, side, by_day) for name, side in sides.items()}
    effects = [Effect(weight, _name(pair.b), _name(pair.a)) for weight, pair in asked.terms]
    found = linear_contrast(runs, effects, percent=asked.percent, level=1.0 - alpha)
    estimate, outcome = found.estimate, asked.settings.outcome
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
        days=found.days,
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
