"""`labbook ingest` on bytes that the book has: nothing, another reading, or the run that they belong to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from data_schema.journal import canonical
from data_schema.queries.imported_files import links_of_file, runs_of_file
from data_schema.queries.readings import ReadingRow, last_reading, said_last
from data_schema.vocabulary import Action, IngestStatus
from ingest.model import Finding
from labbook.actions.files.rereading import Reread, RereadRequest, reread, would_differ
from labbook.actions.runs.remarks import remark_lines, remarks_on
from labbook.actions.runs.second_charge import refuse_second_of_file
from labbook.actions.upkeep.stale import stale_lines
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.write_session import Statement


@dataclass(frozen=True, slots=True)
class KnownFile:
    """What became of bytes that the book has: another reading, where one was asked for, and lines that say it."""

    again: Reread | None = None
    said: tuple[str, ...] = ()


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
) -> KnownFile:
    """Read the kept copy again where other things are declared about it, and give it a run where it has none.

    Nothing declared changes nothing. In a batch (`batch` is not None) options are for new files, but with `again`.
    """
    with book.reading() as connection:
        row = last_reading(connection, sha256)
        assert row is not None  # noqa: S101 - only known bytes come here
        assert row.file_uid is not None  # noqa: S101
        withdrawn = said_last(connection, row.file_uid, [Action.WITHDRAW])
    if row.status is IngestStatus.WITHDRAWN:
        by = "" if withdrawn is None else f" by {withdrawn.person} on {withdrawn.at_utc}: {withdrawn.reason}"
        return KnownFile(None, (f"withdrawn{by}; `labbook files restore {row.name}` takes it into use again.",))
    declared_otherwise = bool(options) and canonical(dict(options)) != row.options_json
    done, said = None, []
    if declared_otherwise and batch is not None and not again:
        said.append("what is declared is for new files: add --again, or `labbook files reread` it.")
    elif declared_otherwise:
        done = reread(book, row, RereadRequest(options, person, None, dry_run, batch))
        said += reread_lines(done, dry_run=dry_run)
    elif row.status is IngestStatus.WAITING:
        said.append(f"it waits for a declaration: `labbook files show {row.name}` says why, `labbook files reread` it.")
    elif not options and would_differ(book, row):
        said.append(f"labbook.toml would have it read otherwise now: `labbook files reread {row.name}` does.")
    if run is not None and not (done is not None and done.read.refused):
        said += _to_run(book, row, run, person, dry_run)
    return KnownFile(done, tuple(said))


def reread_lines(done: Reread, *, dry_run: bool) -> list[str]:
    """Say what came of another reading: what is otherwise, what became stale, which verdicts wait."""
    if done.read.refused:
        found = [finding for finding in done.read.findings if finding.severity != "note"]
        return ["refused so, and nothing was changed: the reading before stands:", *map(_refusal_line, found)]
    head = "it would be read again" if dry_run else "read again"
    lines = [f"{head}: {'; '.join(done.changes)}."]
    lines += [f"{finding.severity}: {finding.rule}: {finding.message}" for finding in done.read.findings]
    lines += stale_lines(list(done.stale)) if done.stale else []
    return [*lines, *done.waiting]


def _refusal_line(finding: Finding) -> str:
    more = f" and {finding.count - 1} more" if finding.count > 1 else ""
    place = "" if finding.line is None else f" (line {finding.line}{more})"
    return f"{finding.severity}: {finding.rule}{place}: {finding.message}"


def _to_run(book: Book, row: ReadingRow, run: str, person: str | None, dry_run: bool) -> list[str]:
    """Let a file that belongs to no run belong to this one; a file that has a run is moved by another command."""
    with book.reading() as connection:
        meant = run_named(connection, run)
        runs = runs_of_file(connection, row.sha256)
        links = links_of_file(connection, row.file_uid or "")
    if run in runs:
        return []
    if runs or links:
        move = f"`labbook assign {row.name} {run} --why ...` moves it"
        return [f"--run {run} was not heeded, for the file belongs to run {', '.join(runs)}: {move}."]
    if dry_run:
        with book.reading() as connection:
            refuse_second_of_file(connection, row.file_uid or "", row.role, meant)
        return [f"it would belong to run {run}."]
    with book.session(person) as session:
        refuse_second_of_file(session.connection, row.file_uid or "", row.role, meant)
        new = {"run": meant.uid, "role": row.role}
        session.state(Statement(Action.ASSIGN, "file", row.file_uid or "", new=new))
        remarks = remarks_on(session.connection, book.configuration, [run], ["log"])
    return [f"it belongs to run {run} now.", *remark_lines(remarks)]
