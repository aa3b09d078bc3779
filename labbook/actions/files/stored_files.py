"""`labbook files`: what the book has of the instruments' files, how each was read, and taking files out of use."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.queries.charges import charges_of_runs
from data_schema.queries.files import (
    LOST,
    FindingRow,
    InboxItem,
    PartRow,
    ReadingRow,
    charges_of_file,
    file_keys,
    find_files,
    findings_of,
    last_readings,
    links_of_file,
    lost_copies,
    parts_of_reading,
    readings_of,
    runs_by_file,
    runs_of_file,
    shown_readings,
)
from data_schema.queries.history import statements_about
from data_schema.queries.runs import run_uids_by_name
from data_schema.vocabulary import Action, ChargeState, IngestStatus
from labbook.actions.files.assigning import item_named
from labbook.actions.files.named_files import file_named
from labbook.book.naming import refuse_empty, study_of
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession
from labbook.config.local_time import local_text
from labbook.terminal import listed

if TYPE_CHECKING:  # it reads files, which a list need not wait for
    from labbook.actions.files.rereading import Reread, RereadRequest


@dataclass(frozen=True, slots=True)
class ListedFile:
    """A file of the book: its last reading, its runs, and a remark on its status."""

    reading: ReadingRow
    runs: tuple[str, ...]
    remark: str


@dataclass(frozen=True, slots=True)
class ShownReading:
    """One reading of a file with what it gave and found; `plugin` is whose format it was where not labbook's own."""

    reading: ReadingRow
    parts: tuple[PartRow, ...]
    findings: tuple[FindingRow, ...]
    plugin: str | None


@dataclass(frozen=True, slots=True)
class ShownFile:
    """A file with all its readings, the oldest first."""

    name: str
    uid: str
    sha256: str
    runs: tuple[str, ...]
    readings: tuple[ShownReading, ...]
    remark: str
    time_zone: str


def list_files(connection: sa.Connection) -> list[ListedFile]:
    """List the files of the book in the order in which they came."""
    runs, keys = runs_by_file(connection), file_keys(connection)
    return [
        ListedFile(row, runs.get(keys[row.sha256], ()), _remark(connection, row.status, row.file_uid or "", row.uid))
        for row in last_readings(connection)
    ]


def show_file(connection: sa.Connection, name: str) -> ShownFile:
    """Return the history of a file's readings."""
    file = file_named(connection, name, withdrawn=True)
    readings = readings_of(connection, file.sha256)
    shown = tuple(
        ShownReading(
            row,
            tuple(parts_of_reading(connection, row.uid)),
            tuple(findings_of(connection, row.uid)),
            statements_about(connection, row.uid, Action.INGEST)[-1].new.get("plugin"),
        )
        for row in readings
    )
    last = next(row for row in reversed(readings) if row.status in _LAST)
    return ShownFile(
        file.name,
        file.uid,
        file.sha256,
        runs_of_file(connection, file.sha256),
        shown,
        _remark(connection, last.status, file.uid, last.uid),
        study_of(connection).time_zone,
    )


def list_cells(connection: sa.Connection) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return head and rows of the list for people."""
    head = ("file", "read as", "rows", "runs", "uid", "remark")
    runs = runs_by_file(connection)
    rows: list[tuple[str, ...]] = [
        (name, reader, str(rows_kept), listed(runs.get(key, ()), 4), uid, _remark(connection, status, uid, reading))
        for name, reader, rows_kept, key, uid, status, reading in shown_readings(connection)
    ]
    return head, rows


def show_lines(shown: ShownFile) -> list[str]:
    """Write the history of a file for people."""
    runs = f"run {', '.join(shown.runs)}" if shown.runs else "no run"
    lines = [f"{shown.name} (uid {shown.uid}, sha256 {shown.sha256[:12]}), {runs}"]
    if shown.remark:
        lines.append(f"  {shown.remark}")
    for item in shown.readings:
        row = item.reading
        why = f" ({row.why})" if row.why else ""
        reader = f"{row.reader} version {row.reader_version}"
        reader += f" of plug-in {item.plugin}" if item.plugin else ""
        at = local_text(row.at_utc, shown.time_zone)
        lines.append(
            f"  {at} {row.person}: {row.status}, {reader}, {row.rows_kept} of {row.rows_read} rows kept, "
            f"{len(item.findings)} findings{why}"
        )
        lines.append(f"    declared: {_declared(row)}")
        for part in item.parts:
            channels = ", ".join(
                f"{column!r} is {name} [{unit}]" if unit else f"{column!r} is {name}"
                for (name, unit), column in zip(part.channels, part.columns, strict=True)
            )
            rate = "" if part.rate_hz is None else f", {part.rate_hz:.6g} Hz"
            name = f"part {part.part}: " if part.part else ""
            lines.append(f"    {name}{part.n_samples} samples{rate}: {channels}")
        lines += [
            f"    {finding.severity}: {finding.rule}: {finding.message}"
            for finding in item.findings
            if row.status is not IngestStatus.SUPERSEDED
        ]
    return lines


def reread_named(book: Book, name: str, request: RereadRequest) -> Reread:
    """Read one file again under today's labbook.toml, with what is declared about it."""
    from labbook.actions.files.rereading import reread

    with book.reading() as connection:
        file = file_named(connection, name)
        row = next(row for row in reversed(readings_of(connection, file.sha256)) if row.status in _LAST)
    return reread(book, row, request)


def files_to_reread(book: Book, step: Callable[[str], None]) -> list[ReadingRow]:
    """Return the files that today's labbook.toml would have read otherwise, and those that wait."""
    from labbook.actions.files.rereading import would_differ

    with book.reading() as connection:
        lost = lost_copies(connection)
        rows = [row for row in last_readings(connection) if row.status is not IngestStatus.WITHDRAWN]
    rows = [row for row in rows if row.sha256 not in lost]
    found = []
    for row in rows:
        if row.status is IngestStatus.WAITING or would_differ(book, row):
            found.append(row)
        step(row.name)
    return found


def withdraw(session: WriteSession, name: str, why: str) -> str:
    """State that a file is out of use; returns a sentence about the consequences."""
    refuse_empty("--why", why)
    file = file_named(session.connection, name, withdrawn=True)
    if file.status is IngestStatus.WITHDRAWN:
        return f"{file.name} is withdrawn already: `labbook files show {file.uid}` says by whom and why."
    charges = [row for row in charges_of_file(session.connection, file.uid) if row.state is ChargeState.COUNTED]
    runs = {link.run_uid for link in links_of_file(session.connection, file.uid)}
    of_runs = {row.uid: row.run_uid for row in charges if row.run_uid}
    old = {"runs": sorted({*runs, *of_runs.values()}), "charges": of_runs}
    of_same_runs = charges_of_runs(session.connection, sorted({*of_runs.values()}))
    before = {charge.uid for of_run in of_same_runs.values() for charge in of_run}
    session.state(Statement(Action.EXCLUDE, "file", file.uid, old=old, reason=why))
    of_same_runs = charges_of_runs(session.connection, sorted({*of_runs.values()}))
    in_place = [other for of_run in of_same_runs.values() for other in of_run if other.uid not in before]
    lost = f", {len(charges)} charges count no more" if charges else ""
    lost += f" and {len(in_place)} rows of other sheets count instead" if in_place else ""
    called = file.name if len(find_files(session.connection, file.name)) == 1 else file.uid
    return f"{file.name} is out of use{lost}: `labbook files restore {called}` takes it into use again."


def restore(session: WriteSession, name: str, why: str | None) -> str:
    """State that a withdrawn file is in use again; returns a sentence that confirms it."""
    file = file_named(session.connection, name, withdrawn=True)
    if file.status is not IngestStatus.WITHDRAWN:
        return f"{file.name} is in use: there is nothing to restore."
    left = statements_about(session.connection, file.uid, Action.EXCLUDE)[-1].old
    session.state(Statement(Action.INCLUDE, "file", file.uid, new=left, reason=why))
    return f"{file.name} is in use again."


def dismiss(session: WriteSession, what: str, why: str) -> str:
    """State that an item of the inbox belongs to no run and need not be asked about: a charge, or a whole file."""
    refuse_empty("--why", why)
    what, charge = item_named(session.connection, what)
    if charge is None:
        file = file_named(session.connection, what)
        if links_of_file(session.connection, file.uid) or runs_of_file(session.connection, file.sha256):
            raise UsageError(f"{file.name} belongs to a run: `labbook files withdraw {file.name}` takes it out of use.")
        return withdraw(session, what, why)
    if charge.run_uid is not None:
        raise UsageError(f"{what} belongs to run {charge.run_name}: `labbook assign {what} none` takes it off first.")
    if charge.state is ChargeState.DISMISSED:
        return f"{what} is dismissed already: `labbook runs restore {what}` brings it back."
    if charge.state is not ChargeState.COUNTED:
        raise UsageError(f"{what} is not in the inbox ({charge.state}): `labbook runs inbox` lists what is.")
    session.state(Statement(Action.EXCLUDE, "charge", charge.uid, reason=why))
    return f"{what} is dismissed: `labbook runs restore {what}` brings it back."


@dataclass(frozen=True, slots=True)
class Waiting:
    """An item of the inbox, and why it waits; None where nothing is known, as where a person took it off its run.

    `contradicts`: its run has another charge.
    """

    item: InboxItem
    why: str | None = None
    contradicts: bool = False


def why_waiting(connection: sa.Connection, items: Sequence[InboxItem]) -> list[Waiting]:
    """Return why each item of the inbox waits, as far as the book knows."""
    uids = run_uids_by_name(connection, sorted({item.stated_run for item in items if item.stated_run is not None}))
    charges = charges_of_runs(connection, sorted(uids.values()))
    found = []
    for item in items:
        of_run = charges.get(uids.get(item.stated_run or "", ""), ())
        if item.stated_run is None:
            found.append(Waiting(item, "it names no run, or two: `labbook assign` gives it one"))
        elif item.stated_run not in uids:
            found.append(Waiting(item, f"the book has no run {item.stated_run}: `labbook runs import` states it"))
        elif item.what == "charge" and of_run:
            why = f"run {item.stated_run} has a charge of {of_run[0].charge_mah:g} mAh"
            found.append(Waiting(item, why, contradicts=True))
        else:
            found.append(Waiting(item))
    return found


def restore_item(session: WriteSession, what: str, why: str | None) -> str:
    """State that an item is in the inbox again."""
    what, charge = item_named(session.connection, what)
    if charge is None:
        return restore(session, what, why)
    if charge.state is not ChargeState.DISMISSED:
        raise UsageError(f"{what} was not dismissed: there is nothing to restore.")
    session.state(Statement(Action.INCLUDE, "charge", charge.uid, reason=why))
    return f"{what} is in the inbox again."


_LAST = (IngestStatus.IMPORTED, IngestStatus.WITHDRAWN, IngestStatus.WAITING)


def _remark(connection: sa.Connection, status: str, file_uid: str, reading_uid: str) -> str:
    if status == IngestStatus.WITHDRAWN:
        withdrawal = statements_about(connection, file_uid, Action.EXCLUDE)[-1]
        at = local_text(withdrawal.at_utc, study_of(connection).time_zone)
        return f"withdrawn by {withdrawal.person} on {at}: {withdrawal.reason}"
    if status == IngestStatus.WAITING:
        refused = [item for item in findings_of(connection, reading_uid) if item.severity == "file"]
        what = "is lost" if refused and refused[0].rule == LOST else "waits for a declaration"
        return f"{what}: {refused[0].message if refused else ''}"
    return ""


def _declared(row: ReadingRow) -> str:
    declared = [
        f"{name} {json.dumps(value, ensure_ascii=False)}" for name, value in json.loads(row.options_json).items()
    ]
    profiles = json.loads(row.settings_json)["declared"]["profiles"]
    declared += [f"profile {profile['name']}" for profile in profiles]
    return "; ".join(declared) or "nothing"
