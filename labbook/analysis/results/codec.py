"""Results as they are computed and read, frozen dataclasses, and as they are stored: numbers and a JSON payload.

A field that is a `Number` is stored as a number of the field's name (or of the name that `StoredAs` gives it), a
mapping of them as a number each; all other fields are the payload, but for those that have their default. Of a number
that does not exist the payload has the reason, too, as a code; of an error or an end of an interval that is not stored
the reason is not stored either.
"""

from __future__ import annotations

import hashlib
import json
import math
import typing
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, Field, dataclass, fields
from functools import cache
from typing import Any, Generic, TypeVar

import msgspec

from data_schema.errors import BookDamaged
from data_schema.journal import canonical
from data_schema.queries.results import NumberRow, ResultRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.numbers import Number, Origin, StoredAs, StoredResult

_UNDEFINED = "undefined"
"""Where the payload has, by the names of numbers that do not exist, the codes and parameters of their reasons."""


T = TypeVar("T", bound=StoredResult)


@dataclass(frozen=True, slots=True)
class Algorithm(Generic[T]):
    """A kind of result: raise `version` when its numbers change; a test watches the code that they depend on."""

    kind: str
    version: int
    result: type[T]


def encode(result: StoredResult, algorithm: Algorithm[Any], origin: Origin) -> ResultRow:
    """Return a result as it is stored."""
    kind: Any = type(result)
    named = list(_numbers(result))
    payload: dict[str, Any] = {
        one.name: _plain(value)
        for one in _payload_fields(kind)
        for value in [getattr(result, one.name)]
        if one.default is MISSING or value != one.default
    }
    if undefined := {name: _plain(number.value) for name, number in named if isinstance(number.value, Undefined)}:
        payload[_UNDEFINED] = undefined
    return ResultRow(
        uid=origin.uid,
        kind=algorithm.kind,
        scope_json=canonical(origin.scope),
        key=origin.key,
        algorithm=algorithm.kind,
        version=algorithm.version,
        payload_json=canonical(payload),
        stale=False,
        numbers=tuple(_number_row(origin.key, name, number) for name, number in named),
        inputs=origin.inputs,
    )


def decode(row: ResultRow, result: type[T]) -> T:
    """Return a stored result as what it was computed as; raises `BookDamaged` where it is not of that form."""
    try:
        return _decoded(row, result)
    except (AttributeError, KeyError, TypeError, ValueError, msgspec.ValidationError) as error:
        raise BookDamaged(
            f"result {row.uid} of the database is not as labbook stores a {row.kind} ({error}): run `labbook rebuild` "
            "to make the database anew from the raw copies and the journal."
        ) from error


def _decoded(row: ResultRow, result: type[T]) -> T:
    kind: Any = result
    payload: dict[str, Any] = json.loads(row.payload_json)
    undefined = payload.pop(_UNDEFINED, {})
    if undefined.keys() != {item.name for item in row.numbers if item.value is None}:
        raise ValueError(f"{row.kind} does not say by codes why numbers of it do not exist")
    numbers = {item.name: _number(item, undefined.get(item.name)) for item in row.numbers}
    values: dict[str, Any] = {}
    for one in _payload_fields(kind):
        if one.name in payload:
            values[one.name] = _read(payload.pop(one.name), _hints(kind)[one.name])
        elif one.default is MISSING:
            raise ValueError(f"{row.kind} has no {one.name}")
    for one, (head, tail) in _number_fields(kind).items():
        if tail is None:
            values[one.name] = numbers.pop(head, None)
            if values[one.name] is None and one.default is MISSING:
                raise ValueError(f"{row.kind} has no number {head}")
        else:
            found = [name for name in numbers if name.startswith(head) and name.endswith(tail)]
            values[one.name] = {name[len(head) : len(name) - len(tail)]: numbers.pop(name) for name in found}
    if payload or numbers:
        raise ValueError(f"{row.kind} has more than is known: {', '.join([*payload, *numbers])}")
    return result(**values, origin=Origin(row.key, json.loads(row.scope_json), row.inputs))


def _numbers(result: StoredResult) -> Iterator[tuple[str, Number]]:
    kind: Any = type(result)
    for one, (head, tail) in _number_fields(kind).items():
        value = getattr(result, one.name)
        if tail is not None:
            yield from ((f"{head}{key}{tail}", number) for key, number in value.items())
        elif value is not None:
            yield head, value


def _number_row(key: str, name: str, number: Number) -> NumberRow:
    return NumberRow(
        uid=hashlib.sha256(f"{key}\n{name}".encode()).hexdigest()[:12],
        name=name,
        value=_defined(number.value),
        unit=number.unit,
        se=_defined(number.se),
        shared_se=_defined(number.shared_se),
        ci_low=_defined(number.ci_low),
        ci_high=_defined(number.ci_high),
        ci_level=None if number.ci_low is None else number.ci_level,
        df=_defined(number.df),
        n=number.n,
        undefined_reason=number.value.reason if isinstance(number.value, Undefined) else None,
    )


def _defined(value: float | Undefined | None) -> float | None:
    if value is None or isinstance(value, Undefined):
        return None
    if not math.isfinite(value):
        raise ValueError(f"{value} is no number that can be stored: `Undefined` says why one does not exist")
    return float(value)


def _decoded_reason(stored: Any) -> Undefined:
    if not isinstance(stored, dict) or stored.get("code") not in Reason.__members__:
        raise ValueError(f"{stored} is no code of Reason")
    return Undefined(Reason[stored["code"]], **stored["parameters"])


def _number(row: NumberRow, why: Mapping[str, Any] | None) -> Number:
    """Return a stored number; where it does not exist, its interval does not either."""
    undefined = None if why is None else _decoded_reason(why)
    value = row.value if undefined is None else undefined
    assert value is not None  # noqa: S101 - what has no value has a reason: `decode` has looked
    return Number(
        value=value,
        unit=row.unit,
        se=row.se,
        shared_se=row.shared_se,
        ci_low=row.ci_low if undefined is None else undefined,
        ci_high=row.ci_high if undefined is None else undefined,
        ci_level=row.ci_level or 0.95,
        df=row.df,
        n=row.n,
        provenance=row.uid,
    )


def _plain(value: Any) -> Any:
    """Return a value of the payload as JSON has it."""
    if isinstance(value, Undefined):
        return {"code": value.code.name, "parameters": dict(value.parameters)}
    return msgspec.to_builtins(value)


def _read(value: Any, hint: Any) -> Any:
    """Return a value from JSON as a field's annotation has it; raises ValueError or `msgspec.ValidationError`."""
    if Undefined in typing.get_args(hint):
        return None if value is None else _decoded_reason(value)
    return msgspec.convert(value, hint)


@cache
def _hints(kind: Any) -> dict[str, Any]:
    return typing.get_type_hints(kind)


@cache
def _number_fields(kind: Any) -> dict[Field[Any], tuple[str, str | None]]:
    """Return the fields that are numbers, each with its name in the store: the whole, or head and tail of several.

    Names of several that say more come first, so that none is taken for a shorter one.
    """
    found: dict[Field[Any], tuple[str, str | None]] = {}
    for one in fields(kind):
        hint = _hints(kind)[one.name]
        if Number in (hint, *typing.get_args(hint)):
            marks = getattr(typing.get_type_hints(kind, include_extras=True)[one.name], "__metadata__", ())
            named = next((mark.name for mark in marks if isinstance(mark, StoredAs)), one.name)
            head, several, tail = named.partition("{}")
            found[one] = (head, tail if several else None)
    return dict(sorted(found.items(), key=lambda item: (item[1][1] is not None, -len("".join(filter(None, item[1]))))))


@cache
def _payload_fields(kind: Any) -> tuple[Field[Any], ...]:
    return tuple(one for one in fields(kind) if one not in _number_fields(kind) and one.name != "origin")
