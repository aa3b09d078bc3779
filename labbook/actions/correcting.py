"""`labbook correct`: which row is meant, which columns change, and to what."""

from __future__ import annotations

import datetime
import json
import math
import zoneinfo
from collections.abc import Mapping, Sequence
from enum import StrEnum
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.journal import canonical
from data_schema.queries.facts import FACTS, find_uid
from data_schema.queries.runs import RunRow, factors
from data_schema.tables.base import Real
from data_schema.vocabulary import Action, ChargeMode, FactorKind, RunKind, RunState, StudyKind
from labbook.book.desk import Desk, Statement
from labbook.book.naming import ensure_condition, ensure_day, named_uid, old_values, refuse_empty, run_named, study_of
from labbook.book.opening import Book

_NAMED = ("robot", "battery", "instrument", "factor")
_WORDS: Mapping[tuple[str, str], type[StrEnum]] = {
    ("run", "kind"): RunKind,
    ("study", "kind"): StudyKind,
    ("factor", "kind"): FactorKind,
    ("charge", "mode"): ChargeMode,
}
_FIXED = {"id", "uid", "study", "state", "planned_run", "condition", "file", "row_number", "factor", "label"}


def correct(book: Book, desk: Desk, target: str, assignments: Sequence[str], why: str) -> dict[str, tuple[Any, Any]]:
    """State corrections of one row; returns (old, new) by column. Results downstream are marked stale."""
    refuse_empty("--why", why)
    given = _assignments(assignments)
    kind, uid, run = _target(desk.connection, target)
    new: dict[str, Any] = {}
    levels = dict(run.levels) if run else {}
    for name, text in given.items():
        if run is not None and name in book.configuration.factors:
            levels[name] = text
        else:
            new |= _column(book, desk, kind, name, text)
    if run is not None and levels != dict(run.levels):
        study_uid = study_of(desk.connection).uid
        new["condition"] = ensure_condition(desk, book.configuration, study_uid, levels)
    old = old_values(desk.connection, kind, uid, new) if new else {}
    changed = {name: value for name, value in new.items() if old[name] != value}
    if not changed:
        raise UsageError(f"{target} says that already: nothing was changed.")
    before = {name: old[name] for name in changed}
    desk.state(Statement(Action.CORRECT, kind, uid, new=changed, old=before, reason=why))
    return {name: (before[name], value) for name, value in changed.items()}


def void(desk: Desk, name: str, reason: str) -> None:
    """State that a run does not count; it stays in the book with everything that belongs to it."""
    refuse_empty("--reason", reason)
    run = run_named(desk.connection, name)
    if run.state is RunState.VOID:
        raise UsageError(f"run {name} is void already: the journal keeps who said so and why (`labbook show {name}`).")
    desk.state(
        Statement(Action.VOID, "run", run.uid, new={"state": "void"}, old={"state": str(run.state)}, reason=reason)
    )


def unvoid(desk: Desk, name: str, reason: str) -> None:
    """State that a run counts after all; it is complete where its duration is known, open otherwise."""
    refuse_empty("--reason", reason)
    run = run_named(desk.connection, name)
    if run.state is not RunState.VOID:
        raise UsageError(f"run {name} is not void: there is nothing to take back.")
    state = RunState.OPEN if run.duration_s is None else RunState.COMPLETE
    desk.state(
        Statement(Action.CORRECT, "run", run.uid, new={"state": str(state)}, old={"state": "void"}, reason=reason)
    )


def _assignments(texts: Sequence[str]) -> dict[str, str]:
    given = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise UsageError(f"{text!r} is not a correction: write FIELD=VALUE, for example foot=large.")
        given[name.strip()] = value.strip()
    return given


def _target(connection: sa.Connection, target: str) -> tuple[str, str, RunRow | None]:
    kind, colon, name = target.partition(":")
    if target == "study":
        return "study", study_of(connection).uid, None
    if colon and kind in (*_NAMED, "charge"):
        uid = find_uid(connection, kind, **({"uid": name} if kind == "charge" else {"name": name}))
        if uid is None:
            raise UsageError(f"there is no {kind} {name!r}: look it up with `labbook show RUN` or in labbook.toml.")
        return kind, uid, None
    if colon and kind == "level":
        return "level", _level(connection, name), None
    run = run_named(connection, target)
    return "run", run.uid, run


def _level(connection: sa.Connection, name: str) -> str:
    known = {f"{factor.name}={level.label}": level.uid for factor in factors(connection) for level in factor.levels}
    if name not in known:
        raise unknown_name("level", name, known, "Write it as level:FACTOR=LABEL.")
    return known[name]


def _column(book: Book, desk: Desk, kind: str, name: str, text: str) -> dict[str, Any]:
    table = FACTS[kind]
    fixed = _FIXED | ({"name"} if kind == "factor" else set())  # it stands in the names of conditions
    allowed = [column.name for column in table.c if column.name not in fixed]
    if name not in allowed:
        of_study = list(book.configuration.factors) if kind == "run" else []
        raise unknown_name(f"field of a {kind}", name, [*of_study, *allowed])
    column = table.c[name]
    if name in ("robot", "battery"):
        known: Mapping[str, Any] = getattr(book.configuration, {"battery": "batteries"}.get(name, f"{name}s"))
        return {name: named_uid(desk.connection, name, text, known)}
    if name == "day":
        return {name: ensure_day(desk, study_of(desk.connection).uid, _date(text))}
    if name == "run":
        return {name: None if text == "none" else run_named(desk.connection, text).uid}
    return {name: _text(kind, text, column) if isinstance(column.type, sa.Text) else _number(name, text, column)}


def _text(kind: str, text: str, column: sa.Column[Any]) -> str | None:
    """Read what is stored as text: words of a closed list, time zones and instants are held to what they mean."""
    if not text:
        if column.nullable:
            return None
        raise UsageError(f"{column.name}= is empty: every {kind} needs its {column.name}.")
    words = _WORDS.get((kind, column.name))
    if words is not None and text not in tuple(words):
        raise unknown_name(f"{column.name} of a {kind}", text, words)
    if column.name == "time_zone" and text not in zoneinfo.available_timezones():
        raise unknown_name("time zone", text, zoneinfo.available_timezones())
    if column.name.endswith("_json"):
        return _json(column.name, text)
    return _instant(column.name, text) if column.name.endswith("_utc") else text


def _json(name: str, text: str) -> str:
    try:
        return canonical(json.loads(text))
    except ValueError:
        raise UsageError(f'{name}={text} is not JSON: write it as {name}={{"radius_m":0.038}}.') from None


def _instant(name: str, text: str) -> str:
    try:
        moment = datetime.datetime.fromisoformat(text)
    except ValueError:
        moment = None
    if moment is None or moment.tzinfo is None:
        raise UsageError(f"{name}={text} is no instant: write it with its zone, as 2021-06-01T14:30:00Z.")
    return moment.astimezone(datetime.UTC).isoformat().replace("+00:00", "Z")


def _number(name: str, text: str, column: sa.Column[Any]) -> float | int:
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f"{name}={text} is not a number: write it with a decimal point, for example 720.") from None
    if isinstance(column.type, Real):
        if math.isfinite(value):
            return value
    elif value.is_integer():
        return int(value)
    raise UsageError(
        f"{name}={text} cannot be stored: {name} is a {'finite' if isinstance(column.type, Real) else 'whole'} number."
    )


def _date(text: str) -> str:
    try:
        return datetime.date.fromisoformat(text).isoformat()
    except ValueError:
        raise UsageError(f"day={text} is not a date: write it as 2021-06-01.") from None
