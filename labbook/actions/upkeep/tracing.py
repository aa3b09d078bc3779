"""From a number's provenance id down to the bytes it was computed from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sqlalchemy as sa

from data_schema.errors import UnknownName
from data_schema.queries.history import corrections_after
from data_schema.queries.reports import ShownIn, reports_showing
from data_schema.queries.results import NumberRow, ResultRow, numbers_beginning, result_of_number, results_by_uid
from data_schema.queries.sources import Source, describe_input
from labbook.analysis.results.result_cache import equals_printed
from labbook.book.naming import changes_in_words


@dataclass(frozen=True, slots=True)
class Trace:
    """A result, its direct inputs, and the traces of the results among these.

    A result that was met before is not followed again: `again`, without inputs.
    """

    uid: str
    kind: str
    scope: str
    algorithm: str
    version: int
    stale: bool
    inputs: tuple[Source, ...]
    below: tuple[Trace, ...]
    again: bool = False


@dataclass(frozen=True, slots=True)
class NumberTrace:
    """A number, the reports that show it, and where it came from."""

    number: NumberRow
    shown_in: tuple[ShownIn, ...]
    trace: Trace


@dataclass(frozen=True, slots=True)
class PrintedNumber:
    """A number that reports showed and that this labbook computes under another id; the versions are this labbook's."""

    uid: str
    value: float | None
    shown_in: tuple[ShownIn, ...]
    versions_now: Mapping[str, int]


def trace(connection: sa.Connection, beginning: str) -> NumberTrace | PrintedNumber:
    """Follow a number down; raises `UnknownName` when no single number has an id that begins so."""
    uids = numbers_beginning(connection, beginning)
    if not uids:
        raise UnknownName(f"no number's id begins with {beginning!r}: copy the whole id from the report.")
    if len(uids) > 1:
        ids = ", ".join([*uids[:2], *["..."] * (len(uids) > 2)])
        raise UnknownName(f"several numbers' ids begin with {beginning!r} ({ids}): copy the whole id from the report.")
    (uid,) = uids
    shown_in = tuple(reports_showing(connection, uid))
    found = result_of_number(connection, uid)
    if found is None:
        from labbook.analysis.algorithms import versions_now  # what computes, and takes long to import

        return PrintedNumber(uid, shown_in[-1].value, shown_in, versions_now())
    row, number = found
    return NumberTrace(number, shown_in, _trace(connection, row, [shown.report for shown in shown_in], set()))


def trace_of(connection: sa.Connection, uid: str) -> Trace | None:
    """Trace a number to its sources; None where there is no such number."""
    found = result_of_number(connection, uid)
    reports = [shown.report for shown in reports_showing(connection, uid)]
    return None if found is None else _trace(connection, found[0], reports, set())


def trace_lines(found: NumberTrace | PrintedNumber) -> list[str]:
    """Write a trace as an indented tree, or all that is known of a number that was printed."""
    if isinstance(found, PrintedNumber):
        return _printed_lines(found)
    number = found.number
    value = number.undefined_reason if number.value is None else f"{number.value!r} {number.unit}"
    lines = [f"{number.uid}: {number.name} = {value}"]
    for shown in found.shown_in:
        printed = "" if equals_printed(shown.value, number.value) else f", printed as {_printed(shown.value)}"
        lines.append(f"shown in report {shown.report} of {shown.made_utc}{printed}")
    return lines + _lines(found.trace, 0)


def _printed_lines(found: PrintedNumber) -> list[str]:
    lines = [f"{found.uid}: printed as {_printed(found.value)}"]
    for shown in found.shown_in:
        printed = "" if equals_printed(shown.value, found.value) else f" as {_printed(shown.value)}"
        lines.append(f"shown in report {shown.report} of {shown.made_utc}{printed}, made with {_named(shown.versions)}")
    now = found.versions_now
    newer = {name: now[name] for name in now if any(shown.versions.get(name) != now[name] for shown in found.shown_in)}
    return [
        *lines,
        f"this labbook, with {_named(newer or now)}, computes it anew, and its results have other ids: make the report "
        "again to see them",
    ]


def _printed(value: float | None) -> str:
    return "undefined" if value is None else repr(value)


def _named(versions: Mapping[str, int]) -> str:
    return ", ".join(f"{name} {version}" for name, version in versions.items())


def _trace(connection: sa.Connection, row: ResultRow, reports: Sequence[str], met: set[str]) -> Trace:
    """Trace a result whose number these reports show: a fact corrected after all of them is shown with both values."""
    again = row.uid in met
    met.add(row.uid)
    sources, below = [], []
    for item in () if again else row.inputs:
        result = (
            results_by_uid(connection, [item.input_uid]).get(item.input_uid) if item.input_kind == "result" else None
        )
        if result is not None:
            below.append(_trace(connection, result, reports, met))
        else:
            source = describe_input(connection, item)
            changed = row.stale and item.input_kind != "idle_runs"  # whose uid is that of the robot
            since = _corrected_since(connection, item.input_uid, reports) if changed else ""
            sources.append(replace(source, text=source.text + since))
    about = (row.uid, row.kind, row.scope_json, row.algorithm, row.version, row.stale)
    return Trace(*about, tuple(sources), tuple(below), again)


def _corrected_since(connection: sa.Connection, uid: str, reports: Sequence[str]) -> str:
    old: dict[str, object] = {}
    new: dict[str, object] = {}
    for correction in corrections_after(connection, uid, reports):
        old = {**correction.old, **old}
        new |= correction.new
    differing = {name: value for name, value in new.items() if value != old.get(name)}
    words = changes_in_words(connection, old, differing)
    return f"; corrected after the last report with this number: {words}" if words else ""


def _lines(found: Trace, depth: int) -> list[str]:
    indent = "  " * depth
    stale = " (stale: something it rests on has changed since; facts below are told as they are now)"
    remark = stale if found.stale else ""
    remark += ", as above" if found.again else ""
    lines = [f"{indent}{found.kind} {found.scope}, {found.algorithm} version {found.version}{remark}"]
    lines += [f"{indent}  {source.kind}: {source.text}" for source in found.inputs]
    for below in found.below:
        lines += _lines(below, depth + 1)
    return lines
