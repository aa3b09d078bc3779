"""What is found of a file when its dates are held against the day of the run that it is about to belong to."""

from __future__ import annotations

from dataclasses import replace

import sqlalchemy as sa

from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.imported_files import links_of_file
from data_schema.vocabulary import FileRole
from ingest.model import Finding, ReadFile
from labbook.analysis.outcomes.log_dates import day_notes, swapped_day


def with_day_of_run(
    connection: sa.Connection, read: ReadFile, run: str | None, *, file_uid: str | None = None, notes: bool = False
) -> ReadFile:
    """Add the refusal where day and month were read the wrong way round; `notes`: also that the days differ.

    The runs are those that the parts of the file `file_uid` belong to, where they belong to any, else the one named
    `run`.
    """
    if read.refused or read.role is FileRole.CHARGE:
        return read
    links = [] if file_uid is None else links_of_file(connection, file_uid)
    meant = {link.part: link.run_uid for link in links}
    if not meant:
        uid = find_uid(connection, "run", name=run) if run else None
        meant = {part.part: uid for part in read.parts if uid is not None}
    zone = None if read.declared is None else read.declared.time_zone
    refusals: list[Finding] = []
    noted: list[Finding] = []
    for run_uid in dict.fromkeys(meant.values()):
        of_run = [part for part in read.parts if meant.get(part.part) == run_uid]
        name, day = name_and_day(connection, run_uid)
        refusals += swapped_day(of_run, name, day, zone)
        noted += day_notes(of_run, name, day, zone) if notes else []
    return replace(read, findings=(*refusals, *read.findings, *(() if refusals else noted)))


def name_and_day(connection: sa.Connection, run_uid: str) -> tuple[str, str]:
    """Return the name of a run and its local date."""
    run = read_fact(connection, "run", run_uid, ["name", "day"])
    return run["name"], read_fact(connection, "day", run["day"], ["date_local"])["date_local"]
