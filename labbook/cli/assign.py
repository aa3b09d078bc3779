"""`labbook assign`: a file, or a row of a charger sheet, belongs to a run."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def assign(
    file: Annotated[str, typer.Argument(help="A file by name or uid; NAME#ROW or NAME#PART for a part of it.")],
    run: Annotated[str, typer.Argument(help="The run it belongs to; none takes it off its run.")],
    why: Annotated[
        str | None, typer.Option("--why", "--reason", help="Why, where it belonged to a run before.")
    ] = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Say to which run a file, or a row of a charger sheet, belongs; no result uses it before.

    NAME#ROW is one row of a charger sheet, NAME#PART one of several runs in a file (`labbook files show NAME`).

    Example: labbook assign log_0007.csv r007; labbook assign charges.csv#3 none --why "read a line too low"
    """
    from labbook.actions.files.assigning import NO_RUN
    from labbook.actions.files.assigning import assign as state_assignment
    from labbook.actions.runs.remarks import remark_lines, remarks_on
    from labbook.actions.upkeep.stale import stale_lines
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.session(person) as session:
        said = state_assignment(session, file, run, why)
        stale = session.stale
        remarks = remarks_on(session.connection, opened_book.configuration, [] if run == NO_RUN else [run], ["log"])
    lines = [said, *(stale_lines(stale) if stale else []), *remark_lines(remarks)]
    data = {"file": file, "run": None if run == NO_RUN else run, "stale": stale, "remarks": remarks}
    emit(data, lines, as_json)
