"""Ingesting one file: known already, refused with all its findings, or stored whole.

The file is read once; what is hashed, parsed and kept are the same bytes, whatever happens to the file meanwhile.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import sqlalchemy as sa

from data_schema.errors import InputRefused, unknown_name
from data_schema.journal import canonical
from data_schema.queries.charges import charges_of_run
from data_schema.queries.facts import find_uid
from data_schema.queries.imported_files import runs_of_file
from data_schema.queries.imports import FirstImport, findings_about_runs, first_import, refused_before
from data_schema.queries.runs import list_runs
from data_schema.vocabulary import Action, IngestStatus, Severity
from ingest.model import Finding, Limits, ReadFile, SignalPart
from ingest.read import UNKNOWN, read_file
from labbook.book.desk import Desk, Statement, new_uid
from labbook.book.opening import Book
from labbook.statements.findings import finding_values
from labbook.statements.importing import PreparedImport, declarations, read_and_store
from labbook.statements.ingesting import as_read


@dataclass(frozen=True, slots=True)
class IngestRequest:
    """What was asked for with a file: the run it belongs to, what was declared about it, and whether only to try.

    `batch` is the same for all files that one command takes in, None where it takes one.
    """

    run: str | None = None
    options: Mapping[str, Any] | None = None
    dry_run: bool = False
    person: str | None = None
    batch: str | None = None


@dataclass(frozen=True, slots=True)
class FileOutcome:
    """How the ingest of one file ended."""

    path: str
    sha256: str
    status: IngestStatus
    read: ReadFile | None
    runs: tuple[str, ...]
    first: FirstImport | None
    prepared: PreparedImport | None
    raw_restored: bool = False


def ingest_file_or_refuse(book: Book, path: Path, request: IngestRequest) -> FileOutcome:
    """Ingest one file of a batch: what one file is refused for, or the system refuses, does not end the batch."""
    try:
        return ingest_file(book, path, request)
    except InputRefused as error:
        return FileOutcome(readable(path), "", IngestStatus.REFUSED, _not_read(str(error)), (), None, None)
    except OSError as error:
        return FileOutcome(readable(path), "", IngestStatus.REFUSED, _unreadable(error), (), None, None)


def ingest_file(book: Book, path: Path, request: IngestRequest) -> FileOutcome:
    """Ingest one file; raises only for wrong use, a file that cannot be read comes back refused."""
    try:
        limits = Limits(**book.configuration.files.limits)
        (data, sha256), modified_s = book.store.read_and_hash(path, limits.largest_file_bytes), path.stat().st_mtime
    except OSError as error:
        return FileOutcome(readable(path), "", IngestStatus.REFUSED, _unreadable(error), (), None, None)
    except InputRefused as error:
        return FileOutcome(readable(path), "", IngestStatus.REFUSED, _not_read(str(error)), (), None, None)
    with book.reading() as connection:
        run_uid = _run_uid(connection, request.run)
        first = first_import(connection, sha256)
    if first is not None:
        restored = not request.dry_run and book.store.restore_raw(data, sha256)
        return FileOutcome(readable(path), sha256, IngestStatus.DUPLICATE, None, first.runs, first, None, restored)
    options = dict(request.options or {})
    if request.dry_run:
        read = read_file(data, declarations(book.configuration, options, readable(Path(path.name))))
        if read.refused:
            return FileOutcome(readable(path), sha256, IngestStatus.REFUSED, read, (), None, None)
        with book.reading() as connection:
            runs = _runs_meant(connection, request.run or stated_run(book, path), read)
        return FileOutcome(readable(path), sha256, IngestStatus.IMPORTED, read, runs, None, None)
    prepared = read_and_store(
        book.store, data, sha256, book.configuration, options, file_name=readable(Path(path.name))
    )
    modified_utc = datetime.fromtimestamp(modified_s, UTC).isoformat(timespec="seconds")
    return _stored(book, path, request, prepared, run_uid, options, modified_utc)


def _runs_meant(connection: sa.Connection, of_file: str | None, read: ReadFile) -> tuple[str, ...]:
    """Return the runs of the book that an import would assign: the file's, and those of its charges that lack one."""
    meant = {of_file} if of_file and find_uid(connection, "run", name=of_file) else set()
    for name in {row.stated_run for row in read.charges if row.stated_run}:
        uid = find_uid(connection, "run", name=name)
        if uid and not charges_of_run(connection, uid):
            meant.add(name)
    return tuple(sorted(meant))


def _unreadable(error: OSError) -> ReadFile:
    reason = error.strerror or error
    return _not_read(f"The file cannot be read and kept ({reason}): check that it is there, its permissions, the disk.")


def _not_read(message: str) -> ReadFile:
    finding = Finding(Severity.FILE, "not_readable", message, None, None, None, 1, ())
    return ReadFile(UNKNOWN, 0, (), (), (finding,), 0, 0, 0)


def readable(path: Path) -> str:
    """Return a path as text; bytes of its name that are not UTF-8 are written as `\\xf6`."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


def stated_run(book: Book, path: Path) -> str | None:
    """Return the run that a file's name states, by the pattern in labbook.toml."""
    pattern = book.configuration.files.run_pattern
    found = re.search(pattern, readable(Path(path.name))) if pattern else None
    return found.group("run") if found else None


def _run_uid(connection: Any, name: str | None) -> str | None:
    if name is None:
        return None
    uid = find_uid(connection, "run", name=name)
    if uid is None:
        raise unknown_name(
            "run", name, [run.name for run in list_runs(connection)], "Import its row with `labbook runs import`."
        )
    return uid


def _stored(
    book: Book,
    path: Path,
    request: IngestRequest,
    prepared: PreparedImport,
    run_uid: str | None,
    options: dict[str, Any],
    modified_utc: str,
) -> FileOutcome:
    read, sha256 = prepared.read, prepared.sha256
    new: dict[str, Any] = {
        "sha256": sha256,
        "n_bytes": prepared.n_bytes,
        "original_name": readable(Path(path.name)),
        "modified_utc": modified_utc,
        "options": options,
        "stated_run": stated_run(book, path),
        **({} if request.batch is None else {"batch": request.batch}),
    }
    with book.desk(request.person) as desk:
        first = first_import(desk.connection, sha256)  # another program may have been faster
        if first is not None:
            return FileOutcome(readable(path), sha256, IngestStatus.DUPLICATE, None, first.runs, first, None)
        if read.refused:
            _refuse(desk, new, read)
            return FileOutcome(readable(path), sha256, IngestStatus.REFUSED, read, (), None, None)
        uid = new_uid()
        desk.state(
            Statement(Action.INGEST, "ingest", uid, new={**new, **as_read(prepared), "run": run_uid}, prepared=prepared)
        )
        runs = runs_of_file(desk.connection, sha256)
        read = _with_findings_about_runs(desk, uid, read)
    return FileOutcome(readable(path), sha256, IngestStatus.IMPORTED, read, runs, None, prepared)


def without_samples(outcome: FileOutcome) -> FileOutcome:
    """Let go of a file's samples, which are in the store by now; how many there were is still known."""
    if outcome.read is None:
        return outcome
    read = replace(outcome.read, parts=tuple(_counted(part) for part in outcome.read.parts))
    prepared = None if outcome.prepared is None else replace(outcome.prepared, read=read)
    return replace(outcome, read=read, prepared=prepared)


def _counted(part: SignalPart) -> SignalPart:
    nothing = np.broadcast_to(np.float64(0.0), part.time_s.shape)  # a shape without memory behind it
    channels = tuple(replace(channel, values=nothing) for channel in part.channels)
    return replace(part, time_s=nothing, channels=channels)


def _with_findings_about_runs(desk: Desk, ingest_uid: str, read: ReadFile) -> ReadFile:
    """Add what only the book could tell: a charge that is known, one that contradicts, jumps that were not found."""
    added = tuple(
        Finding(Severity.NOTE, rule, message, None, None, value, 1, ())
        for rule, message, value in findings_about_runs(desk.connection, ingest_uid)
    )
    return replace(read, findings=read.findings + added)


def _refuse(desk: Desk, new: dict[str, Any], read: ReadFile) -> None:
    """Leave one row with the findings, the first time that these bytes are refused for this."""
    if refused_before(desk.connection, new["sha256"], read.format, canonical(new["options"])):
        return
    record = {
        **new,
        "reader": read.format,
        "reader_version": read.reader_version,
        "rows": {"read": read.rows_read, "kept": read.rows_kept, "rejected": read.rows_rejected},
        "findings": [finding_values(finding) for finding in read.findings],
    }
    desk.state(Statement(Action.REFUSE, "ingest", new_uid(), new=record))
