"""The reports of a book: when each was made and by whom, the numbers it shows, and the inputs of its results."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.results import results_depending_on
from data_schema.tables.base import columns_of, in_chunks
from data_schema.tables.journal import journal, person
from data_schema.tables.results import report, report_item, result, result_input, result_number
from data_schema.tables.signals import detection
from data_schema.vocabulary import Action


@dataclass(frozen=True, slots=True)
class ReportRow:
    """A report: its place among all from 1, the number of its entry, who made it when, of which runs, and with what.

    `selection` is "" for all runs, `versions` are those of the algorithms, `numbers` how many numbers it shows.
    """

    number: int
    uid: str
    seq: int
    made_utc: str
    person: str
    selection: str
    versions: Mapping[str, int]
    numbers: int


@dataclass(frozen=True, slots=True)
class ShownRow:
    """A number that a report shows, as printed; the fields after that are None where the book has it no longer."""

    report_uid: str
    number_uid: str
    value: float | None
    value_now: float | None
    name: str | None
    unit: str | None
    kind: str | None
    scope_json: str | None
    result_uid: str | None
    se: float | None


@dataclass(frozen=True, slots=True)
class ResultHead:
    """A result as others see it: what it is, by which version it was computed, and its inputs as (kind, uid, hash).

    `content` is a hash that results with the same kind, scope, numbers and payload share. Of found jumps the uid is the
    detector's name and the hash its version: where they differ otherwise, so does another input.
    """

    kind: str
    scope_json: str
    version: int
    content: bytes
    inputs: frozenset[tuple[str, str, str]]


def list_reports(connection: sa.Connection) -> list[ReportRow]:
    """List the reports in the order in which they were stated."""
    counts = sa.select(report_item.c.report, sa.func.count().label("numbers")).group_by(report_item.c.report).subquery()
    query = (
        sa.select(
            report.c.uid,
            journal.c.seq,
            report.c.made_utc,
            person.c.name,
            report.c.options_json,
            report.c.versions_json,
            sa.func.coalesce(counts.c.numbers, 0),
        )
        .join(journal, sa.and_(journal.c.entity_uid == report.c.uid, journal.c.action == Action.REPORT))
        .join(person, journal.c.person == person.c.id)
        .outerjoin(counts, counts.c.report == report.c.id)
        .order_by(journal.c.seq)
    )
    return [
        ReportRow(place, *row[:4], json.loads(row[4])["where"] or "", json.loads(row[5]), row[6])
        for place, row in enumerate(connection.execute(query), start=1)
    ]


def shown_numbers(connection: sa.Connection, report_uid: str | None = None) -> list[ShownRow]:
    """List the numbers that a report shows, or all do, as they were computed, those that are gone last."""
    query = (
        sa.select(
            *columns_of(
                ShownRow,
                result_number,
                report_uid=report.c.uid,
                number_uid=report_item.c.number_uid,
                value=report_item.c.value,
                value_now=result_number.c.value,
                kind=result.c.kind,
                scope_json=result.c.scope_json,
                result_uid=result.c.uid,
            )
        )
        .join(report, report_item.c.report == report.c.id)
        .outerjoin(result_number, report_item.c.result_number == result_number.c.id)
        .outerjoin(result, result_number.c.result == result.c.id)
        .where(sa.true() if report_uid is None else report.c.uid == report_uid)
        .order_by(result_number.c.id.is_(None), result_number.c.id, report_item.c.number_uid)
    )
    return [ShownRow(*row) for row in connection.execute(query)]


def result_heads(connection: sa.Connection) -> dict[str, ResultHead]:
    """Return every stored result with its inputs, by its uid."""
    inputs: dict[int, set[tuple[str, str, str]]] = {}
    query = sa.select(
        result_input.c.result,
        result_input.c.input_kind,
        sa.func.coalesce(detection.c.algorithm, result_input.c.input_uid),
        sa.func.coalesce(sa.cast(detection.c.version, sa.Text), result_input.c.input_sha256),
    ).outerjoin(
        detection, sa.and_(result_input.c.input_kind == "detection", detection.c.uid == result_input.c.input_uid)
    )
    for key, *what in connection.execute(query):
        inputs.setdefault(key, set()).add(tuple(what))
    values: dict[int, list[tuple[object, ...]]] = {}
    columns = [column for column in result_number.c if column.name not in ("id", "uid", "result")]
    for key, *value in connection.execute(sa.select(result_number.c.result, *columns).order_by(result_number.c.name)):
        values.setdefault(key, []).append(tuple(value))
    found = {}
    for row in connection.execute(sa.select(result).order_by(result.c.id)):
        content = repr((row.kind, row.scope_json, row.payload_json, values.get(row.id)))
        about = (row.kind, row.scope_json, row.version, hashlib.sha256(content.encode()).digest())
        found[row.uid] = ResultHead(*about, frozenset(inputs.get(row.id, ())))
    return found


@dataclass(frozen=True, slots=True)
class ShownIn:
    """A report that shows a number: the value it printed, and the versions of the algorithms it was made with."""

    report: str
    made_utc: str
    value: float | None
    versions: Mapping[str, int]


def reports_showing(connection: sa.Connection, number_uid: str) -> list[ShownIn]:
    """List the reports that show a number, in the order in which they were made."""
    query = (
        sa.select(report.c.uid, report.c.made_utc, report_item.c.value, report.c.versions_json)
        .join(report_item, report_item.c.report == report.c.id)
        .where(report_item.c.number_uid == number_uid)
        .order_by(report.c.id)
    )
    return [
        ShownIn(row.uid, row.made_utc, row.value, json.loads(row.versions_json)) for row in connection.execute(query)
    ]


def reports_depending_on(connection: sa.Connection, inputs: Sequence[tuple[str, str]]) -> list[str]:
    """List the reports that show a number of these results, or one that depends on these facts, by (kind, uid).

    Each is the time at which it was made, which names its folder, and the selection of its runs.
    """
    dependent = [*results_depending_on(connection, inputs), *(uid for kind, uid in inputs if kind == "result")]
    found: set[tuple[str, str]] = set()
    for some in in_chunks(dependent):
        query = (
            sa.select(report.c.made_utc, report.c.options_json)
            .distinct()
            .join(report_item, report_item.c.report == report.c.id)
            .join(result_number, report_item.c.result_number == result_number.c.id)
            .join(result, result_number.c.result == result.c.id)
            .where(result.c.uid.in_(some))
        )
        found |= {
            (row.made_utc, json.loads(row.options_json)["where"] or "all runs") for row in connection.execute(query)
        }
    return [f"{made_utc} ({where})" for made_utc, where in sorted(found)]
