"""Whether apex heights are the same within bounds: two one-sided Welch tests on runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import InputRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import Pair, fingerprints_of_sides, values_of
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, ends_of
from labbook.config.model import Bounds
from reports.numbers import Number
from stats.compare.equivalence import equivalence


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
    """Ensure the test of every pair of apex heights by Welch, in order; its interval has level 1 - 2 alpha."""
    return ensure_equivalence(cache, EQUIVALENCE, pairs, bounds, alpha, scope, fingerprints_of_sides, _equivalence)


def ensure_equivalence(
    cache: ResultCache,
    algorithm: Algorithm[EquivalenceResult],
    pairs: Sequence[Pair],
    bounds: Bounds,
    alpha: float,
    scope: Mapping[str, Any],
    inputs: Callable[[Pair], tuple[InputRow, ...]],
    test: Callable[[Pair, Bounds, float], EquivalenceResult],
) -> list[EquivalenceResult]:
    """Ensure a test of every pair of apex heights against the bounds, in order."""
    return cache.ensure(
        [
            Request(
                algorithm,
                {"quantity": str(Outcome.APEX), "family": pair.family, "label": pair.label, **scope},
                inputs(pair),
                {"alpha": alpha, "bounds": asdict(bounds)},
                lambda pair=pair: test(pair, bounds, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def one_sided(t: float | Undefined, p: float | Undefined, df: float | Undefined, n: int) -> tuple[Number, Number]:
    """Return the statistic and the p of a one-sided test."""
    return Number(t, "1", df=df, n=n), Number(p, "1", df=df, n=n)


def _equivalence(pair: Pair, bounds: Bounds, alpha: float) -> EquivalenceResult:
    found = equivalence(
        values_of(pair.b), values_of(pair.a), low=bounds.low, high=bounds.high,
        bounds="percent" if bounds.percent else "raw", alpha=alpha,
    )  # fmt: skip
    welch, n = found.welch, found.n_a + found.n_b
    return EquivalenceResult(
        estimate_within(found.estimate, welch.estimate_ci, bounds, alpha, n),
        *one_sided(welch.t_low, welch.p_low, welch.df_low, n),
        *one_sided(welch.t_high, welch.p_high, welch.df_high, n),
        Number(welch.p, "1", n=n),
        None if isinstance(welch.equivalent, Undefined) else welch.equivalent,
        bounds.low,
        bounds.high,
        bounds.percent,
    )


def estimate_within(
    value: float | Undefined, ci: tuple[float, float] | Undefined, bounds: Bounds, alpha: float, n: int
) -> Number:
    """Return an estimate in the unit of the bounds, with its interval of level 1 - 2 alpha."""
    low, high = ends_of(ci)
    return Number(value, "%" if bounds.percent else "m", ci_low=low, ci_high=high, ci_level=1.0 - 2.0 * alpha, n=n)
