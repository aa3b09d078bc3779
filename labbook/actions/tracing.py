"""From a number's provenance id down to the bytes it rests on."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.errors import UnknownName
from data_schema.queries.results import NumberRow, ResultRow, reports_showing, result_by_uid, result_of_number
from data_schema.queries.sources import Source, describe_input


@dataclass(frozen=True, slots=True)
class Trace:
    """A result, what it rests on directly, and the traces of the results among that."""

    kind: str
    scope: str
    algorithm: str
    version: int
    stale: bool
    inputs: tuple[Source, ...]
    below: tuple[Trace, ...]


@dataclass(frozen=True, slots=True)
class NumberTrace:
    """A number, the reports that show it, and where it came from."""

    number: NumberRow
    shown_in: tuple[tuple[str, str, str], ...]
    trace: Trace


def trace(connection: sa.Connection, number_uid: str) -> NumberTrace:
    """Follow a number down; raises `UnknownName` when no single number has an id that begins so."""
    found = result_of_number(connection, number_uid)
    if found is None:
        raise UnknownName(
            f"{number_uid!r} is the beginning of no number's id, or of several: copy the whole id from the report."
        )
    row, number = found
    return NumberTrace(number, tuple(reports_showing(connection, number.uid)), _trace(connection, row))


def trace_lines(found: NumberTrace) -> list[str]:
    """Write a trace as an indented tree."""
    number = found.number
    value = number.undefined_reason if number.value is None else f"{number.value!r} {number.unit}"
    lines = [f"{number.uid}: {number.name} = {value}"]
    lines += [f"shown in report {report} of {made_utc}" for report, made_utc, _place in found.shown_in]
    return lines + _lines(found.trace, 0)


def _trace(connection: sa.Connection, row: ResultRow) -> Trace:
    sources, below = [], []
    for item in row.inputs:
        result = result_by_uid(connection, item.input_uid) if item.input_kind == "result" else None
        if result is not None:
            below.append(_trace(connection, result))
        else:
            sources.append(describe_input(connection, item))
    return Trace(row.kind, row.scope_json, row.algorithm, row.version, row.stale, tuple(sources), tuple(below))


def _lines(found: Trace, depth: int) -> list[str]:
    indent = "  " * depth
    stale = " (stale: an input has changed since)" if found.stale else ""
    lines = [f"{indent}{found.kind} {found.scope}, {found.algorithm} version {found.version}{stale}"]
    lines += [f"{indent}  {source.kind}: {source.text}" for source in found.inputs]
    for below in found.below:
        lines += _lines(below, depth + 1)
    return lines
