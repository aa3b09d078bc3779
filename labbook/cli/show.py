"""`labbook show`: everything the book knows of a run."""

from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, emit


def show(
    run: Annotated[str, typer.Argument(help="The run.")], book: BookOption = None, as_json: JsonOption = False
) -> None:
    """Show a run: facts, files with channels and gaps, charges, notes, and what was stated about it.

    Example: labbook show r017
    """
    from labbook.actions.runs.run_view import run_view, view_lines
    from labbook.analysis.outcomes.detection import Detections
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.reading() as connection:
        found = run_view(Detections(connection, opened_book.store), opened_book.configuration, run)
    emit(found, view_lines(found), as_json)
