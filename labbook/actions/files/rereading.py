"""Reading a stored file again with the declarations of now: what that changes, and which reports it bears on.

`labbook ingest` on bytes that the book has comes here, too: to no change, another reading, or an assignment to a run.
"""

from __future__ import annotations

import contextlib
import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.journal import canonical
from data_schema.queries.charges import SheetRow, rows_of_file
from data_schema.queries.detections import jumps_found, verdicts_waiting
from data_schema.queries.facts import find_uid
from data_schema.queries.files import (
    ABOUT_RUNS,
    PartRow,
    ReadingRow,
    last_reading,
    links_of_file,
    lost_copies,
    parts_of_reading,
    runs_of_file,
)
from data_schema.queries.history import reading_entries, statements_about
from data_schema.vocabulary import Action, ChargeState, IngestStatus
from ingest.model import DEFAULT_LIMITS, Finding, ReadFile
from ingest.read import read_file
from ingest.store import raw_path
from labbook.actions.files.against_book import (
    name_and_day,
    read_on_day_of,
    refused_by_book,
    refused_without_columns,
    state_refusal,
    with_findings_of_book,
)
from labbook.book.opening import Book
from labbook.book.report_numbers import newest_depending_on
from labbook.book.write_session import DryRun, Statement, WriteSession, new_uid
from labbook.config.parsing import Configuration, parse_configuration
from labbook.statements.importing import (
    PreparedImport,
    ReadSettings,
    as_read,
    current_settings,
    store_reading,
    with_used_profile,
    without_storing,
)
from labbook.statements.reading_cache import remember
from labbook.statements.sheet_charges import charge_numbers, keys_of
from labbook.terminal import NOT_IN_JSON

OUTDATED = "labbook.toml would have it read otherwise now: `labbook files reread --all` reads such files again."
"""What is said of a file that the book has, where it would be read otherwise now."""


@dataclass(frozen=True, slots=True)
class Reread:
    """The outcome of reading a file again.

    `read` holds what was found, findings about runs included; where it was refused, the other fields are empty and the
    reading before stays in force. `changes` are sentences on what differs now, `verdicts_waiting` wait for a person.
    """

    file: str
    sha256: str
    read: ReadFile = field(metadata=NOT_IN_JSON)
    prepared: PreparedImport = field(metadata=NOT_IN_JSON)
    runs: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()
    reports: tuple[str, ...] = ()
    verdicts_waiting: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class RereadRequest:
    """A request to read a file again: person and reason, what is declared, and whether it is a dry run.

    What is declared adds to what was declared before, unless that is taken back (`afresh`).
    """

    options: Mapping[str, Any]
    person: str | None = None
    why: str | None = None
    dry_run: bool = False
    batch: str | None = None
    afresh: bool = False


def with_declared(before: Mapping[str, Any], added: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is declared of a file where more is declared of it, and of a column; a channel has one column."""
    new = added.get("columns", {})
    taken = {column.get("channel") for column in new.values()} - {None}
    columns = {
        name: dict(column)
        for name, column in before.get("columns", {}).items()
        if name in new or column.get("channel") not in taken
    }
    for name, column in new.items():
        said = {key: value for key, value in column.items() if value is not None}
        known = columns.get(name, {})
        if "unit" in said:
            known = {key: value for key, value in known.items() if key != "calibrations"}  # one is in its unit
        columns[name] = {**column, **known, **said}
    return {**before, **added, **({"columns": columns} if columns else {})}


def reread(book: Book, row: ReadingRow, request: RereadRequest) -> Reread:
    """Read the stored copy of a file under today's labbook.toml and the options given; a refusal changes nothing."""
    asked = request
    if not request.afresh:
        request = replace(request, options=with_declared(json.loads(row.options_json), request.options))
    with book.reading() as connection:
        if lost_copies(connection, row.sha256):
            mend = "run `labbook rebuild`, which has it now, first."
            if not book.store.has_raw(row.sha256):
                mend = "give the original file to `labbook ingest`, which reads it again."
            raise UsageError(f"the database was made without the raw copy of {row.name}: {mend}")
    data = book.store.raw(raw_path(row.sha256), row.sha256)
    settings = current_settings(book.configuration, request.options, row.name)
    settings, as_is = read_on_day_of(book, data, settings, read_file(data, settings.declared), _run_of(book, row))
    if request.batch is None and canonical(dict(request.options)) != row.options_json:
        as_is = refused_without_columns(as_is, request.options)
    with book.reading() as connection:
        read = refused_by_book(connection, as_is, row.stated_run, file_uid=row.file_uid)
    if request.dry_run:
        prepared = without_storing(data, row.sha256, read, settings)
    else:
        prepared = store_reading(book.store, data, row.sha256, read, settings)
        remember(prepared)
    done = Reread(row.name, row.sha256, prepared.read, prepared)
    with contextlib.suppress(DryRun), book.session(request.person) as session:
        now = last_reading(session.connection, row.sha256) or row
        judged = refused_by_book(session.connection, as_is, row.stated_run, file_uid=row.file_uid)
        if now.uid == row.uid and judged.findings == read.findings:
            if not prepared.read.refused:
                done = _state(book.store.root, session, row, request, prepared)
            elif not request.dry_run:
                state_refusal(session, _entry(row, request), prepared)
            if request.dry_run:
                raise DryRun
            return done
    return done if request.dry_run else reread(book, now, asked)  # others stated meanwhile what it was checked against


def would_differ(book: Book, row: ReadingRow) -> bool:
    """Tell whether a file would be read differently under today's labbook.toml, with the same declarations.

    The file is read only where the configuration is another one than at its reading.
    """
    then, now = _settings(_configuration(row.config_text), row), _settings(book.configuration, row)
    if _without_checks(then) == _without_checks(now) and not _is_of_other_day(book, row, now):
        return False
    data = book.store.raw(raw_path(row.sha256), row.sha256)
    now, read = read_on_day_of(book, data, now, read_file(data, now.declared), _run_of(book, row))
    return _without_checks(_recorded_settings(row)) != _without_checks(with_used_profile(now, read))


def _run_of(book: Book, row: ReadingRow) -> str | None:
    with book.reading() as connection:
        runs = runs_of_file(connection, row.sha256)
    return runs[0] if len(runs) == 1 else row.stated_run


def _is_of_other_day(book: Book, row: ReadingRow, now: ReadSettings) -> bool:
    """Whether a log was read by the date of its run, and its run has another one now."""
    recorded = _recorded_settings(row).declared.day
    if recorded is None or now.declared.day is not None:
        return False
    run = _run_of(book, row)
    with book.reading() as connection:
        uid = None if run is None else find_uid(connection, "run", name=run)
        return uid is None or name_and_day(connection, uid)[1] != recorded


def _without_checks(settings: ReadSettings) -> ReadSettings:
    """Leave out the settings that decide only whether a file is refused: the robots it is compared with, and limits."""
    return replace(settings, declared=replace(settings.declared, robots=(), limits=DEFAULT_LIMITS))


def _recorded_settings(row: ReadingRow) -> ReadSettings:
    return ReadSettings.from_json(json.loads(row.settings_json))


def _settings(configuration: Configuration, row: ReadingRow) -> ReadSettings:
    return current_settings(configuration, json.loads(row.options_json), row.name)


@functools.lru_cache(maxsize=64)
def _configuration(text: str) -> Configuration:
    return parse_configuration(text, "the book's configuration")


def _entry(row: ReadingRow, request: RereadRequest) -> dict[str, Any]:
    return {
        "sha256": row.sha256,
        "original_name": row.name,
        "modified_utc": row.modified_utc,
        "options": dict(request.options),
        "stated_run": row.stated_run,
        **({} if request.batch is None else {"batch": request.batch}),
    }


def _state(
    store: Path, session: WriteSession, row: ReadingRow, request: RereadRequest, prepared: PreparedImport
) -> Reread:
    connection = session.connection
    before = last_reading(connection, row.sha256) or row
    if before.status is IngestStatus.WITHDRAWN:
        raise UsageError(
            f"{row.name} was withdrawn meanwhile: take it into use with `labbook files restore {row.name}`, then have "
            "it read again."
        )
    old = ReadingContents.of(connection, before)
    waited = set(verdicts_waiting(connection))
    uid = new_uid()
    keys = keys_of(prepared.read.charges)
    numbers = charge_numbers(connection, row.sha256, keys)
    new = {**_entry(before, request), **as_read(prepared), "charge_numbers": [numbers[key] for key in keys]}
    if _stands(connection, before, new):
        uid, contents = before.uid, old
    else:
        standing = {"reading": before.uid}
        session.state(
            Statement(Action.INGEST, "ingest", uid, new=new, old=standing, reason=request.why, prepared=prepared)
        )
        after = last_reading(connection, row.sha256)
        assert after is not None  # noqa: S101 - it was stated just now
        contents = ReadingContents.of(connection, after)
    return Reread(
        row.name,
        row.sha256,
        with_findings_of_book(connection, uid, prepared.read, ABOUT_RUNS),
        prepared,
        runs_of_file(connection, row.sha256),
        tuple(changes(old, contents)),
        tuple(_outdated(store, connection, old, contents)),
        tuple(item.sentence for item in verdicts_waiting(connection) if item not in waited),
    )


def _stands(connection: sa.Connection, before: ReadingRow, new: Mapping[str, Any]) -> bool:
    """Tell whether the reading in force is this one, so that there is nothing to state."""
    stated = reading_entries(connection, before.sha256)[-1]
    same = all(stated.get(name) == value for name, value in json.loads(canonical(new)).items() if name != "batch")
    return same and before.status is IngestStatus.IMPORTED


def _outdated(store: Path, connection: sa.Connection, old: ReadingContents, new: ReadingContents) -> list[str]:
    """Name the newest report of each selection that has numbers of what comes out otherwise."""
    if (old.parts, old.charges, old.row.status) == (new.parts, new.charges, new.row.status):
        return []
    things = {("signal", part.sha256) for part in old.parts.values()}
    things |= {("run", link.run_uid) for link in links_of_file(connection, new.row.file_uid or "")}
    for uid, charge in {**old.charges, **new.charges}.items():
        things |= {("charge", uid), ("run", charge.run_uid or "")}
    return newest_depending_on(store, connection, things)


@dataclass(frozen=True, slots=True)
class ReadingContents:
    """The contents of a reading: its row, its parts by name, the jumps found in each, and the file's charges by uid."""

    row: ReadingRow
    parts: Mapping[str, PartRow]
    jumps: Mapping[str, int]
    charges: Mapping[str, SheetRow]

    @classmethod
    def of(cls, connection: sa.Connection, row: ReadingRow) -> Self:
        """Look up the contents of a reading, which must be the last of its file."""
        parts = {part.part: part for part in parts_of_reading(connection, row.uid)}
        rows = {item.uid: item for item in rows_of_file(connection, row.file_uid or "")}
        return cls(row, parts, jumps_found(connection, row.uid, _recorded_settings(row).detector), rows)


def changes(old: ReadingContents, new: ReadingContents) -> list[str]:
    """Return what differs in another reading, a sentence each; one sentence where nothing does."""
    found = _differences(_facts(old), _facts(new))
    if not found and any(part.sha256 != old.parts[name].sha256 for name, part in new.parts.items()):
        found = ["values differ"]
    if old.row.status is IngestStatus.WAITING:
        found.insert(0, "the file waited for a declaration and is read now")
    was, now = ({name: f"{n} jumps found" for name, n in one.jumps.items() if name in new.jumps} for one in (old, new))
    return [*found, *_differences(was, now), *_charge_changes(old, new)] or ["nothing comes out otherwise"]


def _facts(reading: ReadingContents) -> dict[Any, str]:
    """Return what may differ between two readings: in words, by what it is about."""
    row = reading.row
    found: dict[Any, str] = {
        "reader": f"read as {row.reader} version {row.reader_version}",
        "rows": f"{row.rows_kept} rows kept",
    }
    for name, part in reading.parts.items():
        rate = "no rate" if part.rate_hz is None else f"{part.rate_hz:.6g} samples a second"
        facts = {
            "samples": f"{part.n_samples} samples",
            "rate": rate,
            "start": f"start at {part.start_utc or 'no known instant'}",
            "gaps": f"{len(part.gaps)} gaps",
            **{channel: f"channel {channel} [{unit or 'no unit'}]" for channel, unit in part.channels},
        }
        found |= {(name, what): f"{text} in part {name!r}" if name else text for what, text in facts.items()}
    return found


def _differences(before: Mapping[Any, str], now: Mapping[Any, str]) -> list[str]:
    found = [f"{text}, was {before[about]}" for about, text in now.items() if before.get(about, text) != text]
    found += [f"{text} is new" for about, text in now.items() if about not in before]
    return found + [f"{text} is there no longer" for about, text in before.items() if about not in now]


def _charge_changes(old: ReadingContents, new: ReadingContents) -> list[str]:
    both = [(old.charges[uid], row) for uid, row in new.charges.items() if uid in old.charges]
    counts = {
        "new": sum(row.state is not ChargeState.GONE for uid, row in new.charges.items() if uid not in old.charges),
        "gone": sum(row.state is ChargeState.GONE and was.state is not ChargeState.GONE for was, row in both),
        "changed": sum(row.contents != was.contents for was, row in both),
    }
    listed = [f"{count} {what}" for what, count in counts.items() if count]
    return [f"charges: {', '.join(listed)}"] if listed else []


def take_known(
    book: Book,
    sha256: str,
    options: Mapping[str, Any],
    run: str | None,
    *,
    again: bool,
    person: str | None,
    dry_run: bool,
    batch: str | None,
) -> tuple[Reread | None, tuple[str, ...]]:
    """Read the stored copy again where other things are declared about it.

    Returns that reading, None where none was asked for, and messages about it.

    Nothing declared changes nothing. In a batch (`batch` is not None) options are for new files, but with `again`.
    """
    with book.reading() as connection:
        row = last_reading(connection, sha256)
        assert row is not None  # noqa: S101 - only known bytes come here
        assert row.file_uid is not None  # noqa: S101
        withdrawals = statements_about(connection, row.file_uid, Action.EXCLUDE)
        runs = runs_of_file(connection, sha256)
    if row.status is IngestStatus.WITHDRAWN:
        by = "".join(f" by {last.person} on {last.at_utc}: {last.reason}" for last in withdrawals[-1:])
        return None, (f"withdrawn{by}; `labbook files restore {row.name}` takes it into use again.",)
    declared = json.loads(row.options_json)
    declared_otherwise = canonical(with_declared(declared, options)) != canonical(declared)
    done, messages = None, []
    if declared_otherwise and batch is not None and not again:
        messages.append("what is declared is for new files: add --again, or `labbook files reread` it.")
    elif declared_otherwise:
        done = reread(book, row, RereadRequest(options, person, None, dry_run, batch))
        messages += reread_lines(done, dry_run=dry_run)
    elif row.status is IngestStatus.WAITING:
        messages.append(
            f"it waits for a declaration: `labbook files show {row.name}` says why, `labbook files reread` it."
        )
    elif not options and would_differ(book, row):
        messages.append(OUTDATED)
    if run not in (None, *runs) and not (done is not None and done.read.refused):
        messages.append(
            f"--run {run} is for new files: `labbook assign {row.name} {run}` gives it one"
            f"{', with --why where it has another' if runs else ''}."
        )
    return done, tuple(messages)


def reread_lines(done: Reread, *, dry_run: bool) -> list[str]:
    """Return lines on another reading: what changed, which reports it bears on, which verdicts wait."""
    if done.read.refused:
        found = [finding for finding in done.read.findings if finding.severity != "note"]
        return ["refused so, and nothing was changed: the reading before stands:", *map(_refusal_line, found)]
    head = "it would be read again" if dry_run else "read again"
    lines = [f"{head}: {'; '.join(done.changes)}."]
    lines += [f"{finding.severity}: {finding.rule}: {finding.message}" for finding in done.read.findings]
    lines += [f"report {one} has numbers that depend on it: `labbook report` makes it anew." for one in done.reports]
    return [*lines, *done.verdicts_waiting]


def _refusal_line(finding: Finding) -> str:
    more = f" and {finding.count - 1} more" if finding.count > 1 else ""
    place = "" if finding.line is None else f" (line {finding.line}{more})"
    return f"{finding.severity}: {finding.rule}{place}: {finding.message}"
