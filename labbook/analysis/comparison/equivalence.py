"""Whether apex heights are the same within bounds: two one-sided Welch tests on runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from data_schema.outcomes import Outcome
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
