"""Every comparison of a study: the test that decides, the thesis's route and what stands beside (Holm, equivalence).

Holm's p counts comparisons of the planned family that a report does not show: without them a report on one foot would
have smaller adjusted p-values than the report on both from the same data.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.by_day import DayComparison, compare_by_day
from labbook.analysis.comparison.comparing import (
    ComparisonResult,
    EquivalenceResult,
    compare,
    pairs_in_units,
    welch_one_sided,
    within_bounds,
)
from labbook.analysis.comparison.deciding import DecisionResult, decide, decide_equivalence
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues, condition_values, measure, unit_scope
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.preregistration.planned import FAMILY_OF
from labbook.analysis.results.codec import Algorithm, StoredAs, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, result_fingerprint
from labbook.analysis.study_data import StudyData
from labbook.config.model import AnalysisSettings, Family, UnitOfAnalysis
from reports.numbers import Number
from stats.exact.tails import t_two_sided
from stats.groups.multiple import holm


@dataclass(frozen=True, slots=True)
class FamilyResult(StoredResult):
    """Holm's p of the test of every pair of a family by its label, and whether it is at most alpha.

    `rejected` is None where a pair has no p.
    """

    adjusted_p: Annotated[Mapping[str, Number], StoredAs("adjusted_p, {}")]
    rejected: Mapping[str, bool | None]


FAMILY = Algorithm("family", 7, FamilyResult)
"""Of Welch's tests."""
DECISION_FAMILY = Algorithm("decision_family", 2, FamilyResult)


@dataclass(frozen=True, slots=True)
class Member:
    """A result of a family by its label, with the test in it that counts."""

    label: str
    result: StoredResult
    t: Number
    p: Number


def adjust(
    cache: ResultCache,
    tested: Sequence[tuple[Pair, ComparisonResult]],
    family: str,
    quantity: Outcome,
    scope: Mapping[str, Any],
    alpha: float = 0.05,
) -> FamilyResult:
    """Ensure the adjusted p of the Welch tests of a family."""
    members = [Member(pair.label, result, result.welch_t, result.welch_p) for pair, result in tested]
    return adjust_members(cache, members, family, {"quantity": str(quantity), **scope}, alpha, FAMILY)


def adjust_members(
    cache: ResultCache,
    members: Sequence[Member],
    family: str,
    scope: Mapping[str, Any],
    alpha: float,
    algorithm: Algorithm[FamilyResult] = DECISION_FAMILY,
) -> FamilyResult:
    """Ensure the adjusted p of the tests of a family."""
    return cache.ensure_one(
        Request(
            algorithm,
            {"family": family, **scope},
            tuple(result_fingerprint(one.label, one.result) for one in members),
            {"alpha": alpha},
            lambda: _adjusted(members, family, alpha),
        )
    )


def _adjusted(tested: Sequence[Member], family: str, alpha: float) -> FamilyResult:
    found = {one.label: one.p.value for one in tested}
    logs = {one.label: _log10_p(one.t) for one in tested if found[one.label] == 0.0}
    result = holm(found, family, log10_p=logs, alpha=alpha)
    return FamilyResult(
        adjusted_p={
            label: Number(p, "1", n=len(found)) for label, p in zip(result.names, result.adjusted_p, strict=True)
        },
        rejected={
            label: None if isinstance(verdict, Undefined) else verdict
            for label, verdict in zip(result.names, result.rejected, strict=True)
        },
    )


def _log10_p(t: Number) -> float | Undefined:
    """Return the logarithm of a p that is below all doubles, from the statistic that it belongs to."""
    if isinstance(t.value, Undefined):
        return t.value
    if not isinstance(t.df, float):
        return Undefined(Reason.TEST_WITHOUT_DF)
    return t_two_sided(t.value, t.df).log10_p


def unselected_conditions(
    cache: ResultCache,
    detections: Detections,
    evidence: StudyData,
    outcomes: Collection[Outcome],
    scope: Mapping[str, Any],
) -> dict[Outcome, list[ConditionValues]]:
    """Ensure the numbers of the conditions of which the selection takes no run."""
    if not evidence.beside:
        return {}
    other = replace(evidence, runs=evidence.beside)
    return {
        outcome: condition_values(cache, other.runs, found.results, outcome, scope)
        for outcome in outcomes
        for found in [measure(outcome, cache, detections, other)]
    }


def _unselected_pairs(
    pairs: Sequence[Pair], conditions: Sequence[ConditionValues], beside: Sequence[ConditionValues], swept: str
) -> list[Pair]:
    """Return the comparisons with the control that the conditions of all make, and those of the selection do not."""
    shown = {pair.label for pair in pairs}
    every = pairing.pairs_with_control([*conditions, *beside], swept) if beside else []
    return [pair for pair in every if pair.label not in shown]


@dataclass(frozen=True, slots=True)
class Decided:
    """What decides a comparison: the test by shared days, and by the same contrast equivalence and Holm's p."""

    result: DecisionResult
    equivalent: EquivalenceResult | None = None
    adjusted: FamilyResult | None = None


@dataclass(frozen=True, slots=True)
class Compared:
    """A pair with its runs, the quantity compared, the stored comparison, and the results beside it.

    `by_day` and `equivalent` are there for comparisons with the control, the second for heights where bounds were
    given; `adjusted` holds the p-values of the whole family that the pair belongs to, shown here or not. `decided` is
    there where the unit of analysis is decided by shared days.
    """

    pair: Pair
    quantity: Outcome
    result: ComparisonResult
    by_day: DayComparison | None = None
    adjusted: FamilyResult | None = None
    equivalent: EquivalenceResult | None = None
    decided: Decided | None = None

    @property
    def conditions(self) -> tuple[str, ...]:
        """The keys of the conditions compared."""
        return tuple(item.key for item in (*self.pair.a, *self.pair.b))

    @property
    def saving(self) -> Number | None:
        """The saving that the first page claims, with the interval that it gives; None where there are no savings."""
        return (self.result if self.decided is None else self.decided.result).savings

    @property
    def test(self) -> tuple[Number, Number]:
        """The t and the p of the claim."""
        if self.decided is not None:
            return self.decided.result.t, self.decided.result.p
        return self.result.welch_t, self.result.welch_p

    @property
    def one_sided(self) -> bool:
        """Whether the claim is tested against a saving alone."""
        return (self.result if self.decided is None else self.decided.result).one_sided

    @property
    def deciding(self) -> dict[str, StoredResult]:
        """The results that decide, by their role: the test, and where there is a family of tests Holm's p."""
        found = (self.result, self.adjusted) if self.decided is None else (self.decided.result, self.decided.adjusted)
        return {role: one for role, one in zip(("test", "family"), found, strict=True) if one is not None}

    @property
    def shown(self) -> bool | None:
        """Whether the first page says that the treatment saved or cost, Holm's p included; None where it cannot tell.

        Welch's test over runs tells nothing from what days differ by where each side had a day of its own.
        """
        adjusted = self.adjusted if self.decided is None else self.decided.adjusted
        by_holm = None if adjusted is None else adjusted.rejected[self.pair.label]
        if self.decided is not None:
            shown = self.decided.result.rejected
        else:
            days = [{item.run.day for one in side for item in one.runs} for side in (self.pair.a, self.pair.b)]
            shown = None if days[0] != days[1] and all(len(each) == 1 for each in days) else self.result.savings_shown
        return shown if by_holm is None or shown is None else shown and by_holm


def as_each(compared: Sequence[Compared], settings: AnalysisSettings) -> bool:
    """Whether comparisons of all levels are those planned level by level, as each group has one treated level."""
    pooled = [item.pair for item in compared if item.pair.family == pairing.POOLED]
    return settings.family is Family.EACH and bool(pooled) and all(len(pair.b) == 1 for pair in pooled)


def compare_all(
    cache: ResultCache,
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    swept: str,
    settings: AnalysisSettings,
    scope: Mapping[str, Any],
    beside: Mapping[Outcome, Sequence[ConditionValues]],
) -> list[Compared]:
    """Ensure every comparison of the study, outcome by outcome.

    `beside` are conditions that the selection leaves out whole: their comparisons count in Holm's p.
    """
    found: list[Compared] = []
    for outcome, several in conditions.items():
        found += _with_control(cache, several, beside.get(outcome, ()), outcome, swept, settings, scope)
    return found


def _with_control(
    cache: ResultCache,
    conditions: Sequence[ConditionValues],
    beside: Sequence[ConditionValues],
    quantity: Outcome,
    swept: str,
    settings: AnalysisSettings,
    scope: Mapping[str, Any],
) -> list[Compared]:
    """Compare treatments with controls, by day too, and adjust the p of the family that was decided on.

    A family of one test is left as it is.
    """
    pairs = pairing.pairs_with_control(conditions, swept)
    found = _tested(cache, pairs, quantity, settings, scope)
    by_day = compare_by_day(cache, pairs, quantity, scope, settings.alpha)
    family, unit = FAMILY_OF[settings.family], settings.unit_of_analysis
    of_unit = unit_scope(scope, unit)
    further = [pair for pair in _unselected_pairs(pairs, conditions, beside, swept) if pair.family == family]
    units, one_sided = pairs_in_units(cache, further, quantity, unit, scope), welch_one_sided(settings)
    tested = compare(cache, units, quantity, of_unit, settings.alpha, one_sided=one_sided)
    members = [
        *((item.pair, item.result) for item in found if item.pair.family == family),
        *zip(further, tested, strict=True),
    ]
    adjusted = adjust(cache, members, family, quantity, of_unit, settings.alpha) if len(members) > 1 else None
    found = [
        replace(item, by_day=beside, adjusted=adjusted if item.pair.family == family else None)
        for item, beside in zip(found, by_day, strict=True)
    ]
    return _with_decided_family(cache, found, further, quantity, family, settings, scope)


def _with_decided_family(
    cache: ResultCache,
    found: list[Compared],
    further: Sequence[Pair],
    quantity: Outcome,
    family: str,
    settings: AnalysisSettings,
    scope: Mapping[str, Any],
) -> list[Compared]:
    """Adjust the p of the deciding tests of a family; those of `further` pairs, which are not shown, count too."""
    own = [(item.pair, item.decided.result) for item in found if item.decided and item.pair.family == family]
    if not own:
        return found
    decisions = decide(cache, further, quantity, scope, settings.alpha, one_sided=settings.one_sided)
    members = [*own, *zip(further, decisions, strict=True)]
    if len(members) == 1:
        return found
    tested = [Member(pair.label, result, result.t, result.p) for pair, result in members]
    adjusted = adjust_members(cache, tested, family, {"quantity": str(quantity), **scope}, settings.alpha)
    return [
        replace(item, decided=replace(item.decided, adjusted=adjusted))
        if item.decided and item.pair.family == family
        else item
        for item in found
    ]


def _tested(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, settings: AnalysisSettings, scope: Mapping[str, Any]
) -> list[Compared]:
    """Test pairs on units of analysis; heights for equality too, where bounds were given."""
    unit, alpha, bounds = settings.unit_of_analysis, settings.alpha, settings.apex_bounds
    units, of_unit = pairs_in_units(cache, pairs, quantity, unit, scope), unit_scope(scope, unit)
    results = compare(cache, units, quantity, of_unit, alpha, one_sided=welch_one_sided(settings))
    found = [Compared(pair, quantity, result) for pair, result in zip(pairs, results, strict=True)]
    if unit is UnitOfAnalysis.SHARED_DAYS:
        decisions = decide(cache, pairs, quantity, scope, alpha, one_sided=settings.one_sided)
        found = [replace(item, decided=Decided(result)) for item, result in zip(found, decisions, strict=True)]
    if not quantity.has_equivalence or bounds is None:
        return found
    tests = within_bounds(cache, units, bounds, alpha, of_unit)
    found = [replace(item, equivalent=test) for item, test in zip(found, tests, strict=True)]
    if unit is UnitOfAnalysis.SHARED_DAYS:
        tests = decide_equivalence(cache, pairs, bounds, alpha, scope)
        found = [
            replace(item, decided=replace(item.decided, equivalent=test))
            for item, test in zip(found, tests, strict=True)
            if item.decided
        ]
    return found
