"""Whether a battery pack matters: the mean deviation of its runs from their conditions' means."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.queries.results import ResultRow
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    result_fingerprint,
)
from stats.compare.summary import describe

ALGORITHM = Algorithm("pack_deviation", 12)


def pack_deviations(
    cache: ResultCache, conditions: Sequence[ConditionValues], scope: dict[str, str]
) -> dict[str, ResultRow]:
    """Ensure the mean deviation of every pack, in joules a jump."""
    deviations: dict[str, list[tuple[RunNumber, float]]] = {}
    for condition in conditions:
        mean = sum(condition.values) / len(condition.values)
        for item in condition.runs:
            deviations.setdefault(item.run.battery, []).append((item, item.value - mean))
    packs = sorted(deviations)
    rows = cache.ensure(
        [
            Request(
                ALGORITHM,
                {"pack": pack, **scope},
                tuple(result_fingerprint("condition", condition.result) for condition in conditions),
                {"runs": [item.run.name for item, _deviation in deviations[pack]]},
                lambda values=[value for _item, value in deviations[pack]]: _outcome(values),  # type: ignore[misc]
            )
            for pack in packs
        ]
    )
    return dict(zip(packs, rows, strict=True))


def _outcome(values: Sequence[float]) -> Computed:
    about = describe(values)
    number = NewNumber(
        "deviation",
        about.mean,
        "J",
        about.se,
        ci_low=about.ci_low,
        ci_high=about.ci_high,
        ci_level=about.level,
        n=about.n,
    )
    return Computed((number,))
