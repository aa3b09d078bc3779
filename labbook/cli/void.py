"""`labbook void`: a run does not count."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def void(
    run: Annotated[str, typer.Argument(help="The run.")],
    reason: Annotated[
        str, typer.Option("--reason", "--why", help="Why it does not count, or with --undo why it does.")
    ],
    undo: Annotated[bool, typer.Option("--undo", help="The run counts after all.")] = False,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Declare a run void: it stays in the book with its files, no result uses it, reports count it.

    Where [analysis] of labbook.toml says for which reasons, begin with one of them: "sensor_fault: the string was off".

    A run that is void already stays so, and nothing is stated a second time.

    Example: labbook void r017 --reason "foot came loose"; labbook void r017 --undo --reason "it was r018"
    """
    from labbook.actions.runs.correcting import unvoid
    from labbook.actions.runs.correcting import void as state_void
    from labbook.actions.runs.jump_review import reason_remarks
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.session(person) as session:
        said = (unvoid if undo else state_void)(session, run, reason)
        stale = session.stale
        remarks = [] if undo else reason_remarks(session.connection, opened_book.configuration, reason)
    emit(
        {"run": run, "stale": stale, "remarks": remarks},
        [f"{said}; {len(stale)} results became stale.", *(f"look again: {remark}" for remark in remarks)],
        as_json,
    )
