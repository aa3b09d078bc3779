"""Whether apex heights are equal within the bounds that were decided on: two one-sided tests on run means (TOST)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import Pair, fingerprints_of_sides, values_of
from labbook.analysis.results.result_cache import Algorithm, Computed, NewNumber, Request, ResultCache, ends_of
from labbook.config.model import Bounds
from stats.compare.equivalence import equivalence

ALGORITHM = Algorithm("equivalence", 9)


def within_bounds(
    cache: ResultCache, pairs: Sequence[Pair], bounds: Bounds, alpha: float, scope: Mapping[str, Any]
) -> list[ResultRow]:
    """Ensure the test of every pair of apex heights, in order; its interval has level 1 - 2 alpha."""
    return cache.ensure(
        [
            Request(
                ALGORITHM,
                {"quantity": str(Outcome.APEX), "family": pair.family, "label": pair.label, **scope},
                fingerprints_of_sides(pair),
                {"alpha": alpha, "bounds": asdict(bounds)},
                lambda pair=pair: _tested(pair, bounds, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def _tested(pair: Pair, bounds: Bounds, alpha: float) -> Computed:
    found = equivalence(
        values_of(pair.b), values_of(pair.a), low=bounds.low, high=bounds.high,
        bounds="percent" if bounds.percent else "raw", alpha=alpha,
    )  # fmt: skip
    welch, n = found.welch, found.n_a + found.n_b
    low, high = ends_of(welch.estimate_ci)
    unit = "%" if bounds.percent else "m"
    return Computed(
        (
            NewNumber("estimate", found.estimate, unit, ci_low=low, ci_high=high, ci_level=1.0 - 2.0 * alpha, n=n),
            NewNumber("t_low", welch.t_low, "1", df=welch.df_low, n=n),
            NewNumber("p_low", welch.p_low, "1", df=welch.df_low, n=n),
            NewNumber("t_high", welch.t_high, "1", df=welch.df_high, n=n),
            NewNumber("p_high", welch.p_high, "1", df=welch.df_high, n=n),
            NewNumber("p", welch.p, "1", n=n),
        ),
        {"equivalent": None if isinstance(welch.equivalent, Undefined) else welch.equivalent, **asdict(bounds)},
    )  # fmt: skip
