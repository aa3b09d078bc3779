"""Results by key: what was computed from the same inputs by the same algorithm is not computed again.

A result's key hashes the algorithm's name and version, its scope, its inputs and its slice of the configuration. Its
numbers are named after the key, so a provenance id never means another number; a newer version of an algorithm gives
other ids, and reports keep what they printed under the old ones. Computing needs no lock; what is new is written
afterwards in one short transaction.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sqlalchemy as sa

from data_schema.journal import canonical
from data_schema.queries.results import InputRow, NumberRow, ResultRow, add_results, renew, results_by_key
from data_schema.vocabulary import Undefined


@dataclass(frozen=True, slots=True)
class Algorithm:
    """A kind of result: raise `version` when the numbers it gives change; a test watches all that they rest on."""

    kind: str
    version: int


@dataclass(frozen=True, slots=True)
class NewNumber:
    """A number as it was computed; `value` may be undefined with a reason, everything else absent."""

    name: str
    value: float | Undefined
    unit: str
    se: float | Undefined | None = None
    shared_se: float | None = None
    ci_low: float | Undefined | None = None
    ci_high: float | Undefined | None = None
    ci_level: float | None = None
    df: float | Undefined | None = None
    n: int | None = None


@dataclass(frozen=True, slots=True)
class Computed:
    """What computing gave: the numbers, and whatever else a page needs, as plain JSON."""

    numbers: tuple[NewNumber, ...]
    payload: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Request:
    """A result that is wanted: for what (`scope`), from what (`inputs`), under which settings, and how to get it."""

    algorithm: Algorithm
    scope: Mapping[str, Any]
    inputs: tuple[InputRow, ...]
    settings: Mapping[str, Any]
    compute: Callable[[], Computed]

    @property
    def key(self) -> str:
        """The name of this result, and of no other."""
        parts = [
            self.algorithm.kind,
            self.algorithm.version,
            self.scope,
            sorted([row.role, row.input_kind, row.input_uid, row.input_sha256] for row in self.inputs),
            self.settings,
        ]
        return hashlib.sha256(canonical(parts).encode()).hexdigest()


@dataclass
class ResultCache:
    """Gives results, computing only those that are not stored."""

    connection: sa.Connection
    computed: dict[str, ResultRow] = field(default_factory=dict)
    reused: dict[str, ResultRow] = field(default_factory=dict)

    def ensure(self, requests: Sequence[Request]) -> list[ResultRow]:
        """Return the wanted results in order."""
        keys = [request.key for request in requests]
        unknown = [key for key in keys if key not in self.computed and key not in self.reused]
        self.reused |= results_by_key(self.connection, unknown)
        for key, request in zip(keys, requests, strict=True):
            if key not in self.reused and key not in self.computed:
                self.computed[key] = _row(key, request, request.compute())
        return [self.reused.get(key) or self.computed[key] for key in keys]

    def ensure_one(self, request: Request) -> ResultRow:
        """Return one wanted result."""
        return self.ensure([request])[0]


def keep(connection: sa.Connection, cache: ResultCache) -> int:
    """Store what a workbench computed, in a writing transaction; returns how many results are new."""
    stored = results_by_key(connection, list(cache.computed))
    add_results(connection, [row for key, row in cache.computed.items() if key not in stored])
    renew(connection, [row for row in (cache.reused | stored).values() if row.stale])
    return len(cache.computed) - len(stored)


def fingerprint(role: str, kind: str, uid: str, content: str) -> InputRow:
    """Name an input; `content` is whatever changes when the input changes."""
    return InputRow(role, kind, uid, hashlib.sha256(content.encode()).hexdigest())


def result_fingerprint(role: str, row: ResultRow) -> InputRow:
    """Name another result as an input."""
    return InputRow(role, "result", row.uid, row.key)


def ends_of(interval: tuple[float, float] | Undefined) -> tuple[float | Undefined, float | Undefined]:
    """Return both ends of an interval as a number's; each is the reason where there is none."""
    return (interval, interval) if isinstance(interval, Undefined) else interval


def number(row: ResultRow, name: str) -> NumberRow:
    """Return one number of a result."""
    return next(item for item in row.numbers if item.name == name)


def _row(key: str, request: Request, outcome: Computed) -> ResultRow:
    return ResultRow(
        uid=key[:16],
        kind=request.algorithm.kind,
        scope_json=canonical(request.scope),
        key=key,
        algorithm=request.algorithm.kind,
        version=request.algorithm.version,
        payload_json=canonical(outcome.payload),
        stale=False,
        numbers=tuple(_number_row(key, item) for item in outcome.numbers),
        inputs=tuple(sorted(request.inputs, key=lambda row: (row.role, row.input_kind, row.input_uid))),
    )


def _number_row(key: str, item: NewNumber) -> NumberRow:
    undefined = item.value.reason if isinstance(item.value, Undefined) else None
    return NumberRow(
        uid=hashlib.sha256(f"{key}\n{item.name}".encode()).hexdigest()[:12],
        name=item.name,
        value=_plain(item.value),
        unit=item.unit,
        se=_plain(item.se),
        shared_se=item.shared_se,
        ci_low=_plain(item.ci_low),
        ci_high=_plain(item.ci_high),
        ci_level=item.ci_level,
        df=_plain(item.df),
        n=item.n,
        undefined_reason=undefined,
    )


def _plain(value: float | Undefined | None) -> float | None:
    return None if value is None or isinstance(value, Undefined) else float(value)
