"""Every comparison of a study: by the thesis's route, and what stands beside it (by day, Holm, equivalence)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from data_schema.outcomes import Outcome
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparing import ComparisonResult, Pair, compare, pairs_in_units
from labbook.analysis.comparison.comparing_by_day import DayComparison, compare_by_day
from labbook.analysis.comparison.equivalent_heights import EquivalenceResult, within_bounds
from labbook.analysis.comparison.family import FamilyResult, adjust
from labbook.analysis.comparison.unselected_comparisons import unselected_pairs
from labbook.analysis.outcomes.conditions import ConditionValues, unit_scope
from labbook.analysis.preregistration.planned import FAMILY_OF
from labbook.analysis.results.result_cache import ResultCache
from labbook.config.model import AnalysisSettings


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
