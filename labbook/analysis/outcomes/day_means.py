"""Means of a day's runs, where the day and not the run was decided to be the unit of analysis."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import ResultRow
from labbook.analysis.comparison.comparing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    fingerprint,
    result_fingerprint,
)
from labbook.config.model import UnitOfAnalysis
from stats.compare.shared_error import shared_of_mean

ALGORITHM = Algorithm("day_means", 6)

_Days = Mapping[str, Sequence[RunNumber]]


def pairs_in_units(
    cache: ResultCache, pairs: Sequence[Pair], quantity: Outcome, unit: UnitOfAnalysis, scope: Mapping[str, Any]
) -> list[Pair]:
    """Return the pairs with one number a unit of analysis: as they are, or a mean of each day's runs on each side.

    Where levels are pooled, a day's runs of all of them make one mean: they have the day in common.
    """
    if unit is UnitOfAnalysis.RUN:
        return list(pairs)
    sides = by_day(cache, [side for pair in pairs for side in (pair.a, pair.b)], quantity, scope)
    both = zip(sides[::2], sides[1::2], strict=True)
    return [replace(pair, a=(a,), b=(b,)) for pair, (a, b) in zip(pairs, both, strict=True)]


def in_units(
    cache: ResultCache,
    conditions: Sequence[ConditionValues],
    quantity: Outcome,
    unit: UnitOfAnalysis,
    scope: Mapping[str, Any],
) -> list[ConditionValues]:
    """Return conditions with one number a unit of analysis."""
    if unit is UnitOfAnalysis.RUN:
        return list(conditions)
    return by_day(cache, [(condition,) for condition in conditions], quantity, scope)


def by_day(
    cache: ResultCache, sides: Sequence[Sequence[ConditionValues]], quantity: Outcome, scope: Mapping[str, Any]
) -> list[ConditionValues]:
    """Ensure the means of each side's runs by day, in order: one set of values a side, under its first condition."""
    days = [days_of(item for condition in side for item in condition.runs) for side in sides]
    rows = cache.ensure(
        [
            Request(
                ALGORITHM,
                {"quantity": str(quantity), "conditions": "; ".join(one.key for one in side), **scope},
                (
                    *(result_fingerprint(item.run.name, item.result) for one in side for item in one.runs),
                    *(fingerprint("day", "run", item.run.uid, item.run.day) for one in side for item in one.runs),
                ),
                {},
                lambda of_day=of_day: _means(of_day, quantity.unit),  # type: ignore[misc]
            )
            for side, of_day in zip(sides, days, strict=True)
        ]
    )
    return [
        replace(side[0], runs=tuple(_as_one(row, items) for items in of_day.values()), result=row)
        for side, of_day, row in zip(sides, days, rows, strict=True)
    ]


def unit_scope(scope: Mapping[str, Any], unit: UnitOfAnalysis) -> dict[str, Any]:
    """Return the scope of results on units of analysis; runs go without saying."""
    return dict(scope) if unit is UnitOfAnalysis.RUN else {**scope, "unit": str(unit)}


def days_of(items: Iterable[RunNumber]) -> dict[str, list[RunNumber]]:
    """Return runs by their day, in order of first occurrence."""
    found: dict[str, list[RunNumber]] = {}
    for item in items:
        found.setdefault(item.run.day, []).append(item)
    return found


def mean_of(items: Sequence[RunNumber]) -> float:
    """Return the mean of runs' numbers."""
    return math.fsum(item.value for item in items) / len(items)


def _means(days: _Days, unit: str) -> Computed:
    return Computed(
        tuple(NewNumber(f"mean of {day}", mean_of(items), unit, n=len(items)) for day, items in days.items())
    )


def _as_one(row: ResultRow, items: Sequence[RunNumber]) -> RunNumber:
    """Return a day's runs as one; its run is the day's first, which knows the day."""
    return RunNumber(items[0].run, mean_of(items), shared_of_mean([item.shared for item in items]), row)
