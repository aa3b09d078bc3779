"""One quantity in one condition: mean, SD, SE and interval over runs, the runs being the unit of analysis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.queries.results import ResultRow
from data_schema.queries.runs import RunRow
from labbook.analysis.outcomes.run_energy import shared_error
from labbook.analysis.results.facts import condition_input
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    number,
    result_fingerprint,
)
from stats.compare.shared_error import SharedError, describe_shared, shared_of_mean

ALGORITHM = Algorithm("condition_summary", 14)


@dataclass(frozen=True, slots=True)
class RunNumber:
    """What one run contributes: its number, the error it shares with other runs, and the result it comes from."""

    run: RunRow
    value: float
    shared: SharedError
    result: ResultRow


@dataclass(frozen=True, slots=True)
class ConditionValues:
    """The runs of one condition, and what is stored about them."""

    key: str
    is_control: bool
    levels: Mapping[str, str]
    runs: tuple[RunNumber, ...]
    result: ResultRow

    @property
    def values(self) -> list[float]:
        """The runs' numbers."""
        return [item.value for item in self.runs]


def run_numbers(runs: Sequence[RunRow], results: Mapping[str, ResultRow], quantity: Outcome) -> list[RunNumber]:
    """Return the runs that have the quantity."""
    found = []
    for run in runs:
        row = results.get(run.uid)
        if row is None:
            continue
        item = number(row, quantity.number_name)
        if item.value is not None:
            shared = shared_error(row) if quantity.shares_error else SharedError()
            found.append(RunNumber(run, item.value, shared, row))
    return found


def condition_values(
    cache: ResultCache, numbers: Sequence[RunNumber], quantity: Outcome, scope: Mapping[str, Any]
) -> list[ConditionValues]:
    """Ensure the summary of every condition that occurs among the runs, in order of first occurrence."""
    by_condition: dict[str, list[RunNumber]] = {}
    for item in numbers:
        by_condition.setdefault(item.run.condition_key, []).append(item)
    requests = [
        Request(
            ALGORITHM,
            {"quantity": str(quantity), "condition": key, **scope},
            (condition_input(items[0].run), *(result_fingerprint(item.run.name, item.result) for item in items)),
            {},
            lambda items=items: _outcome(items, quantity),  # type: ignore[misc]
        )
        for key, items in by_condition.items()
    ]
    rows = cache.ensure(requests)
    return [
        ConditionValues(key, items[0].run.is_control, items[0].run.levels, tuple(items), row)
        for (key, items), row in zip(by_condition.items(), rows, strict=True)
    ]


def _outcome(items: Sequence[RunNumber], quantity: Outcome) -> Computed:
    unit = quantity.unit
    mean = describe_shared([item.value for item in items], shared_of_mean([item.shared for item in items]))
    about = mean.scatter
    return Computed(
        (
            NewNumber(
                "mean",
                about.mean,
                unit,
                about.se,
                mean.shared_se if quantity.shares_error else None,
                mean.ci_low,
                mean.ci_high,
                mean.level,
                df=about.n - 1,
                n=about.n,
            ),
            NewNumber("sd", about.sd, unit, n=about.n),
        ),
        {"runs": [[item.run.name, item.value] for item in items]},
    )
