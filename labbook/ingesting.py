"""Ingesting one file: known already, refused with all its findings, or stored whole.

The file is read once; what is hashed, parsed and kept are the same bytes, whatever happens to the file meanwhile.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from data_schema.errors import InputRefused, unknown_name
from data_schema.journal import canonical
from data_schema.queries.facts import find_uid
from data_schema.queries.imports import FirstImport, first_import, refused_before, runs_of_file
from data_schema.queries.runs import list_runs
from data_schema.vocabulary import Action, IngestStatus, Severity
from ingest.model import Finding, ReadFile
from ingest.read import UNKNOWN, read_file
from labbook.book import CONFIGURATION, DATABASE, JOURNAL, Book
from labbook.desk import Desk, Statement, new_uid
from labbook.importing import PreparedImport, declarations, read_and_store, sha256_of
from labbook.statements.ingesting import finding_values


@dataclass(frozen=True, slots=True)
class IngestRequest:
    """What was asked for with a file: the run it belongs to, what was declared about it, and whether only to try."""

    run: str | None = None
    options: Mapping[str, Any] | None = None
    dry_run: bool = False
    person: str | None = None


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


def ingest_file(book: Book, path: Path, request: IngestRequest) -> FileOutcome:
    """Ingest one file; raises only for wrong use, a file that cannot be read comes back refused."""
    try:
        data, modified_s = path.read_bytes(), path.stat().st_mtime
    except OSError as error:
        return FileOutcome(readable(path), "", IngestStatus.REFUSED, _unreadable(error), (), None, None)
    sha256 = sha256_of(data)
    with book.reading() as connection:
        run_uid = _run_uid(connection, request.run)
        first = first_import(connection, sha256)
    if first is not None:
        return FileOutcome(readable(path), sha256, IngestStatus.DUPLICATE, None, first.runs, first, None)
    options = dict(request.options or {})
    if request.dry_run:
        read = read_file(data, declarations(book.configuration, options))
        status = IngestStatus.REFUSED if read.refused else IngestStatus.IMPORTED
        return FileOutcome(readable(path), sha256, status, read, (), None, None)
    prepared = read_and_store(book.store, data, sha256, book.configuration, options)
    modified_utc = datetime.fromtimestamp(modified_s, UTC).isoformat(timespec="seconds")
    return _stored(book, path, request, prepared, run_uid, options, modified_utc)


def files_of(paths: Sequence[Path], book_folder: Path) -> list[Path]:
    """Return the files meant: those named, and all in the folders named, but hidden ones and the book's own."""
    found: list[Path] = []
    for path in paths:
        if not path.exists():
            raise InputRefused(f"{path} does not exist: check the name.")
        if not path.is_dir():
            refuse_special(path)
            found.append(path)
            continue
        inside = sorted(item for item in path.rglob("*") if item.is_file() and not _hidden(item, path))
        found += [item for item in inside if not _the_books_own(item, book_folder)]
    if not found:
        raise InputRefused(
            f"there is no file in {', '.join(map(str, paths))}: name the folder the instruments wrote to."
        )
    return list(dict.fromkeys(found))


def _hidden(path: Path, folder: Path) -> bool:
    return any(part.startswith(".") for part in path.relative_to(folder).parts)


def _the_books_own(path: Path, book_folder: Path) -> bool:
    try:
        first = path.resolve().relative_to(book_folder.resolve()).parts[0]
    except ValueError:
        return False
    return first in ("raw", "signals", "reports", CONFIGURATION, JOURNAL) or first.startswith(DATABASE)


def read_bytes(path: Path) -> bytes:
    """Read a file whole; raises `InputRefused` when it is no regular file."""
    if not path.exists():
        raise InputRefused(f"{path} does not exist: check the name.")
    refuse_special(path)
    return path.read_bytes()


def refuse_special(path: Path) -> None:
    """Raise `InputRefused` for a pipe, a device or a folder, before anything waits for its end."""
    if not path.is_file():
        raise InputRefused(f"{path} is not a regular file: name a file or a folder of files.")


def _unreadable(error: OSError) -> ReadFile:
    message = f"The file cannot be read ({error.strerror}): check its permissions, and that it is still there."
    finding = Finding(Severity.FILE, "file_unreadable", message, None, None, None, 1, ())
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
    }
    with book.desk(request.person) as desk:
        first = first_import(desk.connection, sha256)  # another program may have been faster
        if first is not None:
            return FileOutcome(readable(path), sha256, IngestStatus.DUPLICATE, None, first.runs, first, None)
        if read.refused:
            _refuse(desk, new, read)
            return FileOutcome(readable(path), sha256, IngestStatus.REFUSED, read, (), None, None)
        desk.state(Statement(Action.INGEST, "ingest", new_uid(), new={**new, "run": run_uid}, prepared=prepared))
        runs = runs_of_file(desk.connection, sha256)
    return FileOutcome(readable(path), sha256, IngestStatus.IMPORTED, read, runs, None, prepared)


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
