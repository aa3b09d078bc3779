"""`labbook ingest`: take instruments' files into the book."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

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
        typer.Option("--column", metavar="COLUMN=CHANNEL[:UNIT]", help='What a column holds: "h=body_height:mm".'),
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
    from labbook.book import opened
    from labbook.cli.ingest_lines import outcome_json, outcome_lines, summary_line
    from labbook.declaring import ask_for, declared_options
    from labbook.ingesting import (
        FileOutcome,
        IngestRequest,
        files_of,
        ingest_file,
    )

    options = declared_options(rate, unit or [], column or [], encoding, decimal)
    outcomes: list[tuple[FileOutcome, list[str]]] = []
    with opened(book) as opened_book:
        if not dry_run:
            opened_book.speaker(person)
        files = files_of(paths, opened_book.folder)
        many = len(files) > 1 and not as_json
        with finished_first(outcomes, shown=many), progress("ingesting", len(files), shown=many) as step:
            for path in files:
                request = IngestRequest(run, options, dry_run, person)
                outcome = ingest_file(opened_book, path, request)
                if asking() and not as_json and len(files) == 1:
                    said = ask_for(outcome, options)
                    if said is not None:
                        outcome = ingest_file(opened_book, path, IngestRequest(run, said, dry_run, person))
                outcomes.append((outcome, outcome_lines(opened_book, outcome)))
                step(path.name)
    lines = [line for _outcome, of_file in outcomes for line in of_file]
    lines.append(summary_line([outcome for outcome, _lines in outcomes], dry_run))
    emit([outcome_json(outcome) for outcome, _lines in outcomes], lines, as_json)
    if any(outcome.status == "refused" for outcome, _lines in outcomes):
        raise typer.Exit(2)


@contextlib.contextmanager
def finished_first(outcomes: list[tuple[Any, list[str]]], shown: bool) -> Iterator[None]:
    """Where work ends before its end, say first what was finished."""
    try:
        yield
    except BaseException:
        emit(None, [line for _outcome, of_file in outcomes if shown for line in of_file], as_json=False)
        raise
