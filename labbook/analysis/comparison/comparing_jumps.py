"""The thesis's route to apex heights: t-tests over single jumps, as if a run's jumps were independent (5.2)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from data_schema.queries.results import ResultRow
from labbook.analysis.comparison.comparing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    ends_of,
    result_fingerprint,
)
from stats.compare.two_sample import compare_two

ALGORITHM = Algorithm("jump_comparison", 12)


def compare_jumps(
    cache: ResultCache, pairs: Sequence[Pair], scope: Mapping[str, Any], alpha: float = 0.05
) -> list[ResultRow]:
    """Ensure the comparison of every pair of apex heights over all their jumps, in order."""
    return cache.ensure(
        [
            Request(
                ALGORITHM,
                {"label": pair.label, **scope},
                tuple(
                    result_fingerprint(role, item.result)
                    for role, side in (("a", pair.a), ("b", pair.b))
                    for condition in side
                    for item in condition.runs
                ),
                {"alpha": alpha},
                lambda pair=pair: _compared(pair, alpha),  # type: ignore[misc]
            )
            for pair in pairs
        ]
    )


def _compared(pair: Pair, alpha: float) -> Computed:
    a, b = _heights_m(pair.a), _heights_m(pair.b)
    test = compare_two(b, a, "f_then_t", alpha)
    total = len(a) + len(b)
    differences = (
        ("difference", test.difference_ci, test.df),
        ("welch_difference", test.welch_ci, test.welch_df),
    )
    return Computed(
        (
            NewNumber("f", test.f, "1", n=total),
            NewNumber("f_p", test.f_p, "1", n=total),
            NewNumber("t", test.t, "1", df=test.df, n=total),
            NewNumber("p", test.p, "1", df=test.df, n=total),
            NewNumber("welch_t", test.welch_t, "1", df=test.welch_df, n=total),
            NewNumber("welch_p", test.welch_p, "1", df=test.welch_df, n=total),
            *(
                NewNumber(name, test.difference, "m", None, None, *ends_of(interval), 1.0 - alpha, df=df, n=total)
                for name, interval, df in differences
            ),
        ),
        {"test": test.test, "n_a": len(a), "n_b": len(b)},
    )


def _heights_m(side: Sequence[ConditionValues]) -> list[float]:
    return [
        height_m
        for condition in side
        for item in condition.runs
        for height_m in json.loads(item.result.payload_json)["heights_m"]
    ]
