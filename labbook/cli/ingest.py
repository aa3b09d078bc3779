"""`labbook ingest`: take instruments' files into the book."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from labbook.book.opening import Book

from data_schema.errors import BookError
from data_schema.vocabulary import IngestStatus
from labbook.cli.common import AsOption, BookOption, opened
from labbook.cli.declaring import Declared
from labbook.terminal import Shown, asking, emit, for_program, progress, say


def ingest(
    paths: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Files, or folders of files.")],
    run: Annotated[str | None, typer.Option(help="The run that the file belongs to.")] = None,
    *,
    declared: Declared,
    explain: Annotated[
        bool, typer.Option("--explain", help="Say how each file would be read, and why; store nothing.")
    ] = False,
    draft_profile: Annotated[
        bool, typer.Option("--draft-profile", help="Print the [profiles.NAME] of a file, to be corrected.")
    ] = False,
    again: Annotated[
        bool, typer.Option("--again", help="In a folder: what is declared also holds for files that the book has.")
    ] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Read and check; store nothing.")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", help="Of many files, list also those in order.")] = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Ingest files: a byte-exact copy, its samples and charges, and everything that the checks found.

    The same bytes again change nothing, unless other things are declared about them: then the kept copy is read again,
    with all that is declared now; a copy that the book had lost is there again. A refused file stores nothing but its
    findings; then the exit code is 2, also of --explain and --dry-run.
    Of many files the sum comes first, then what needs attention, worst first, then the rest.

    Example: labbook ingest logs/ charges.csv; labbook ingest r007.csv --run r007; labbook ingest odd.txt --explain
    """
    from ingest.formats.registry import plugins
    from labbook.actions.files.explaining import draft_profile as draft
    from labbook.actions.files.ingesting import (
        MADE_ANEW,
        FileOutcome,
        IngestRequest,
        ingest_file,
        ingest_file_or_refuse,
        without_samples,
    )
    from labbook.actions.files.named_files import files_of
    from labbook.actions.runs.rig_line import missing_heights, rig_lines_of
    from labbook.book.write_session import new_uid
    from labbook.cli.file_options import ask_for, declared_options
    from labbook.cli.ingest_lines import Taken, batch_lines, taken_json

    options = declared_options(declared)
    for fault in plugins().faults:
        say(fault, err=True)
    if explain or draft_profile:
        with opened(book) as opened_book:
            meant = files_of(paths, opened_book.folder)
            files = meant.files
            if meant.skipped:
                say(meant.skipped_line, err=True)
            if draft_profile:
                drafts = [draft(opened_book, path, options) for path in files]
                return Shown(drafts, [line for each in drafts for line in each.toml.splitlines()])
            return _explain(opened_book, meant.names, options, run)
    outcomes: list[FileOutcome] = []
    taken: list[Taken] = []
    rebuilt: list[str] = []
    with opened(book) as opened_book:
        if not dry_run:
            opened_book.speaker(person)
        meant = files_of(paths, opened_book.folder)
        files = meant.files
        many = len(files) > 1
        take = ingest_file_or_refuse if many else ingest_file
        batch = new_uid() if many else None
        request = IngestRequest(run, options, dry_run, person, batch, again)
        try:
            with progress("ingesting", len(files), shown=many) as step:
                for path in files:
                    outcome = take(opened_book, path, request)
                    if asking() and not many:
                        answered = ask_for(outcome, options)
                        if answered is not None:
                            request = replace(request, options=answered)
                            outcome = take(opened_book, path, request)
                    outcomes.append(replace(without_samples(outcome), name=meant.names[path]))
                    step(path.name)
            if not dry_run and any(outcome.was_lost for outcome in outcomes):
                rebuilt = _rebuilt_with_lost(opened_book)
                for place, (path, lost) in enumerate(zip(files, outcomes, strict=True)):
                    if lost.was_lost:  # its rows are there now, and what is declared about it can be heeded
                        known = without_samples(take(opened_book, path, request))
                        said = (MADE_ANEW, *known.messages)
                        outcomes[place] = replace(known, name=lost.name, raw_restored=lost.raw_restored, messages=said)
            taken = [*map(Taken, outcomes, rig_lines_of(opened_book, outcomes), missing_heights(opened_book, outcomes))]
        except BookError as error:
            if not many:
                raise
            raise type(error)(
                f"{error} Then give all of these files again: those that are there stay as they are."
            ) from error
        finally:  # finished files are printed, also where Ctrl-C or a full disk stopped the others
            if outcomes and not for_program():
                told = taken or [*map(Taken, outcomes)]
                lines = batch_lines(told, run, meant.skipped_line, dry_run=dry_run, verbose=verbose)
                emit(None, [*lines, *rebuilt], as_json=False)
    if for_program() and meant.skipped:
        say(meant.skipped_line, err=True)
    for line in rebuilt if for_program() else ():
        say(line, err=True)
    data = [*map(taken_json, taken)] if for_program() else None
    return Shown(data, (), 2 if any(outcome.status is IngestStatus.REFUSED for outcome in outcomes) else 0)


def _rebuilt_with_lost(book: "Book") -> list[str]:
    """Make the database anew with raw copies that it was made without; return what is said of that.

    Raises `BookDamaged`, and changes nothing, where a copy cannot be read that the database was made with.
    """
    from data_schema.queries.files import lost_copies
    from labbook.book.rebuilding import rebuild_database
    from labbook.cli.book import rebuilt_lines

    with book.reading() as connection:
        lost = lost_copies(connection)
    with progress("rebuilding", None) as step:
        return rebuilt_lines(rebuild_database(book.folder, step, may_lack=lost))


def _explain(book: "Book", names: dict[Path, str], options: dict[str, Any], run: str | None) -> Shown:
    """Print how files would be read."""
    from labbook.actions.files.explaining import explain_file
    from labbook.cli.ingest_lines import explained_lines

    explained = [
        replace(explain_file(book, path, options, run, alone=len(names) == 1), file=name)
        for path, name in names.items()
    ]
    return Shown(
        explained,
        [line for each in explained for line in explained_lines(each)],
        2 if any(each.refused for each in explained) else 0,
    )
