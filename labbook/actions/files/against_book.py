"""What the book finds of a file that was read, and what is left of one that is refused.

Columns that were named and are not there, another day than its run's, day and month exchanged.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, date, datetime, timedelta
from typing import Any
from zoneinfo import ZoneInfo

import sqlalchemy as sa

from data_schema.journal import canonical
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.files import findings_of, links_of_file, refused_with
from data_schema.queries.runs import runs_named
from data_schema.queries.signals import every_start
from data_schema.queries.study import days_with_runs
from data_schema.vocabulary import Action, FileRole, Severity
from ingest.channels.columns import UNDATED
from ingest.declared import ABSENT
from ingest.model import MORE_LINES, ChargeRow, Finding, ReadFile
from ingest.read import read_file
from labbook.analysis.outcomes.log_dates import (
    ABOUT_DAY,
    AHEAD,
    SWAPPED,
    day_month_swapped,
    day_notes,
    future_date_sentence,
    future_log,
    is_future,
    is_swapped,
    other_order,
    swapped_day,
)
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession, new_uid
from labbook.statements.importing import PreparedImport, ReadSettings, finding_values, without_name


def refused_without_columns(read: ReadFile, options: Mapping[str, Any]) -> ReadFile:
    """Refuse a file without a column that `options` name; one that only a profile names stays a note."""
    named = {unicodedata.normalize("NFC", name) for name in options.get("columns", {})}
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
    session.state(Statement(Action.INGEST, "ingest", new_uid(), new=record))


def with_findings_of_book(connection: sa.Connection, ingest_uid: str, read: ReadFile, rules: Sequence[str]) -> ReadFile:
    """Add findings that need the book: a charge that is known, one that contradicts, jumps that were not found."""
    added = tuple(
        Finding(
            Severity(row.severity), row.rule, row.message, row.line, row.column_name, row.value, row.n, row.more_lines
        )
        for row in findings_of(connection, ingest_uid, rules)
    )
    return _with_days_ahead(replace(read, findings=read.findings + added))


def _with_days_ahead(read: ReadFile) -> ReadFile:
    """Add a finding where a file's days are in the future, unless there is one already that they are not its run's.

    It is shown and never stored: it does not stay true.
    """
    zone = None if read.declared is None else read.declared.time_zone
    if read.refused or zone is None or any(finding.rule == ABOUT_DAY for finding in read.findings):
        return read
    return replace(read, findings=(*read.findings, *_charges_ahead(read, zone), *future_log(read.parts, zone)))


def refused_by_book(
    connection: sa.Connection,
    read: ReadFile,
    run: str | None,
    *,
    file_uid: str | None = None,
    notes: bool = False,
) -> ReadFile:
    """Add the refusal where day and month were read the wrong way round.

    `notes`: also that the days of a log and its run differ, or are yet to come.

    The runs are those that the parts of the file `file_uid` belong to, where they belong to any, else the one named
    `run`.
    """
    if read.refused:
        return read
    if read.role is FileRole.CHARGE:
        judged = replace(read, findings=(*_swapped(connection, read, run), *read.findings))
        return _with_days_ahead(judged) if notes else judged
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
    return _with_days_ahead(judged) if notes else judged


def read_on_day_of(
    book: Book, data: bytes, settings: ReadSettings, read: ReadFile, run: str | None
) -> tuple[ReadSettings, ReadFile]:
    """Read a log again with its run's date, where a calibration has to be chosen by a date and the log has none."""
    if run is None or all(finding.rule != UNDATED for finding in read.findings):
        return settings, read
    with book.reading() as connection:
        uid = find_uid(connection, "run", name=run)
        day = None if uid is None else name_and_day(connection, uid)[1]
    if day is None:
        return settings, read
    declared = replace(settings.declared, day=day)
    return replace(settings, declared=declared), read_file(data, declared)


def name_and_day(connection: sa.Connection, run_uid: str) -> tuple[str, str]:
    """Return the name of a run and its local date."""
    run = read_fact(connection, "run", run_uid, ["name", "day"])
    return run["name"], read_fact(connection, "day", run["day"], ["date_local"])["date_local"]


def _charges_ahead(read: ReadFile, zone: str) -> list[Finding]:
    """Return what is found of recharges that ended on days to come; empty where none did."""
    today = datetime.now(UTC).date()
    ahead = {place: day for place, day in _dates(read, zone).items() if is_future(day, today)}
    if not ahead:
        return []
    first, day = next(iter(ahead.items()))
    original = read.charges[first].ended_original
    found = _finding(
        AHEAD, future_date_sentence(original, day, today), [read.charges[place] for place in ahead], original
    )
    return [replace(found, severity=Severity.NOTE)]


def _dates(read: ReadFile, zone: str) -> dict[int, date]:
    """Return the local dates at which recharges ended, by their place in the file, of those that have one."""
    return {
        place: datetime.fromisoformat(charge.ended_utc).astimezone(ZoneInfo(zone)).date()
        for place, charge in enumerate(read.charges)
        if charge.ended_utc is not None and charge.ended_original is not None
    }


def _swapped(connection: sa.Connection, read: ReadFile, run_of_file: str | None) -> list[Finding]:
    """Refuse dates that are their runs', or past, only with day and month exchanged, unless others are right as read.

    Of runs that the book has not, the days of the book decide where they explain all of two dates or more, exchanged.
    `run_of_file` is the one that a file of one recharge belongs to.
    """
    names = {charge.stated_run or run_of_file for charge in read.charges} - {None}
    by_name = {row.name: row for row in runs_named(connection, sorted(filter(None, names)))}
    runs = [by_name.get(charge.stated_run or run_of_file or "") for charge in read.charges]
    zone = None if read.declared is None else read.declared.time_zone
    if zone is None:
        return []
    dates = _dates(read, zone)
    today = datetime.now(UTC).date()
    wrong, unknown = {}, {}
    for place, day in dates.items():
        run = runs[place]
        if run is None:
            unknown[place] = day
        elif is_swapped(day, date.fromisoformat(run.day)):
            wrong[place] = f"run {run.name} is of {run.day}"
        if place not in wrong and is_future(day, today) and not is_future(day_month_swapped(day) or day, today):
            wrong[place] = "that is yet to come"
    if not wrong and len(set(unknown.values())) > 1:
        days = {date.fromisoformat(day) for day in days_with_runs(connection)}
        days |= {datetime.fromisoformat(start).astimezone(ZoneInfo(zone)).date() for start in every_start(connection)}
        if all(any(is_swapped(day, of_book) for of_book in days) for day in unknown.values()) and not any(
            timedelta(0) <= day - of_book <= timedelta(days=1) for day in unknown.values() for of_book in days
        ):
            wrong = dict.fromkeys(unknown, "runs and logs of the book have its date with day and month exchanged")
    orders = {place: other_order(read.charges[place].ended_original or "", dates[place]) for place in dates}
    wrong = {place: why for place, why in wrong.items() if orders[place] is not None}
    right = [
        place
        for place, day in dates.items()
        if (run := runs[place]) and str(day) == run.day != str(day_month_swapped(day))
    ]
    if not wrong or right:
        return []
    first, why = next(iter(wrong.items()))
    all_turned = all(order is not None for order in orders.values())
    remedy = f"say `--dates {orders[first]}`" if all_turned else "correct it in the sheet"
    run = runs[first]
    if run is not None:
        remedy += f", or, if the run's date is wrong, `labbook correct {run.name} date={dates[first]} --why ...` first"
    message = (
        f"{read.charges[first].ended_original!r} is read as {dates[first]}, and {why}: day and month are exchanged; "
        f"{remedy}."
    )
    return [_finding(SWAPPED, message, [read.charges[place] for place in wrong], read.charges[first].ended_original)]


def _finding(rule: str, message: str, charges: Sequence[ChargeRow], value: str | None) -> Finding:
    lines = [charge.line for charge in charges if charge.line is not None]
    return Finding(
        Severity.FILE,
        rule,
        message,
        lines[0] if lines else None,
        None,
        value,
        len(charges),
        tuple(lines[1:])[:MORE_LINES],
    )
