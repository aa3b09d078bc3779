"""The reports of a book: when each was made, by whom, of which runs, and where its files are."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.journal import journal, person
from data_schema.tables.reports import report
from data_schema.vocabulary import Action


@dataclass(frozen=True, slots=True)
class ReportRow:
    """A report: its place among all from 1, the number of its entry, who made it when, of which runs, and with what.

    `selection` is "" for all runs, `versions` are those of the algorithms, `numbers` how many numbers it shows. Its
    `files` are in `folder`, as it counts from the book's, each with the hash of its bytes. Of a report made
    `elsewhere`, in a book that was merged into this one, they are there.
    """

    number: int
    uid: str
    seq: int
    made_utc: str
    person: str
    selection: str
    versions: Mapping[str, int]
    numbers: int
    folder: str
    files: Mapping[str, str]
    elsewhere: bool

    @property
    def called(self) -> str:
        """The report as a message names it."""
        return f"{self.number} of {self.made_utc} ({self.selection or 'all runs'})"


def list_reports(connection: sa.Connection) -> list[ReportRow]:
    """List the reports in the order in which they were stated."""
    query = (
        sa.select(
            report.c.uid,
            journal.c.seq,
            report.c.made_utc,
            person.c.name,
            report.c.selection,
            report.c.versions_json,
            journal.c.new_json,
            journal.c.origin_json,
        )
        .join(report, sa.and_(journal.c.entity_uid == report.c.uid, journal.c.action == Action.REPORT))
        .join(person, journal.c.person == person.c.id)
        .order_by(journal.c.seq)
    )
    found = []
    for place, row in enumerate(connection.execute(query), start=1):
        new = json.loads(row.new_json)
        about = (
            json.loads(row.versions_json),
            new["numbers"],
            new["folder"],
            new["files"],
            row.origin_json is not None,
        )
        found.append(ReportRow(place, row.uid, row.seq, row.made_utc, row.name, row.selection, *about))
    return found
