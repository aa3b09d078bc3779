"""Every comparison of a study: by the thesis's route, and what stands beside it (by day, Holm, equivalence).

Holm's p counts comparisons of the planned family that a report does not show: without them a report on one foot would
have smaller adjusted p-values than the report on both from the same data.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.by_day import DayComparison, compare_by_day
from labbook.analysis.comparison.comparing import (
    ComparisonResult,
    Pair,
    compare,
    fingerprints_of_sides,
    pairs_in_units,
    values_of,
)
from labbook.analysis.outcomes.conditions import ConditionValues, condition_values, unit_scope
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.measuring import measure
from labbook.analysis.preregistration.planned import FAMILY_OF
from labbook.analysis.results.codec import Algorithm, StoredAs, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, ends_of, result_fingerprint
from labbook.analysis.study_data import StudyData
from labbook.config.model import AnalysisSettings, Bounds
from reports.numbers import Number
from stats.compare.equivalence import equivalence
from stats.exact.tails import t_two_sided
from stats.groups.multiple import holm


@dataclass(frozen=True, slots=True)
class FamilyResult(StoredResult):
    """Holm's p of the Welch test of every pair of a family by its label, and whether it is at most alpha.

    `rejected` is None where a pair has no p.
    """

    adjusted_p: Annotated[Mapping[str, Number], StoredAs("adjusted_p, {}")]
    rejected: Mapping[str, bool | None]


FAMILY = Algorithm("family", 7, FamilyResult)


def adjust(
    cache: ResultCache,
    tested: Sequence[tuple[Pair, ComparisonResult]],
    family: str,
    quantity: Outcome,
    scope: Mapping[str, Any],
    alpha: float = 0.05,
) -> FamilyResult:
    """Ensure the adjusted p of the Welch tests of a family."""
    return cache.ensure_one(
        Request(
            FAMILY,
            {"quantity": str(quantity), "family": family, **scope},
            tuple(result_fingerprint(pair.label, result) for pair, result in tested),
            {"alpha": alpha},
            lambda: _adjusted(tested, family, alpha),
        )
    )


def _adjusted(tested: Sequence[tuple[Pair, ComparisonResult]], family: str, alpha: float) -> FamilyResult:
    found = {pair.label: result.welch_p.value for pair, result in tested}
    logs = {pair.label: _log10_p(result) for pair, result in tested if found[pair.label] == 0.0}
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


def _log10_p(result: ComparisonResult) -> float | Undefined:
    """Return the logarithm of a p that is below all doubles, from the statistic that it belongs to."""
    t = result.welch_t
    if isinstance(t.value, Undefined):
        return t.value
    if not isinstance(t.df, float):
        return Undefined(Reason.TEST_WITHOUT_DF)
    return t_two_sided(t.value, t.df).log10_p


@dataclass(frozen=True, slots=True)
class EquivalenceResult(StoredResult):
    """Two one-sided tests against bounds, in m or in % of the control's mean (`percent`); `estimate` in their unit.

    `equivalent` says whether both are rejected; None where there is no test.
    """

    estimate: Number
    t_low: Number
    p_low: Number
    t_high: Number
    p_high: Number
    p: Number
    equivalent: bool | None
    low: float
    high: float
    percent: bool


EQUIVALENCE = Algorithm("equivalence", 9, EquivalenceResult)


def within_bounds(
    cache: ResultCache, pairs: Sequence[Pair], bounds: Bounds, alpha: float, scope: Mapping[str, Any]
) -> list[EquivalenceResult]:
    """Ensure the test of every pair of apex heights, in order; its interval has level 1 - 2 alpha."""
    return cache.ensure(
        [
            Request(
                EQUIVALENCE,
                {"quantity": str(Outcome.APEX), "family": pair.family, "label": pair.label, **scope},
                fingerprints_of_sides(pair),
                {"alpha": alpha, "bounds": asdict(bounds)},
                lambda pair=pair: _equivalence(pair, bounds, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def _equivalence(pair: Pair, bounds: Bounds, alpha: float) -> EquivalenceResult:
    found = equivalence(
        values_of(pair.b), values_of(pair.a), low=bounds.low, high=bounds.high,
        bounds="percent" if bounds.percent else "raw", alpha=alpha,
    )  # fmt: skip
    welch, n = found.welch, found.n_a + found.n_b
    low, high = ends_of(welch.estimate_ci)
    unit = "%" if bounds.percent else "m"
    return EquivalenceResult(
        estimate=Number(found.estimate, unit, ci_low=low, ci_high=high, ci_level=1.0 - 2.0 * alpha, n=n),
        t_low=Number(welch.t_low, "1", df=welch.df_low, n=n),
        p_low=Number(welch.p_low, "1", df=welch.df_low, n=n),
        t_high=Number(welch.t_high, "1", df=welch.df_high, n=n),
        p_high=Number(welch.p_high, "1", df=welch.df_high, n=n),
        p=Number(welch.p, "1", n=n),
        equivalent=None if isinstance(welch.equivalent, Undefined) else welch.equivalent,
        low=bounds.low,
        high=bounds.high,
        percent=bounds.percent,
    )


def unselected_conditions_of(
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


def unselected_pairs(
    pairs: Sequence[Pair], conditions: Sequence[ConditionValues], beside: Sequence[ConditionValues], swept: str
) -> list[Pair]:
    """Return the comparisons with the control that the conditions of all make, and those of the selection do not."""
    shown = {pair.label for pair in pairs}
    every = pairing.pairs_with_control([*conditions, *beside], swept) if beside else []
    return [pair for pair in every if pair.label not in shown]


@dataclass(frozen=True, slots=True)
class Compared:
    """A pair with its runs, the quantity compared, the stored comparison, and the results beside it.

    `by_day` and `equivalent` are there for comparisons with the control, the second for heights where bounds were
    stated; `adjusted` holds the p-values of the whole family that the pair belongs to, shown here or not.
    """

    pair: Pair
    quantity: Outcome
    result: ComparisonResult
    by_day: DayComparison | None = None
    adjusted: FamilyResult | None = None
    equivalent: EquivalenceResult | None = None

    @property
    def conditions(self) -> tuple[str, ...]:
        """The keys of the conditions compared."""
        return tuple(item.key for item in (*self.pair.a, *self.pair.b))


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
        if outcome.has_savings:
            further = [*pairing.pairs_across(several, swept), *pairing.pairs_between(several, swept)]
            found += _tested(cache, further, outcome, settings, scope)
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
    further = [pair for pair in unselected_pairs(pairs, conditions, beside, swept) if pair.family == family]
    tested = compare(cache, pairs_in_units(cache, further, quantity, unit, scope), quantity, of_unit, settings.alpha)
    members = [
        *((item.pair, item.result) for item in found if item.pair.family == family),
        *zip(further, tested, strict=True),
    ]
    adjusted = adjust(cache, members, family, quantity, of_unit, settings.alpha) if len(members) > 1 else None
    return [
        replace(item, by_day=beside, adjusted=adjusted if item.pair.family == family else None)
        for item, beside in zip(found, by_day, strict=True)
    ]


def _tested(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, settings: AnalysisSettings, scope: Mapping[str, Any]
) -> list[Compared]:
    """Test pairs on units of analysis; heights for equality too, where bounds were stated."""
    unit = settings.unit_of_analysis
    units, of_unit = pairs_in_units(cache, pairs, quantity, unit, scope), unit_scope(scope, unit)
    results = compare(cache, units, quantity, of_unit, settings.alpha)
    found = [Compared(pair, quantity, result) for pair, result in zip(pairs, results, strict=True)]
    if not quantity.has_equivalence or settings.apex_bounds is None:
        return found
    tests = within_bounds(cache, units, settings.apex_bounds, settings.alpha, of_unit)
    return [replace(item, equivalent=test) for item, test in zip(found, tests, strict=True)]
