"""The numbers of results as a report carries them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from data_schema.vocabulary import Undefined
from labbook.analysis.results import Results, numbers_of
from reports.content import Provenance
from reports.numbers import Number, Result, Value
from reports.predicted import Prediction

_PLAIN = (str, int, float, type(None))


def numbers_in(value: object) -> Iterator[Number]:
    """Give every number that was computed of a book, with its id, in a report's content or a part of it."""
    if isinstance(value, Number):
        if value.provenance:
            yield value
        return
    if isinstance(value, Mapping):
        parts: Iterable[object] = value.values()
    elif is_dataclass(value) and not isinstance(value, type):
        parts = [getattr(value, one.name) for one in fields(value)]
    elif isinstance(value, list | tuple):
        parts = value
    else:
        return
    for part in parts:
        if not isinstance(part, _PLAIN):
            yield from numbers_in(part)


def provenance(shown: Iterable[str], computed: Results) -> tuple[Provenance, ...]:
    """Say of each number by its id what it is and how many inputs its result has."""
    known = {number.provenance: (name, one) for one in computed.made.values() for name, number in numbers_of(one)}
    found = []
    for uid in shown:
        name, result = known[uid]
        found.append(Provenance(uid, f"{name.replace('_', ' ')}, {_scope(result)}", len(result.origin.inputs)))
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


def _scope(result: Result) -> str:
    """Say what a result is about in a few words; the family of a comparison is in its label already."""
    return "; ".join(str(value) for name, value in result.origin.scope.items() if value != "" and name != "family")
