"""The thesis's route to apex heights: t-tests over single jumps, as if a run's jumps were independent (5.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.outcomes.run_apexes import RunApexes
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, ends_of, result_fingerprint
from reports.numbers import Number
from stats.compare.two_sample import compare_two


@dataclass(frozen=True, slots=True)
class JumpComparison(StoredResult):
    """A comparison over single jumps, with the fields of `ComparisonResult` that it shares."""

    f: Number
    f_p: Number
    t: Number
    p: Number
    welch_t: Number
    welch_p: Number
    difference: Number
    welch_difference: Number
    test: str
    n_a: int
    n_b: int


ALGORITHM = Algorithm("jump_comparison", 12, JumpComparison)


def compare_jumps(
    cache: ResultCache, pairs: Sequence[Pair], scope: Mapping[str, Any], alpha: float = 0.05
) -> list[JumpComparison]:
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


def _compared(pair: Pair, alpha: float) -> JumpComparison:
    a, b = _heights_m(pair.a), _heights_m(pair.b)
    test = compare_two(b, a, "f_then_t", alpha)
    total = len(a) + len(b)

    def tested(value: float | Undefined, df: float | Undefined | None = None) -> Number:
        return Number(value, "1", df=df, n=total)

    def difference(interval: tuple[float, float] | Undefined, df: float | Undefined) -> Number:
        low, high = ends_of(interval)
        return Number(test.difference, "m", ci_low=low, ci_high=high, ci_level=1.0 - alpha, df=df, n=total)

    return JumpComparison(
        f=tested(test.f),
        f_p=tested(test.f_p),
        t=tested(test.t, test.df),
        p=tested(test.p, test.df),
        welch_t=tested(test.welch_t, test.welch_df),
        welch_p=tested(test.welch_p, test.welch_df),
        difference=difference(test.difference_ci, test.df),
        welch_difference=difference(test.welch_ci, test.welch_df),
        test=test.test,
        n_a=len(a),
        n_b=len(b),
    )


def _heights_m(side: Sequence[ConditionValues]) -> list[float]:
    results = [item.result for condition in side for item in condition.runs]
    return [height_m for result in results if isinstance(result, RunApexes) for height_m in result.heights_m]
