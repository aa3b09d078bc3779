"""Holm's adjusted p of a family of comparisons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import ComparisonResult, Pair
from labbook.analysis.comparison.deciding import DecisionResult
from labbook.analysis.results.codec import Algorithm, StoredAs, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, result_fingerprint
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
class _Member:
    """The result of a pair by its label, with the test in it that counts."""

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
    members = [_Member(pair.label, result, result.welch_t, result.welch_p) for pair, result in tested]
    return _ensure(cache, FAMILY, members, family, {"quantity": str(quantity), "family": family, **scope}, alpha)


def adjust_decisions(
    cache: ResultCache,
    tested: Sequence[tuple[Pair, DecisionResult]],
    family: str,
    quantity: Outcome,
    scope: Mapping[str, Any],
    alpha: float = 0.05,
) -> FamilyResult:
    """Ensure the adjusted p of the deciding tests of a family."""
    members = [_Member(pair.label, result, result.t, result.p) for pair, result in tested]
    of = {"quantity": str(quantity), "family": family, **scope}
    return _ensure(cache, DECISION_FAMILY, members, family, of, alpha)


def _ensure(
    cache: ResultCache,
    algorithm: Algorithm[FamilyResult],
    members: Sequence[_Member],
    family: str,
    scope: Mapping[str, Any],
    alpha: float,
) -> FamilyResult:
    return cache.ensure_one(
        Request(
            algorithm,
            scope,
            tuple(result_fingerprint(one.label, one.result) for one in members),
            {"alpha": alpha},
            lambda: _adjusted(members, family, alpha),
        )
    )


def _adjusted(tested: Sequence[_Member], family: str, alpha: float) -> FamilyResult:
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
