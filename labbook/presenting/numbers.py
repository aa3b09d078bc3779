"""Stored numbers as a report carries them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from data_schema.queries.results import ResultRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.content import Number, Provenance, SignificanceTest, Value
from reports.predicted import Prediction


@dataclass(frozen=True)
class ShownNumbers:
    """Collects the ids of stored numbers that a report shows, for its list of sources; `reword` rewords reasons."""

    ids: dict[str, None] = field(default_factory=dict)
    reword: Callable[[Undefined], Undefined] = lambda undefined: undefined

    def of_sides(self, sides: tuple[str, str], unit: str) -> ShownNumbers:
        """Return the same with both sides of a comparison, the treatment first, and its values called as given."""
        return replace(self, reword=lambda undefined: _of_sides(undefined, sides, unit))

    def number(self, number: Number) -> Number:
        """Return a number as it is shown."""
        self.ids[number.provenance] = None
        value, low, high = number.value, number.ci_low, number.ci_high
        if not isinstance(value, Undefined):
            return number
        return replace(number, value=self.reword(value), ci_low=self._end(low), ci_high=self._end(high))

    def value(self, number: Number) -> Value:
        """Return the bare value of a number."""
        return self.number(number).value

    def test(self, name: str, statistic: Number, p: Number, df: tuple[Value, ...] | None = None) -> SignificanceTest:
        """Return a test as statistic, degrees of freedom and p."""
        value = self._worded(statistic.value)
        own = statistic.df if statistic.df is not None else value if isinstance(value, Undefined) else _NO_DF
        return SignificanceTest(name, value, df or (own,), self._worded(p.value))

    def _worded(self, value: Value) -> Value:
        return self.reword(value) if isinstance(value, Undefined) else value

    def _end(self, end: Value | None) -> Value | None:
        return self.reword(end) if isinstance(end, Undefined) else end


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


_NO_DF = Undefined(Reason.NORMAL)
"""Degrees of freedom that are not stored: of a test against the normal distribution."""


def _of_sides(undefined: Undefined, sides: tuple[str, str], unit: str) -> Undefined:
    """Name both sides of a comparison, which sets its second group against its first, and the values compared."""
    first, second = sides
    names = {"group a": first, "group 'a'": first, "group b": second, "group 'b'": second}
    names |= {"group treated": first, "group control": second}  # of the savings
    return undefined.called(names, unit)


def _scope(row: ResultRow) -> str:
    """Say what a result is about in a few words; the family of a comparison is in its label already."""
    scope = json.loads(row.scope_json)
    return "; ".join(str(value) for name, value in scope.items() if value != "" and name != "family")
