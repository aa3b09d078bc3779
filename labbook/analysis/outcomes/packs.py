"""Whether a battery pack matters: the mean deviation of its runs from their conditions' means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, result_fingerprint
from reports.numbers import Number
from stats.compare.summary import describe


@dataclass(frozen=True, slots=True)
class PackDeviation(StoredResult):
    """Mean deviation of a pack's runs from the means of their conditions."""

    deviation: Number


ALGORITHM = Algorithm("pack_deviation", 12, PackDeviation)


def pack_deviations(
    cache: ResultCache, conditions: Sequence[ConditionValues], scope: dict[str, str]
) -> dict[str, PackDeviation]:
    """Ensure the mean deviation of every pack, in joules a jump."""
    deviations: dict[str, list[tuple[RunNumber, float]]] = {}
    for condition in conditions:
        mean = sum(condition.values) / len(condition.values)
        for item in condition.runs:
            deviations.setdefault(item.run.battery, []).append((item, item.value - mean))
    packs = sorted(deviations)
    results = cache.ensure(
        [
            Request(
                ALGORITHM,
                {"pack": pack, **scope},
                tuple(result_fingerprint("condition", condition.result) for condition in conditions),
                {"runs": [item.run.name for item, _value in deviations[pack]]},
                lambda values=[value for _item, value in deviations[pack]]: _deviation(values),  # type: ignore[misc]
            )
            for pack in packs
        ]
    )
    return dict(zip(packs, results, strict=True))


def _deviation(values: Sequence[float]) -> PackDeviation:
    about = describe(values)
    return PackDeviation(
        Number(about.mean, "J", about.se, ci_low=about.ci_low, ci_high=about.ci_high, ci_level=about.level, n=about.n)
    )
