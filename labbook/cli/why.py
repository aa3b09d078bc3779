"""`labbook why`: where a number came from."""

from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, emit


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("why")(why)


def why(
    number: Annotated[str, typer.Argument(help="The provenance id beside a number in a report, or its beginning.")],
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """Trace a number to the algorithm, the facts and the bytes it rests on.

    A number printed by an earlier labbook, which a rebuild computes anew under another id, is told as it was printed.

    Example: labbook why 3fa9c2d1
    """
    from labbook.actions.tracing import trace, trace_lines
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.reading() as connection:
        found = trace(connection, number)
    emit(found, trace_lines(found), as_json)
