"""Stored numbers as a report carries them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from data_schema.queries.results import ResultRow
from data_schema.vocabulary import Undefined
from reports.content import Number, Provenance, Value
from reports.predicted import Prediction


@dataclass(frozen=True)
class ShownNumbers:
    """Collects the ids of stored numbers that a report shows, for its list of sources."""

    ids: dict[str, None] = field(default_factory=dict)

    def number(self, number: Number) -> Number:
        """Return a number as it is shown."""
        self.ids[number.provenance] = None
        return number

    def value(self, number: Number) -> Value:
        """Return the bare value of a number."""
        return self.number(number).value

    def all(self, numbers: Iterable[Number | None]) -> None:
        """Take numbers, those that there are, for shown."""
        self.ids.update({number.provenance: None for number in numbers if number is not None})


def provenance(shown: Iterable[str], results: Iterable[ResultRow]) -> tuple[Provenance, ...]:
    """Say of each number by its id what it is and how many inputs its result has."""
    known = {number.uid: (number.name, row) for row in results for number in row.numbers}
    found = []
    for uid in shown:
        name, row = known[uid]
        found.append(Provenance(uid, f"{name.replace('_', ' ')}, {_scope(row)}", len(row.inputs)))
    return tuple(found)


def number_data(number: Number) -> dict[str, Any]:
    """Return a number for JSON, unrounded and in its stored unit."""
    found = {"value": value_data(number.value), "se": value_data(number.se)}
    if number.ci_low is not None:
        ends = {"ci_low": value_data(number.ci_low), "ci_high": value_data(number.ci_high)}
        found |= {**ends, "ci_level": number.ci_level}
    if isinstance(number.value, Undefined):
        found["undefined"] = number.value.reason
    return found


def value_data(value: Value | tuple[float, float] | None) -> Any:
    """Return a value or an interval for JSON, None where it is undefined."""
    return None if isinstance(value, Undefined) else value


def published_data(item: Prediction | None) -> dict[str, Any] | None:
    """Return for JSON what the thesis has of a condition, None where it has nothing."""
    found = None if item is None else item.published
    if found is None:
        return None
    return {name: getattr(found, name) for name in ("id", "where", "published", "unit", "relation")}


def _scope(row: ResultRow) -> str:
    """Say what a result is about in a few words; the family of a comparison is in its label already."""
    scope = json.loads(row.scope_json)
    return "; ".join(str(value) for name, value in scope.items() if value != "" and name != "family")
