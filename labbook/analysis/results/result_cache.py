"""Results by key: what was computed from the same inputs by the same algorithm is not computed again.

A result's key hashes the algorithm's name and version, its scope, its inputs and its slice of the configuration. Its
numbers are named after the key, so a provenance id never means another number; a newer version of an algorithm gives
other ids, and reports keep what they printed under the old ones. Computing needs no lock; what is new is written
afterwards in one short transaction.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import sqlalchemy as sa

from data_schema.journal import canonical
from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.detections import DecisionRow
from data_schema.queries.results import (
    InputRow,
    ResultRow,
    add_results,
    mark_current,
    results_by_key,
)
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow
from data_schema.vocabulary import Undefined
from labbook.analysis.results.codec import Algorithm, T, decode, encode
from reports.numbers import Origin, StoredResult


@dataclass(frozen=True, slots=True)
class Request(Generic[T]):
    """A result that is wanted: for what (`scope`), from what (`inputs`), under which settings, and how to get it."""

    algorithm: Algorithm[T]
    scope: Mapping[str, Any]
    inputs: tuple[InputRow, ...]
    settings: Mapping[str, Any]
    compute: Callable[[], T]

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

    def ensure(self, requests: Sequence[Request[T]]) -> list[T]:
        """Return the wanted results in order."""
        keys = [request.key for request in requests]
        unknown = [key for key in keys if key not in self.computed and key not in self.reused]
        self.reused |= results_by_key(self.connection, unknown)
        return [self._result(key, request) for key, request in zip(keys, requests, strict=True)]

    def ensure_one(self, request: Request[T]) -> T:
        """Return one wanted result."""
        return self.ensure([request])[0]

    def _result(self, key: str, request: Request[T]) -> T:
        kind = request.algorithm.result
        if key in self.reused:
            return decode(self.reused[key], kind)
        if key not in self.computed:
            inputs = sorted(request.inputs, key=lambda row: (row.role, row.input_kind, row.input_uid))
            origin = Origin(key, request.scope, tuple(inputs))
            self.computed[key] = encode(request.compute(), request.algorithm, origin)
        return decode(self.computed[key], kind)


def keep(connection: sa.Connection, cache: ResultCache) -> int:
    """Store what a cache computed, in a writing transaction; returns how many results are new."""
    stored = results_by_key(connection, list(cache.computed))
    add_results(connection, [row for key, row in cache.computed.items() if key not in stored])
    mark_current(connection, [row for row in (cache.reused | stored).values() if row.stale])
    return len(cache.computed) - len(stored)


def fingerprint(role: str, kind: str, uid: str, content: str) -> InputRow:
    """Name an input; `content` is whatever changes when the input changes."""
    return InputRow(role, kind, uid, hashlib.sha256(content.encode()).hexdigest())


def result_fingerprint(role: str, result: StoredResult) -> InputRow:
    """Name another result as an input."""
    return InputRow(role, "result", result.origin.uid, result.origin.key)


def interval_ends(
    interval: tuple[float, float] | Undefined, times: float = 1.0
) -> tuple[float | Undefined, float | Undefined]:
    """Return both ends of an interval times a factor; each is the reason where there is no interval."""
    return (interval, interval) if isinstance(interval, Undefined) else (interval[0] * times, interval[1] * times)


def run_input(run: RunRow) -> InputRow:
    """Name a run and the facts about it that numbers depend on; whether it is void decides who uses its numbers."""
    return fingerprint(
        "run",
        "run",
        run.uid,
        canonical([run.kind, run.duration_s, run.jumps_made, run.condition_key, run.robot]),
    )


def charge_input(charge: ChargeOfRun) -> InputRow:
    """Name a charge and what it says."""
    return fingerprint(
        "charge", "charge", charge.uid, canonical([charge.charge_mah, charge.resolution_mah, charge.mode])
    )


def idle_runs_input(robot_uid: str) -> InputRow:
    """Name the idle runs of a robot: a drain line depends on all of them, so one more makes it stale."""
    return fingerprint("idle runs", "idle_runs", robot_uid, robot_uid)


def signal_input(signal: SignalRow, role: str) -> InputRow:
    """Name the samples of a signal; they are their own hash."""
    return InputRow(role, "signal", signal.sha256, signal.sha256)


def decision_input(decision: DecisionRow) -> InputRow:
    """Name a person's verdict; it never changes."""
    return fingerprint("decision", "decision", decision.uid, decision.uid)


def condition_input(run: RunRow) -> InputRow:
    """Name the condition of a run: a summary depends on it, so one more run makes it stale."""
    return fingerprint("condition", "condition", run.condition_uid or "", run.condition_key)


T_co = TypeVar("T_co", bound=StoredResult, covariant=True)


@dataclass(frozen=True, slots=True)
class RunResults(Generic[T_co]):
    """Stored results by run uid, and why other runs have none."""

    results: Mapping[str, T_co]
    missing: Mapping[str, Undefined]


SAME = 1e-9
"""Values that differ by less than this part are the same: another machine may add in another order."""


def equals_printed(printed: float | None, value: float | None, se: float | None = None) -> bool:
    """Tell whether a value equals the one that was printed.

    Where its standard error is known, so much of that is the same, too: a difference that cancels to 1e-16 has no
    digits of its own.
    """
    if printed is None or value is None:
        return printed is value
    return math.isclose(printed, value, rel_tol=SAME, abs_tol=SAME * (se or 0.0))
