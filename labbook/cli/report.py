"""`labbook report`: from the book to one page."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, WhereOption, emit, progress


def register(app: typer.Typer) -> None:
    """Add the command; it takes the study's own factors as options, which only the book knows."""
    app.command("report", context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(report)


def report(
    context: typer.Context,
    where: WhereOption = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Where to write it.")] = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write the report: one self-contained page, every figure as SVG and PDF, every table as CSV and LaTeX.

    Every factor of the study is an option: --foot small is short for --where "foot=small".

    Example: labbook report --foot small; labbook report --where "k_gain=400 and day>=2021-06-01" --out paper
    """
    from labbook.actions.report_command import selection, write
    from labbook.book.opening import opened

    with opened(book) as opened_book:
        text = selection(opened_book.configuration, where, context.args)
        with progress("report", None, shown=not as_json) as step:
            written = write(opened_book, text, out, person, step)
    emit(
        written,
        [
            *written.claims[:1],
            f"{written.results_computed} results computed, {written.results_reused} reused.",
            f"{written.page}",
        ],
        as_json,
    )
