"""`labbook report`: from the book to one page."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, WhereOption, opened, options_given, say_waiting
from labbook.terminal import Shown, listed, progress


def report(
    context: typer.Context,
    where: WhereOption = None,
    out: Annotated[str | None, typer.Option(metavar="DIR", help="Where to write it.")] = None,
    figures: Annotated[
        bool,
        typer.Option("--figures", help="Also write each figure as PDF, and for both widths of a paper."),
    ] = False,
    unsaved: Annotated[
        bool, typer.Option("--unsaved", help="Store nothing in the book, for who may only read it; needs --out.")
    ] = False,
    summary: Annotated[bool, typer.Option("--summary", help="Write page one alone, too: one sheet to send.")] = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Print it to a PDF on A4 as well, by Chromium where it is installed.")
    ] = False,
    docx: Annotated[bool, typer.Option("--docx", help="Write the tables as a Word document, too.")] = False,
    template: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Your own page: templates beside labbook's (docs/own-page.md).")
    ] = None,
    as_of: Annotated[
        str | None,
        typer.Option(
            metavar="ENTRY|TIME", help="Of the book as it stood then; of a date, its end. Stores nothing, needs --out."
        ),
    ] = None,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Write the report: one self-contained page, its figures as SVG, every table as CSV and LaTeX.

    Every factor of the study is an option: --foot small is short for --where "foot=small".

    Example: labbook report --foot small; labbook report --where "k_gain=400 and day>=2021-06-01" --out paper;
    labbook report --summary --pdf
    """
    from data_schema.queries.files import inbox
    from labbook.actions.report_command import selection, write
    from labbook.studies.registry import studies_of_book

    with opened(book) as opened_book:
        folder = _folder(out)
        if unsaved:
            say_waiting(opened_book)
        text = selection(opened_book.configuration, where, context.args, options_given(context))
        with progress("report", None) as step:
            written = write(
                opened_book,
                text,
                folder,
                person,
                step,
                unsaved=unsaved,
                summary=summary,
                pdf=pdf,
                every_figure=figures,
                word=docx,
                templates=template,
                as_of=as_of,
            )
        waiting: list[str] = []
        studies: list[str] = []
        if as_of is None:
            with opened_book.reading() as connection:
                waiting = [item.name for item in inbox(connection)]
                # the bed's is the report itself
                studies = [study for study in studies_of_book(connection, opened_book.configuration) if study != "bed"]
    not_stored = ["nothing was stored: `labbook why` knows those of its numbers that a stored report has too."]
    return Shown(
        written,
        [
            *(written.claims[:1] or ["nothing is claimed from this selection."]),
            *(not_stored if unsaved or as_of is not None else ()),
            *([_later(written.as_of, written.later)] if written.later else []),
            f"{written.page}",
            *([written.pdf] if written.pdf else []),
            *([f"studies beside it: {', '.join(studies)} (`labbook study all`)"] if studies else []),
            *([f"look again: {written.no_pdf}"] if written.no_pdf else []),
            *(
                [f"look again: {listed(waiting, 4)} in the inbox, which `labbook runs inbox` explains"]
                if waiting
                else []
            ),
        ],
    )


def _later(as_of: int, later: int) -> str:
    count = "1 entry" if later == 1 else f"{later} entries"
    return f"it is of the book as of entry {as_of}; {count} came in while it was made: the next report has them."


def _folder(out: str | None) -> Path | None:
    """Return the folder that is named; raises `UsageError` for an empty name, which would be where one stands."""
    from data_schema.errors import UsageError

    if out is not None and not out.strip():
        raise UsageError("--out names no folder: give one, such as --out paper, or . for the folder where you are.")
    return None if out is None else Path(out)
