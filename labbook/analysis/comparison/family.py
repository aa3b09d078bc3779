"""Holm's p-values over the family of comparisons that was decided on: how likely any false alarm among them is."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import Pair
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    number,
    result_fingerprint,
)
from stats.exact.tails import t_two_sided
from stats.groups.multiple import holm

ALGORITHM = Algorithm("family", 7)


def adjust(
    cache: ResultCache,
    tested: Sequence[tuple[Pair, ResultRow]],
    family: str,
    quantity: Outcome,
    scope: Mapping[str, Any],
    alpha: float = 0.05,
) -> ResultRow:
    """Ensure the adjusted p of the Welch tests of a family: one number a pair, named by `adjusted`.

    The payload says which are at most alpha: `rejected`.
    """
    return cache.ensure_one(
        Request(
            ALGORITHM,
            {"quantity": str(quantity), "family": family, **scope},
            tuple(result_fingerprint(pair.label, row) for pair, row in tested),
            {"alpha": alpha},
            lambda: _adjusted(tested, family, alpha),
        )
    )


def adjusted(label: str) -> str:
    """Name the adjusted p of a pair."""
    return f"adjusted_p, {label}"


def rejected(row: ResultRow, label: str) -> bool | None:
    """Tell whether the adjusted p of a pair is at most alpha; None where it has none."""
    found: bool | None = json.loads(row.payload_json)["rejected"][label]
    return found


def members(row: ResultRow) -> list[str]:
    """Return the labels of the pairs that a family holds."""
    return list(json.loads(row.payload_json)["rejected"])


def _adjusted(tested: Sequence[tuple[Pair, ResultRow]], family: str, alpha: float) -> Computed:
    found = {pair.label: _p(row) for pair, row in tested}
    logs = {pair.label: _log10_p(row) for pair, row in tested if found[pair.label] == 0.0}
    result = holm(found, family, log10_p=logs, alpha=alpha)
    return Computed(
        tuple(
            NewNumber(adjusted(label), p, "1", n=len(found))
            for label, p in zip(result.names, result.adjusted_p, strict=True)
        ),
        {
            "rejected": {
                label: None if isinstance(verdict, Undefined) else verdict
                for label, verdict in zip(result.names, result.rejected, strict=True)
            }
        },
    )


def _p(row: ResultRow) -> float | Undefined:
    item = number(row, "welch_p")
    return Undefined(item.undefined_reason or "") if item.value is None else item.value


def _log10_p(row: ResultRow) -> float | Undefined:
    """Return the logarithm of a p that is below all doubles, from the statistic that it belongs to."""
    item = number(row, "welch_t")
    if item.value is None or item.df is None:
        return Undefined(item.undefined_reason or "the test has no degrees of freedom")
    return t_two_sided(item.value, item.df).log10_p
