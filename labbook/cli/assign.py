"""`labbook assign`: a file, or a row of a charger sheet, belongs to a run."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("assign")(assign)


def assign(
    file: Annotated[str, typer.Argument(help="A file by name or uid; NAME#ROW for one row of a charger sheet.")],
    run: Annotated[str, typer.Argument(help="The run it belongs to.")],
    why: Annotated[str | None, typer.Option("--why", help="Why, where it belonged to another run before.")] = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Say to which run a file, or a row of a charger sheet, belongs; no result uses it before.

    Example: labbook assign log_0007.csv r007; labbook assign charges.csv#3 r007
    """
    from labbook.actions.assigning import assign as state_assignment
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.desk(person) as desk:
        said = state_assignment(desk, file, run, why)
        stale = desk.stale
    emit({"file": file, "run": run, "stale": stale}, [said], as_json)
