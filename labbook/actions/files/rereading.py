"""Reading a kept file again: with what is declared about it now, what that changes, and what becomes stale."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.journal import canonical
from data_schema.queries.detections import verdicts_waiting
from data_schema.queries.imported_files import runs_of_file
from data_schema.queries.imports import ABOUT_RUNS, findings_of, refused_with
from data_schema.queries.readings import ReadingRow, last_reading
from data_schema.vocabulary import Action, IngestStatus, Severity
from ingest.model import DEFAULT_LIMITS, Finding, ReadFile
from ingest.read import read_file
from ingest.store import raw_path
from labbook.actions.files.absent_columns import refused_without_columns
from labbook.actions.files.day_of_run import with_day_of_run
from labbook.actions.files.reading_changes import Gave, changes
from labbook.book.opening import Book
from labbook.book.write_session import DryRun, Statement, WriteSession, new_uid
from labbook.config.parsing import Configuration, parse_configuration
from labbook.statements.importing import (
    PreparedImport,
    ReadSettings,
    as_read,
    finding_values,
    read_and_store,
    read_only,
    resolved,
    settings_now,
    without_name,
)
from labbook.statements.sheet_charges import charge_numbers, keys_in


@dataclass(frozen=True, slots=True)
class Reread:
    """What came of reading a file again.

    `read` holds what was found, findings about runs included; where it was refused, nothing else is said and the
    reading before stands. `changes` say in words what is otherwise now, `waiting` which verdicts wait for a person.
    """

    name: str
    sha256: str
    read: ReadFile
    prepared: PreparedImport
    runs: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()
    stale: tuple[tuple[str, str], ...] = ()
    waiting: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class RereadRequest:
    """Who has a file read again and why, what is declared about it, and whether only to see what would change."""

    options: Mapping[str, Any]
    person: str | None = None
    why: str | None = None
    dry_run: bool = False
    batch: str | None = None


def reread(book: Book, row: ReadingRow, request: RereadRequest) -> Reread:
    """Read the kept copy of a file under today's labbook.toml and the options given; a refusal changes nothing."""
    data = book.store.raw(raw_path(row.sha256), row.sha256)
    settings = settings_now(book.configuration, request.options, row.name)

    def judged(read: ReadFile) -> ReadFile:
        if request.batch is None and canonical(dict(request.options)) != row.options_json:
            read = refused_without_columns(read, request.options)
        with book.reading() as connection:
            return with_day_of_run(connection, read, row.stated_run, file_uid=row.file_uid)

    if request.dry_run:
        prepared = read_only(data, row.sha256, settings, judged)
    else:
        prepared = read_and_store(book.store, data, row.sha256, settings, judged=judged)
    done = Reread(row.name, row.sha256, prepared.read, prepared)
    try:
        with book.session(request.person) as session:
            if prepared.read.refused:
                if not request.dry_run:
                    state_refusal(session, _entry(row, request), prepared)
                return done
            done = _state(session, row, request, prepared)
            if request.dry_run:
                raise DryRun
    except DryRun:
        pass
    return done


def would_differ(book: Book, row: ReadingRow) -> bool:
    """Tell whether today's labbook.toml would have a file read otherwise, the same being declared about it.

    The file is read only where the configuration is another one than at its reading.
    """
    then, now = _settings(_configuration(row.config_text), row), _settings(book.configuration, row)
    if _how(then) == _how(now):
        return False
    read = read_file(book.store.raw(raw_path(row.sha256), row.sha256), now.declared)
    return _how(settings_of(book, row)) != _how(resolved(now, read))


def _how(settings: ReadSettings) -> ReadSettings:
    """Leave out what decides only whether a file is refused: the robots it is compared with, and limits."""
    return replace(settings, declared=replace(settings.declared, robots=(), limits=DEFAULT_LIMITS))


def settings_of(book: Book, row: ReadingRow) -> ReadSettings:
    """Return all that a reading depended on; an earlier labbook did not write it down, so that it is found again."""
    if row.settings_json is not None:
        return ReadSettings.from_json(json.loads(row.settings_json))
    settings = _settings(_configuration(row.config_text), row)
    return resolved(settings, read_file(book.store.raw(raw_path(row.sha256), row.sha256), settings.declared))


def _settings(configuration: Configuration, row: ReadingRow) -> ReadSettings:
    return settings_now(configuration, json.loads(row.options_json), row.name)


@functools.lru_cache(maxsize=64)
def _configuration(text: str) -> Configuration:
    return parse_configuration(text, "the book's configuration")


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
    return replace(read, findings=read.findings + added)


def _entry(row: ReadingRow, request: RereadRequest) -> dict[str, Any]:
    return {
        "sha256": row.sha256,
        "original_name": row.name,
        "modified_utc": row.modified_utc,
        "options": dict(request.options),
        "stated_run": row.stated_run,
        **({} if request.batch is None else {"batch": request.batch}),
    }


def _state(session: WriteSession, row: ReadingRow, request: RereadRequest, prepared: PreparedImport) -> Reread:
    connection = session.connection
    before = last_reading(connection, row.sha256) or row  # another program may have been faster
    if before.status is IngestStatus.WITHDRAWN:
        raise UsageError(
            f"{row.name} was withdrawn meanwhile: take it into use with `labbook files restore {row.name}`, then have "
            "it read again."
        )
    old = Gave.of(connection, before)
    waited = set(verdicts_waiting(connection))
    uid = new_uid()
    new = {**_entry(before, request), **as_read(prepared)}
    if keys := keys_in(new):
        numbers = charge_numbers(connection, before.file_uid or "", new, keys)
        new["charge_numbers"] = [numbers[key] for key in keys]
    session.state(Statement(Action.READ, "ingest", uid, new=new, reason=request.why, prepared=prepared))
    after = last_reading(connection, row.sha256)
    assert after is not None  # noqa: S101 - it was stated just now
    return Reread(
        row.name,
        row.sha256,
        with_findings_of_book(connection, uid, prepared.read, ABOUT_RUNS),
        prepared,
        runs_of_file(connection, row.sha256),
        tuple(changes(old, Gave.of(connection, after))),
        tuple(session.stale),
        tuple(item.sentence for item in verdicts_waiting(connection) if item not in waited),
    )
