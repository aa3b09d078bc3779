"""Ingesting one file: known already, refused with all its findings, or stored whole.

The file is read once: the same bytes are hashed, parsed and stored, whatever happens to the file meanwhile.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.queries.charges import charges_of_run
from data_schema.queries.facts import find_uid
from data_schema.queries.files import ABOUT_RUNS, FileRow, FirstImport, first_import, lost_copies, runs_of_file
from data_schema.queries.runs import list_runs, names_beginning
from data_schema.vocabulary import Action, FileRole, IngestStatus, Severity
from ingest.formats.format import UNKNOWN
from ingest.model import Finding, Limits, ReadFile
from ingest.read import read_file
from labbook.actions.files.against_book import (
    name_and_day,
    read_on_day_of,
    refused_by_book,
    refused_without_columns,
    state_refusal,
    with_findings_of_book,
)
from labbook.actions.files.named_files import own_name
from labbook.actions.files.replacing import (
    Beginnings,
    beginnings,
    state_links,
    whole_of,
    withdraw_beginnings,
)
from labbook.actions.files.rereading import take_known, with_declared
from labbook.book.opening import Book
from labbook.book.write_session import Statement, new_uid
from labbook.config.parsing import Configuration
from labbook.config.run_names import RunNames, composed
from labbook.statements.importing import (
    PreparedImport,
    ReadSettings,
    as_read,
    current_settings,
    store_reading,
    without_values,
)
from labbook.statements.ingesting import runs_contradict
from labbook.statements.reading_cache import remember
from labbook.statements.sheet_charges import predicted_findings


@dataclass(frozen=True, slots=True)
class IngestRequest:
    """What was asked for with a file: the run it belongs to, what was declared about it, and whether only to try.

    `batch` is the same for all files that one command takes in, None where it takes one; `again` lets what is declared
    also hold for files of a batch that the book has. `replace_beginnings`: files of the same name that were taken in
    while this one was still being written are withdrawn for it (`replacing`).
    """

    run: str | None = None
    options: Mapping[str, Any] | None = None
    dry_run: bool = False
    person: str | None = None
    batch: str | None = None
    again: bool = False
    replace_beginnings: bool = False


@dataclass(frozen=True, slots=True)
class FileOutcome:
    """How the ingest of one file ended.

    `name` is the file's own, or more of its path where a command takes several of one name. Where the book had its
    bytes, `first` is their first import, and `messages` tell what was done with the declarations given; `changes` lists
    what another reading changed, None where there was none. `of_other_run`: these bytes came before under a name that
    states another run. `replaced` are the uids of files that were withdrawn because this one begins with their bytes.
    `was_lost`: the database was made without these bytes, and must be made anew with them.
    """

    name: str
    sha256: str
    status: IngestStatus
    read: ReadFile | None = None
    runs: tuple[str, ...] = ()
    first: FirstImport | None = None
    prepared: PreparedImport | None = None
    raw_restored: bool = False
    messages: tuple[str, ...] = ()
    changes: tuple[str, ...] | None = None
    of_other_run: bool = False
    replaced: tuple[str, ...] = ()
    was_lost: bool = False


HAS_MORE = "The book has all of it, and more: nothing to add."
"""What is said of a file that one of its name in the book begins with."""
WAS_LOST = "The database was made without it: `labbook rebuild` makes it anew."
"""What is said of a file that waited for its raw copy."""
MADE_ANEW = "The database was made without it, and is made anew with it."
"""What is said of it where that is done at once."""


def ingest_file_or_refuse(book: Book, path: Path, request: IngestRequest) -> FileOutcome:
    """Ingest one file of a batch: what one file is refused for, or the system refuses, does not end the batch."""
    try:
        return ingest_file(book, path, request)
    except (InputRefused, OSError) as error:
        return _not_read(path, error)


def ingest_file(book: Book, path: Path, request: IngestRequest) -> FileOutcome:
    """Ingest one file; raises only for wrong use, a file that cannot be read comes back refused."""
    try:
        limits = Limits(**book.configuration.files.limits)
        (data, sha256), modified_s = book.store.read_and_hash(path, limits.largest_file_bytes), path.stat().st_mtime
    except (InputRefused, OSError) as error:
        return _not_read(path, error)
    if not request.dry_run:
        book.catch_up()
    with book.reading() as connection:
        run_uid = _run_uid(connection, request.run)
        first = first_import(connection, sha256)
        earlier = None
        if request.replace_beginnings:
            whole = whole_of(connection, book.store, own_name(path), data, sha256)
            if whole is not None:
                return _has_more(connection, path, sha256, whole)
            earlier = beginnings(connection, book.store, own_name(path), data, sha256)
    if first is not None:
        restored = not request.dry_run and book.store.restore_raw(data, sha256)
        return _known(book, path, request, first, sha256, restored)
    options, run = dict(request.options or {}), request.run
    if earlier is not None:
        options = with_declared(earlier.options, options)
        if run is None and (link := earlier.run) is not None:
            run, run_uid = link.run_name, link.run_uid
    settings, read, stated = read_for_run(book, data, path, options, run)
    if read.role is FileRole.SHEET and request.run is not None:
        raise UsageError(f"{own_name(path)} is for a study and belongs to no run: leave --run out.")
    stated = () if earlier is not None and earlier.unlinked else stated
    of_run = run or (stated[0] if len(stated) == 1 else None)
    with book.reading() as connection:
        as_is = refused_without_columns(read, options) if request.batch is None else read
        read = refused_by_book(connection, as_is, of_run, notes=request.dry_run)
        if request.dry_run:
            status = IngestStatus.REFUSED if read.refused else IngestStatus.IMPORTED
            runs = () if read.refused else _runs_to_assign(connection, of_run, read)
            if not read.refused and read.charges:
                read = replace(read, findings=(*read.findings, *predicted_findings(connection, read.charges, of_run)))
            if not read.refused and of_run is None:
                read = replace(read, findings=(*read.findings, *runs_contradict(stated, path.name)))
            return FileOutcome(own_name(path), sha256, status, read, runs)
    prepared = store_reading(book.store, data, sha256, read, settings)
    remember(prepared)
    modified_utc = datetime.fromtimestamp(modified_s, UTC).isoformat(timespec="seconds")

    def as_before(connection: sa.Connection) -> bool:
        """Tell whether the book still says of the file what it did when it was read."""
        names = (
            () if earlier is not None and earlier.unlinked else stated_runs(connection, book.configuration, path, read)
        )
        judged = refused_by_book(connection, as_is, of_run)
        by_day = settings.declared.day
        if by_day is not None:
            of_day = find_uid(connection, "run", name=of_run)
            if of_day is None or name_and_day(connection, of_day)[1] != by_day:
                return False
        of = run_uid if request.run is None else _run_uid(connection, request.run)
        return (of, names, judged.findings) == (run_uid, stated, read.findings)

    stored = _stored(book, path, request, data, prepared, run_uid, stated, options, modified_utc, earlier, as_before)
    return ingest_file(book, path, request) if stored is None else stored


def _has_more(connection: sa.Connection, path: Path, sha256: str, whole: FileRow) -> FileOutcome:
    """Say that the book has more of a file than there is now, as while it is copied a second time."""
    first = first_import(connection, whole.sha256)
    assert first is not None  # noqa: S101 - it is in use
    return FileOutcome(own_name(path), sha256, IngestStatus.DUPLICATE, None, first.runs, first, messages=(HAS_MORE,))


def _known(
    book: Book, path: Path, request: IngestRequest, first: FirstImport, sha256: str, restored: bool
) -> FileOutcome:
    """Say what became of bytes that the book has."""
    with book.reading() as connection:
        was_lost = bool(lost_copies(connection, sha256))
    if was_lost:
        outcome = FileOutcome(own_name(path), sha256, IngestStatus.DUPLICATE, runs=first.runs, first=first)
        declared = ("what is declared is not heeded before that.",) if request.options or request.run else ()
        return replace(outcome, raw_restored=restored, messages=(WAS_LOST, *declared), was_lost=True)
    reread, messages = take_known(
        book,
        sha256,
        request.options or {},
        request.run,
        again=request.again,
        person=request.person,
        dry_run=request.dry_run,
        batch=request.batch,
    )
    with book.reading() as connection:
        runs = runs_of_file(connection, sha256)
        stated, before = (
            named_run(connection, book.configuration, name) for name in (own_name(path), first.original_name)
        )
    copied = bool(runs) and stated not in (None, *runs, before)
    if copied:
        messages = (
            f"Its name says run {stated}: one of the two is a copy of the other; take in that run's own log, or, if "
            f"this is it, `labbook assign {shlex.quote(first.original_name)} {stated} --why ...`.",
            *messages,
        )
    outcome = FileOutcome(
        own_name(path),
        sha256,
        IngestStatus.DUPLICATE,
        runs=runs,
        first=first,
        raw_restored=restored,
        messages=messages,
        of_other_run=copied,
    )
    if reread is None:
        return outcome
    if reread.read.refused:
        return replace(outcome, status=IngestStatus.REFUSED, read=reread.read)
    prepared = None if request.dry_run else reread.prepared
    return replace(outcome, changes=reread.changes, read=reread.read, prepared=prepared)


def _runs_to_assign(connection: sa.Connection, of_file: str | None, read: ReadFile) -> tuple[str, ...]:
    """Return the runs of the book that an import would assign: the file's, and those of its charges that lack one."""
    meant = {of_file} if of_file and find_uid(connection, "run", name=of_file) else set()
    for name in {row.stated_run for row in read.charges if row.stated_run}:
        uid = find_uid(connection, "run", name=name)
        if uid and not charges_of_run(connection, uid):
            meant.add(name)
    return tuple(sorted(meant))


def _not_read(path: Path, error: InputRefused | OSError) -> FileOutcome:
    message = str(error)
    if isinstance(error, OSError):
        why = error.strerror or error
        message = f"The file cannot be read and kept ({why}): check that it is there, its permissions, the disk."
    finding = Finding(Severity.FILE, "not_readable", message, None, None, None, 1, ())
    read = ReadFile(format=UNKNOWN, reader_version=0, findings=(finding,))
    return FileOutcome(own_name(path), "", IngestStatus.REFUSED, read)


def read_for_run(
    book: Book, data: bytes, path: Path, options: Mapping[str, Any], run: str | None
) -> tuple[ReadSettings, ReadFile, tuple[str, ...]]:
    """Read bytes as the log of a run, of the one named or else of the one that the file says; return the latter, too.

    The run's date is that of a log without one, by which its sensor's calibration is chosen.
    """
    settings = current_settings(book.configuration, options, own_name(path))
    read = read_file(data, settings.declared)
    with book.reading() as connection:
        stated = stated_runs(connection, book.configuration, path, read)
    of_run = run or (stated[0] if len(stated) == 1 else None)
    settings, read = read_on_day_of(book, data, settings, read, of_run)
    return settings, read, stated


def stated_runs(connection: sa.Connection, configuration: Configuration, path: Path, read: ReadFile) -> tuple[str, ...]:
    """Return the runs that a file says it is of: by its name, and by the lines above its table.

    One that both say is returned once; where the lines name several, they say nothing. A sheet of recharges names its
    runs row by row, and the sheet of a study none.
    """
    if read.role is FileRole.SHEET:
        return ()
    by_name = named_run(connection, configuration, own_name(path))
    named = {run for word in read.named_runs if (run := _run_of_word(connection, configuration, word)) is not None}
    above = named.pop() if len(named) == 1 and read.parts else None
    return tuple(dict.fromkeys(run for run in (by_name, above) if run is not None))


def named_run(connection: sa.Connection, configuration: Configuration, name: str) -> str | None:
    """Return the run that a file's name states: one of the book or of a plan, or by the scheme of labbook.toml."""
    name = composed(name)
    return RunNames(configuration.study.run_names).stated_in(name, names_beginning(connection, name))


def _run_of_word(connection: sa.Connection, configuration: Configuration, word: str) -> str | None:
    """Return the run that a word is the name of: one that the book has, or one that could name a file."""
    word = composed(word)
    if find_uid(connection, "run", name=word) is not None or named_run(connection, configuration, word) == word:
        return word
    return None


def _run_uid(connection: Any, name: str | None) -> str | None:
    if name is None:
        return None
    uid = find_uid(connection, "run", name=composed(name))
    if uid is None:
        raise unknown_name(
            "run", name, [run.name for run in list_runs(connection)], "Import its row with `labbook runs import`."
        )
    return uid


def _stored(
    book: Book,
    path: Path,
    request: IngestRequest,
    data: bytes,
    prepared: PreparedImport,
    run_uid: str | None,
    stated: tuple[str, ...],
    options: dict[str, Any],
    modified_utc: str,
    earlier: Beginnings | None,
    as_before: Callable[[sa.Connection], bool],
) -> FileOutcome | None:
    """State what was read, all or nothing; None where others stated what it was checked against, or is to replace."""
    read, sha256 = prepared.read, prepared.sha256
    new: dict[str, Any] = {
        "sha256": sha256,
        "n_bytes": prepared.n_bytes,
        "original_name": own_name(path),
        "modified_utc": modified_utc,
        "options": options,
        "stated_run": stated[0] if len(stated) == 1 else None,
        **({"stated_runs": list(stated)} if len(stated) > 1 and run_uid is None else {}),
        **({} if request.batch is None else {"batch": request.batch}),
    }
    with book.session(request.person) as session:
        first = first_import(session.connection, sha256)  # another program may have been faster
        if first is not None:
            return FileOutcome(own_name(path), sha256, IngestStatus.DUPLICATE, None, first.runs, first)
        if not as_before(session.connection):
            return None
        if read.refused:
            state_refusal(session, new, prepared)
            return FileOutcome(own_name(path), sha256, IngestStatus.REFUSED, read)
        replaced: tuple[str, ...] = ()
        messages: tuple[str, ...] = ()
        if request.replace_beginnings:
            now = beginnings(session.connection, book.store, own_name(path), data, sha256)
            if now != earlier:  # another program was faster, or one that was killed had stated it
                return None
        if earlier is not None:
            replaced, messages = withdraw_beginnings(session, earlier, sha256, read.charges)
        uid = new_uid()
        session.state(
            Statement(Action.INGEST, "ingest", uid, new={**new, **as_read(prepared), "run": run_uid}, prepared=prepared)
        )
        if earlier is not None and request.run is None:
            state_links(session, earlier, sha256, [part.part for part in read.parts])
        runs = runs_of_file(session.connection, sha256)
        read = with_findings_of_book(session.connection, uid, read, ABOUT_RUNS)
    return FileOutcome(
        own_name(path),
        sha256,
        IngestStatus.IMPORTED,
        read,
        runs,
        prepared=prepared,
        messages=messages,
        replaced=replaced,
    )


def without_samples(outcome: FileOutcome) -> FileOutcome:
    """Let go of a file's samples, which are in the store by now; how many there were is still known."""
    if outcome.read is None:
        return outcome
    read = without_values(outcome.read)
    prepared = None if outcome.prepared is None else replace(outcome.prepared, read=read)
    return replace(outcome, read=read, prepared=prepared)
