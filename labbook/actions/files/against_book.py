"""What the book finds of a file that was read: columns that were named and are not there, another day than its run's.

And what is left of a file that is refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import sqlalchemy as sa

from data_schema.journal import canonical
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.imported_files import links_of_file
from data_schema.queries.imports import findings_of, refused_with
from data_schema.vocabulary import Action, FileRole, Severity
from ingest.declared import ABSENT
from ingest.model import Finding, ReadFile
from labbook.actions.files.charges_against_book import charges_ahead, with_charges_possible
from labbook.analysis.outcomes.log_dates import ABOUT_DAY, day_notes, log_ahead, swapped_day
from labbook.book.write_session import Statement, WriteSession, new_uid
from labbook.config.parsing import Configuration
from labbook.statements.importing import PreparedImport, finding_values, without_name


def refused_without_columns(read: ReadFile, options: Mapping[str, Any]) -> ReadFile:
    """Refuse a file without a column that `options` name; one that only a profile names stays a note."""
    named = options.get("columns", {})
    findings = [
        replace(finding, severity=Severity.FILE) if finding.rule == ABSENT and finding.column in named else finding
        for finding in read.findings
    ]
    return replace(read, findings=tuple(sorted(findings, key=lambda finding: finding.severity is not Severity.FILE)))


def state_refusal(session: WriteSession, new: Mapping[str, Any], prepared: PreparedImport) -> None:
    """Leave one row with the findings, the first time that these bytes are refused for this."""
    read, settings = prepared.read, prepared.settings.as_json()
    before = refused_with(session.connection, prepared.sha256, read.format, canonical(new["options"]))
    if without_name(settings) in map(without_name, before):
        return
    record = {
        **new,
        "reader": read.format,
        "reader_version": read.reader_version,
        "plugin": read.plugin,
        "settings": settings,
        "rows": {"read": read.rows_read, "kept": read.rows_kept, "rejected": read.rows_rejected},
        "findings": [finding_values(finding) for finding in read.findings],
    }
    session.state(Statement(Action.REFUSE, "ingest", new_uid(), new=record))


def with_findings_of_book(connection: sa.Connection, ingest_uid: str, read: ReadFile, rules: Sequence[str]) -> ReadFile:
    """Add what only the book could tell: a charge that is known, one that contradicts, jumps that were not found."""
    added = tuple(
        Finding(
            Severity(row.severity), row.rule, row.message, row.line, row.column_name, row.value, row.n, row.more_lines
        )
        for row in findings_of(connection, ingest_uid, rules)
    )
    return with_days_ahead(replace(read, findings=read.findings + added))


def with_days_ahead(read: ReadFile) -> ReadFile:
    """Add that a file's days are yet to come, unless it is told already that they are not its run's.

    That is told and never stored: it does not stay true.
    """
    zone = None if read.declared is None else read.declared.time_zone
    if read.refused or zone is None or any(finding.rule == ABOUT_DAY for finding in read.findings):
        return read
    return replace(read, findings=(*read.findings, *charges_ahead(read, zone), *log_ahead(read.parts, zone)))


def refused_by_book(
    connection: sa.Connection,
    configuration: Configuration,
    read: ReadFile,
    run: str | None,
    *,
    file_uid: str | None = None,
    notes: bool = False,
) -> ReadFile:
    """Add the refusal where day and month were read the wrong way round, or charges are none that packs can take.

    `notes`: also that the days of a log and its run differ, or are yet to come.

    The runs are those that the parts of the file `file_uid` belong to, where they belong to any, else the one named
    `run`.
    """
    if read.refused:
        return read
    if read.role is FileRole.CHARGE:
        possible = with_charges_possible(connection, configuration, read, run)
        return with_days_ahead(possible) if notes else possible
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
    judged = replace(read, findings=(*refusals, *read.findings, *(() if refusals else noted)))
    return with_days_ahead(judged) if notes else judged


def name_and_day(connection: sa.Connection, run_uid: str) -> tuple[str, str]:
    """Return the name of a run and its local date."""
    run = read_fact(connection, "run", run_uid, ["name", "day"])
    return run["name"], read_fact(connection, "day", run["day"], ["date_local"])["date_local"]
