"""`labbook today`: what is still to do."""

from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, emit, plain


def today(
    day: Annotated[str | None, typer.Option("--day", metavar="DATE", help="Another day, as 2021-06-01.")] = None,
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """List what a day still needs: logs without charge, charges without log, logs that do not count, checks not made.

    Runs of jumps without joules or without apex heights are named with the reason, a line for each.

    Planned runs that were not made are listed of all plans and days, for a plan's days are not bound to dates. The last
    line says when the last backup was made.

    Example: labbook today
    """
    from data_schema import journal
    from labbook.actions.runs.to_do import to_do, to_do_lines
    from labbook.analysis.outcomes.detection import Detections
    from labbook.book.last_backup import backup_line, last_backup
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.reading() as connection:
        found = to_do(Detections(connection, opened_book.store), opened_book.configuration, day)
        last, (entries, _hash) = last_backup(opened_book.store), journal.head(connection)
    lines = [*to_do_lines(found), backup_line(last, entries)]
    emit({**plain(found), "last_backup": last}, lines, as_json)
