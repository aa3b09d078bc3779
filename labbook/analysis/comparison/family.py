"""Holm's p-values over the family of comparisons that was decided on: how likely any false alarm among them is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import ComparisonResult, Pair
from labbook.analysis.results.codec import Algorithm, StoredAs, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, result_fingerprint
from reports.numbers import Number
from stats.exact.tails import t_two_sided
from stats.groups.multiple import holm


@dataclass(frozen=True, slots=True)
class FamilyResult(StoredResult):
    """Holm's p of the Welch test of every pair of a family by its label, and whether it is at most alpha.

    `rejected` is None where a pair has no p.
    """

    adjusted_p: Annotated[Mapping[str, Number], StoredAs("adjusted_p, {}")]
    rejected: Mapping[str, bool | None]


ALGORITHM = Algorithm("family", 7, FamilyResult)


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
            ALGORITHM,
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
        return Undefined("the test has no degrees of freedom")
    return t_two_sided(t.value, t.df).log10_p
