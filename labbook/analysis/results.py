"""Results as they are computed: each with what it is about, what it came from, and ids for its numbers.

A result's key hashes its algorithm's name and version, its scope, its inputs and the settings that it depends on. Its
numbers are named after the key, so that a provenance id never means another number. Nothing is stored: a report writes
the results behind its numbers into its `numbers.json`.
"""

from __future__ import annotations

import hashlib
import math
import typing
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import Field, dataclass, field, fields, is_dataclass, replace
from functools import cache, lru_cache
from operator import attrgetter
from typing import Any, Generic, TypeVar

from data_schema.journal import canonical
from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.detections import DecisionRow
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow
from data_schema.queries.sources import InputRow
from data_schema.vocabulary import Undefined
from reports.numbers import Number, NumberNames, Origin, Result
from reports.results import Provenance, StudyResults

T = TypeVar("T", bound=Result)


@dataclass(frozen=True, slots=True)
class Algorithm:
    """A kind of result: raise `version` when its numbers change."""

    kind: str
    version: int


_of_input = attrgetter("role", "input_kind", "input_uid", "input_sha256")


def key_of(
    algorithm: Algorithm, scope: Mapping[str, Any], inputs: Iterable[InputRow], settings: Mapping[str, Any]
) -> str:
    """Return the name of the result of an algorithm about a scope, from sorted inputs, under settings, of no other."""
    rows = [_of_input(row) for row in inputs]
    return hashlib.sha256(canonical([algorithm.kind, algorithm.version, scope, rows, settings]).encode()).hexdigest()


@dataclass
class Results:
    """Results as they were computed; `made` has them by key, in their order. All are about a `scope`, too."""

    made: dict[str, Result] = field(default_factory=dict)
    scope: Mapping[str, Any] = field(default_factory=dict)

    def about(self, **scope: str) -> Results:
        """Return these results for further ones, which are all about this scope: a selection, a variant."""
        return Results(self.made, {**self.scope, **scope})

    def record(
        self,
        algorithm: Algorithm,
        scope: Mapping[str, Any],
        inputs: Iterable[InputRow],
        result: T,
        settings: Mapping[str, Any] = {},
    ) -> T:
        """Return a result with its origin, and with ids for its numbers."""
        rows, scope = sorted(inputs, key=_of_input), {**scope, **self.scope}
        key = key_of(algorithm, scope, rows, settings)
        changes: dict[str, Any] = {}
        for one, (head, tail) in _fields_of(result).items():
            value = getattr(result, one.name)
            if tail is not None:
                changes[one.name] = {
                    each: number.named(_number_id(key, f"{head}{each}{tail}")) for each, number in value.items()
                }
            elif value is not None:
                changes[one.name] = value.named(_number_id(key, head))
        origin = Origin(key, algorithm.kind, algorithm.version, scope, tuple(rows))
        recorded = replace(result, origin=origin, **changes)
        self.made[key] = recorded
        return recorded


def _number_id(key: str, name: str) -> str:
    return hashlib.sha256(f"{key}\n{name}".encode()).hexdigest()[:12]


def numbers_of(result: Result) -> Iterator[tuple[str, Number]]:
    """Give the numbers of a result by their names."""
    for one, (head, tail) in _fields_of(result).items():
        value = getattr(result, one.name)
        if tail is not None:
            yield from ((f"{head}{each}{tail}", number) for each, number in value.items())
        elif value is not None:
            yield head, value


def _fields_of(result: Result) -> Mapping[Field[Any], tuple[str, str | None]]:
    kind: Any = type(result)
    return _number_fields(kind)


@cache
def _number_fields(kind: Any) -> dict[Field[Any], tuple[str, str | None]]:
    """Return the fields that are numbers or a mapping of them, with their names: the whole, or head and tail.

    Those that are added to a result later belong to another one.
    """
    found: dict[Field[Any], tuple[str, str | None]] = {}
    hints = typing.get_type_hints(kind, include_extras=True)
    for one in fields(kind):
        hint = hints[one.name]
        marks = getattr(hint, "__metadata__", ())
        plain = typing.get_args(hint)[0] if marks else hint
        if Number in (plain, *typing.get_args(plain)):
            named = next((mark.template for mark in marks if isinstance(mark, NumberNames)), one.name)
            head, several, tail = named.partition("{}")
            found[one] = (head, tail if several else None)
    return found


def shown_numbers(study: StudyResults) -> Iterator[Number]:
    """Give every number with an id that a report shows; of what was recomputed the headlines."""
    of_headlines = [
        decision.headline
        for comparison, varied in study.headlines
        for decision in (comparison.decision, *(one.result for one in varied))
    ]
    budget = study.budget
    of_sources = [] if budget is None else [of[name] for name in budget.one_run for of in (budget.one_run, budget.mean)]
    beside: dict[str, object] = {"variations": of_headlines, "budget": of_sources}
    for one in fields(study):
        yield from _numbers_in(beside.get(one.name, getattr(study, one.name)))


_PLAIN = (str, int, float, type(None))


def _numbers_in(value: object) -> Iterator[Number]:
    """Give every number that was computed of a book, with its id, in a part of a study's results."""
    if isinstance(value, Number):
        if value.provenance:
            yield value
        return
    if isinstance(value, Mapping):
        parts: Iterable[object] = value.values()
    elif is_dataclass(value) and not isinstance(value, type):
        parts = [getattr(value, one.name) for one in fields(value) if one.name != "origin"]
    elif isinstance(value, list | tuple):
        parts = value
    else:
        return
    for part in parts:
        if not isinstance(part, _PLAIN):
            yield from _numbers_in(part)


def provenance(shown: Iterable[str], computed: Results) -> tuple[Provenance, ...]:
    """Say of each number by its id what it is and how many inputs its result has."""
    known = {number.provenance: (name, one) for one in computed.made.values() for name, number in numbers_of(one)}
    found = []
    for uid in shown:
        name, result = known[uid]
        found.append(Provenance(uid, f"{name.replace('_', ' ')}, {_scope(result)}", len(result.origin.inputs)))
    return tuple(found)


def _scope(result: Result) -> str:
    """Say what a result is about in a few words; the family of a comparison is in its label already."""
    return "; ".join(str(value) for name, value in result.origin.scope.items() if value != "" and name != "family")


def fingerprint(role: str, kind: str, uid: str, content: str) -> InputRow:
    """Name an input; `content` is whatever changes when the input changes."""
    return InputRow(role, kind, uid, _short_hash(content))


@lru_cache(maxsize=4096)  # many runs say the same: their day, their condition, their minutes and jumps
def _short_hash(content: str) -> str:
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def result_fingerprint(role: str, result: Result) -> InputRow:
    """Name another result as an input; its uid is a hash of all that it depends on."""
    return InputRow(role, "result", result.origin.uid, "")


def interval_ends(
    interval: tuple[float, float] | Undefined, times: float = 1.0
) -> tuple[float | Undefined, float | Undefined]:
    """Return both ends of an interval times a factor; each is the reason where there is no interval."""
    return (interval, interval) if isinstance(interval, Undefined) else (interval[0] * times, interval[1] * times)


def run_input(run: RunRow) -> InputRow:
    """Name a run and the facts about it that numbers depend on; whether it is void decides who uses its numbers."""
    content = canonical([run.kind, run.duration_s, run.jumps_made, run.condition_key, run.robot])
    return fingerprint("run", "run", run.uid, content)


def charge_input(charge: ChargeOfRun) -> InputRow:
    """Name a charge and what it says."""
    content = canonical([charge.charge_mah, charge.resolution_mah, charge.mode])
    return fingerprint("charge", "charge", charge.uid, content)


def idle_runs_input(robot_uid: str) -> InputRow:
    """Name the idle runs of a robot: a drain line depends on all of them."""
    return fingerprint("idle runs", "idle_runs", robot_uid, robot_uid)


def signal_input(signal: SignalRow, role: str) -> InputRow:
    """Name the samples of a signal; they are their own hash."""
    return InputRow(role, "signal", signal.sha256, signal.sha256)


def decision_input(decision: DecisionRow, method: str = "") -> InputRow:
    """Name a person's verdict, which never changes, and the method that measures what it speaks of."""
    return fingerprint("decision", "decision", decision.uid, f"{decision.uid}{method}")


def condition_input(run: RunRow) -> InputRow:
    """Name the condition of a run: what is stated of any of its runs may move what is computed of it."""
    return fingerprint("condition", "condition", run.condition_uid or "", run.condition_key)


T_co = TypeVar("T_co", bound=Result, covariant=True)


@dataclass(frozen=True, slots=True)
class RunResults(Generic[T_co]):
    """Results by run uid, and why other runs have none."""

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
