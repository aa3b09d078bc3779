"""`labbook why`: where a number came from."""

from dataclasses import replace
from typing import Annotated

import typer

from data_schema.errors import BookDamaged
from labbook.cli.common import BookOption, JsonOption, emit, progress


def why(
    number: Annotated[str, typer.Argument(help="The provenance id beside a number in a report, or its beginning.")],
    check: Annotated[
        bool, typer.Option("--check", help="Compute the number anew from raw copies and journal, and compare.")
    ] = False,
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """Trace a number to the algorithm, the facts and the bytes it rests on.

    A number printed by an earlier labbook, which a rebuild computes anew under another id, is told as it was printed.

    With --check, exit code 3 where the number does not come out as it is stored, or rests on what was altered.

    Example: labbook why 3fa9c2d1 --check
    """
    from labbook.actions.upkeep.recomputing import recompute
    from labbook.actions.upkeep.tracing import NumberTrace, trace, trace_lines
    from labbook.book.opening import opened

    with opened(book) as opened_book:
        with opened_book.reading() as connection:
            found = trace(connection, number)
        if not check:
            emit(found, trace_lines(found), as_json)
            return
        uid = found.number.uid if isinstance(found, NumberTrace) else found.uid
        with progress("replaying", None, shown=not as_json) as step:
            (checked,) = recompute(opened_book, [uid], step)
    if isinstance(found, NumberTrace) and checked.trace is not None:
        found = replace(found, trace=checked.trace)
    emit({"trace": found, "check": checked}, [checked.sentence, *trace_lines(found)], as_json)
    if checked.stands is False:
        raise typer.Exit(BookDamaged.exit_code)
