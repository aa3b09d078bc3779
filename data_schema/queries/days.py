"""Days and the checks made on them."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.design import day, day_check
from data_schema.tables.people import person
from data_schema.tables.runs import run
from data_schema.vocabulary import CheckKind


@dataclass(frozen=True, slots=True)
class CheckRow:
    """A check made on a day; the newest of its kind counts."""

    kind: CheckKind
    value: float | None
    unit: str | None
    passed: bool
    person: str
    at_utc: str


def day_uids(connection: sa.Connection) -> dict[str, str]:
    """Return the uid of every day by its date."""
    return {row.date_local: row.uid for row in connection.execute(sa.select(day.c.date_local, day.c.uid))}


def days_with_runs(connection: sa.Connection) -> set[str]:
    """Return the dates on which runs were made."""
    return set(connection.execute(sa.select(day.c.date_local).join(run, run.c.day == day.c.id).distinct()).scalars())


def checks_by_day(connection: sa.Connection) -> dict[str, list[CheckRow]]:
    """Return the newest check of each kind, by date."""
    query = (
        sa.select(
            day.c.date_local,
            day_check.c.kind,
            day_check.c.value,
            day_check.c.unit,
            day_check.c.passed,
            person.c.name,
            day_check.c.at_utc,
        )
        .join(day, day_check.c.day == day.c.id)
        .join(person, day_check.c.person == person.c.id)
        .order_by(day_check.c.id)
    )
    newest: dict[tuple[str, str], CheckRow] = {}
    for date, kind, value, unit, passed, name, at_utc in connection.execute(query):
        newest[(date, kind)] = CheckRow(CheckKind(kind), value, unit, bool(passed), name, at_utc)
    found: dict[str, list[CheckRow]] = {}
    for (date, _kind), row in newest.items():
        found.setdefault(date, []).append(row)
    return found
