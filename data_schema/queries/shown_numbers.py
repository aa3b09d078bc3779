"""Numbers as reports showed them, beside the numbers that the book holds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.chunks import in_chunks
from data_schema.queries.results import resting_on
from data_schema.row_hashes import written
from data_schema.tables.results import report, report_item, result, result_number


@dataclass(frozen=True, slots=True)
class ShownIn:
    """A report that shows a number: the value it printed, and the versions of the algorithms it was made with."""

    report: str
    made_utc: str
    value: float | None
    versions: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class ShownNumber:
    """A number as a report printed it, whether the book holds one of that id, and that one's value."""

    report: str
    number_uid: str
    printed: float | None
    known: bool
    value: float | None


def number_beginning(connection: sa.Connection, beginning: str) -> str | None:
    """Return the id of the one number, stored or shown in a report, whose id begins so; None for none or several."""
    columns = (result_number.c.uid, report_item.c.number_uid)
    queries = [sa.select(column).where(column.startswith(beginning, autoescape=True)) for column in columns]
    rows = connection.execute(sa.union(*queries).limit(2)).scalars().all()
    return rows[0] if len(rows) == 1 else None


def add_report_items(connection: sa.Connection, report_uid: str, shown: Mapping[str, float | None]) -> None:
    """Store which numbers a report shows, by their ids, with the values it printed.

    Each is linked to the stored number of that id; it stays without a link where there is none.
    """
    owner = connection.execute(sa.select(report.c.id).where(report.c.uid == report_uid)).scalar_one()
    keys: dict[str, int] = {}
    for some in in_chunks(sorted(shown)):
        query = sa.select(result_number.c.uid, result_number.c.id).where(result_number.c.uid.in_(some))
        keys |= {row.uid: row.id for row in connection.execute(query)}
    if shown:
        connection.execute(
            report_item.insert(),
            [
                {"report": owner, "number_uid": uid, "value": shown[uid], "result_number": keys.get(uid)}
                for uid in sorted(shown)
            ],
        )
        written(connection, "report", [report_uid])


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


def reports_resting_on(connection: sa.Connection, inputs: Sequence[tuple[str, str]]) -> list[str]:
    """List the reports that show a number of these results, or one that rests on these facts, by (kind, uid)."""
    resting = [*resting_on(connection, inputs), *(uid for kind, uid in inputs if kind == "result")]
    found: set[str] = set()
    for some in in_chunks(resting):
        query = (
            sa.select(report.c.uid)
            .distinct()
            .join(report_item, report_item.c.report == report.c.id)
            .join(result_number, report_item.c.result_number == result_number.c.id)
            .join(result, result_number.c.result == result.c.id)
            .where(result.c.uid.in_(some))
        )
        found |= set(connection.execute(query).scalars())
    return sorted(found)


def shown_numbers(connection: sa.Connection) -> list[ShownNumber]:
    """List what all reports show, beside what the book holds under the same ids."""
    query = (
        sa.select(
            report.c.uid,
            report_item.c.number_uid,
            report_item.c.value,
            result_number.c.id.is_not(None),
            result_number.c.value.label("value_now"),
        )
        .join(report, report_item.c.report == report.c.id)
        .outerjoin(result_number, report_item.c.result_number == result_number.c.id)
        .order_by(report.c.id, report_item.c.number_uid)
    )
    return [ShownNumber(row[0], row[1], row[2], bool(row[3]), row[4]) for row in connection.execute(query)]
