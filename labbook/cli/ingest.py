"""`labbook ingest`: take instruments' files into the book."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, asking, emit, progress


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("ingest")(ingest)


def ingest(
    paths: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Files, or folders of files.")],
    run: Annotated[str | None, typer.Option("--run", help="The run that the file belongs to.")] = None,
    rate: Annotated[float | None, typer.Option("--rate", help="Samples a second, where the file has no time.")] = None,
    unit: Annotated[
        list[str] | None, typer.Option("--unit", metavar="COLUMN=UNIT", help="A column's unit, for example time=ms.")
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            "--column",
            metavar="COLUMN=CHANNEL[:UNIT]",
            help='What a column holds: "h=body_height:mm" (`labbook channels`), or "i=own.coil_current:A".',
        ),
    ] = None,
    encoding: Annotated[str | None, typer.Option("--encoding", help="The page of text that is not UTF-8.")] = None,
    decimal: Annotated[str | None, typer.Option("--decimal", help="The decimal sign, . or ,")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Read and check; store nothing.")] = False,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Ingest files: a byte-exact copy, its samples and charges, and everything that the checks found.

    The same bytes again change nothing. A refused file stores nothing but its findings; then the exit code is 2.

    Example: labbook ingest logs/ charges.csv; labbook ingest r007.csv --run r007
    """
    from labbook.actions.declaring import ask_for, declared_options
    from labbook.actions.files_meant import files_of
    from labbook.actions.ingesting import (
        FileOutcome,
        IngestRequest,
        ingest_file,
        ingest_file_or_refuse,
        without_samples,
    )
    from labbook.book.desk import new_uid
    from labbook.book.opening import opened
    from labbook.cli.ingest_lines import outcome_json, outcome_lines, rig_lines_of, summary_line

    options = declared_options(rate, unit or [], column or [], encoding, decimal)
    outcomes: list[FileOutcome] = []
    with opened(book) as opened_book:
        if not dry_run:
            opened_book.speaker(person)
        files = files_of(paths, opened_book.folder)
        many = len(files) > 1
        take = ingest_file_or_refuse if many else ingest_file
        batch = new_uid() if many else None
        try:
            # on a terminal the lines themselves show how far it is
            with progress("ingesting", len(files), shown=many and (as_json or not sys.stdout.isatty())) as step:
                for path in files:
                    outcome = take(opened_book, path, IngestRequest(run, options, dry_run, person, batch))
                    if asking() and not as_json and not many:
                        said = ask_for(outcome, options)
                        if said is not None:
                            outcome = take(opened_book, path, IngestRequest(run, said, dry_run, person))
                    outcomes.append(without_samples(outcome))
                    if not as_json:
                        emit(None, outcome_lines(outcome, run), as_json=False)
                    step(path.name)
            rig = rig_lines_of(opened_book, outcomes)
            if not as_json:
                emit(None, [f"  {line}" for of_file in rig for line in of_file], as_json=False)
        finally:
            if outcomes and not as_json:
                emit(None, [summary_line(outcomes, dry_run)], as_json=False)
    if as_json:
        emit([outcome_json(*both) for both in zip(outcomes, rig, strict=True)], [], as_json=True)
    if any(outcome.status == "refused" for outcome in outcomes):
        raise typer.Exit(2)
