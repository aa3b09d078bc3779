"""What the book finds of a file that was read, and what is left of one that is refused.

Columns that were named and are not there, another day than its run's; of recharges more than a pack can take, a wrong
unit, day and month exchanged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, date, datetime, timedelta
from typing import Any
from zoneinfo import ZoneInfo

import sqlalchemy as sa

from data_schema.journal import canonical
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.imported_files import links_of_file
from data_schema.queries.imports import findings_of, refused_with
from data_schema.queries.runs import RunRow, runs_named
from data_schema.queries.signals import every_start
from data_schema.queries.study import days_with_runs
from data_schema.vocabulary import Action, FileRole, Severity
from ingest.declared import ABSENT
from ingest.findings import MORE_LINES
from ingest.model import ChargeRow, ColumnUse, Finding, ReadFile
from labbook.actions.runs.charges import MOST_OF_CAPACITY
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
        possible = _with_charges_possible(connection, configuration, read, run)
        return _with_days_ahead(possible) if notes else possible
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


def name_and_day(connection: sa.Connection, run_uid: str) -> tuple[str, str]:
    """Return the name of a run and its local date."""
    run = read_fact(connection, "run", run_uid, ["name", "day"])
    return run["name"], read_fact(connection, "day", run["day"], ["date_local"])["date_local"]


_IMPLAUSIBLE = "charge_implausible"
_AH = 1e3
"""mAh."""


def _with_charges_possible(
    connection: sa.Connection, configuration: Configuration, read: ReadFile, run: str | None
) -> ReadFile:
    """Add the refusals of charges that no pack can take and of dates read the wrong way round.

    `run` is the one that a file of one recharge belongs to.
    """
    names = {charge.stated_run or run for charge in read.charges} - {None}
    runs = {row.name: row for row in runs_named(connection, sorted(filter(None, names)))}
    of_charge = [runs.get(charge.stated_run or run or "") for charge in read.charges]
    found = _implausible(configuration, read, of_charge) or _swapped(connection, read, of_charge)
    return replace(read, findings=(*found, *read.findings))


def _implausible(configuration: Configuration, read: ReadFile, runs: Sequence[RunRow | None]) -> list[Finding]:
    """Refuse a charge above what its pack can take, and a column whose numbers are all a thousandth of one."""
    packs = configuration.batteries
    if not packs:
        return []
    largest = max(packs, key=lambda name: packs[name].capacity_mah)
    names = [
        next((name for name in (charge.stated_pack or "", run.battery if run else "") if name in packs), largest)
        for charge, run in zip(read.charges, runs, strict=True)
    ]
    most = [MOST_OF_CAPACITY * packs[name].capacity_mah for name in names]
    column = next((use for table in read.explanation.tables for use in table.columns if use.holds == "charge"), None)
    above = [place for place, charge in enumerate(read.charges) if charge.charge_mah > most[place]]
    if above:
        first, pack = read.charges[above[0]], names[above[0]]
        message = (
            f"{first.charge_mah:g} mAh is more than pack {pack} can take ({most[above[0]]:g} mAh): correct the number, "
            f"{_unit_remedy(column)}or, if it is right, the pack's capacity, with `labbook correct "
            f"battery:{pack} capacity_mah=... --why ...` and in labbook.toml."
        )
        return [_finding(_IMPLAUSIBLE, message, [read.charges[place] for place in above], f"{first.charge_mah:g} mAh")]
    if column is None or column.unit != "mAh" or column.unit_from != "header":
        return []
    charges = [charge.charge_mah for charge in read.charges]
    if any(charges) and all(mah * _AH <= top for mah, top in zip(charges, most, strict=True)):
        message = (
            f"All charges are {max(charges):g} mAh or less, as if in Ah: correct {_unit_remedy(column)}or, if "
            f'they are mAh, say so: `--column "{column.name}=charge:mAh"`.'
        )
        return [_finding(_IMPLAUSIBLE, message, read.charges, f"{max(charges):g} mAh")]
    return []


def _unit_remedy(column: ColumnUse | None) -> str:
    """Say how the other unit is declared, of a column whose heading has one."""
    if column is None or column.unit is None:
        return ""
    other = "mAh" if column.unit == "Ah" else "Ah"
    return (
        f'the heading {column.name!r} if these are {other} (`--column "{column.name}=charge:{other}" '
        "--override-units`), "
    )


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


def _swapped(connection: sa.Connection, read: ReadFile, runs: Sequence[RunRow | None]) -> list[Finding]:
    """Refuse dates that are their run's, or past, only with day and month exchanged.

    Of runs that the book has not, the days of the book decide where they explain all of two dates or more, exchanged.
    """
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
    if not wrong:
        return []
    first, why = next(iter(wrong.items()))
    right = [
        place
        for place, day in dates.items()
        if (run := runs[place]) and str(day) == run.day != str(day_month_swapped(day))
    ]
    all_turned = not right and all(order is not None for order in orders.values())
    remedy = f"say `--dates {orders[first]}`" if all_turned else "correct it in the sheet, whose other dates are right"
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
