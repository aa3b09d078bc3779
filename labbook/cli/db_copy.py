"""`labbook db copy`: a book's tables into another database."""

from typing import Annotated

import typer

from labbook.cli.common import JsonOption, emit, progress


def copy_command(
    source: Annotated[str, typer.Argument(metavar="SRC", help="A book's folder, or the address of its database.")],
    target: Annotated[
        str,
        typer.Argument(
            metavar="DST", help="The address of an empty PostgreSQL database, or a folder without labbook.db."
        ),
    ],
    as_json: JsonOption = False,
) -> None:
    """Copy all rows between SQLite and PostgreSQL, and compare each of them.

    Only the tables are copied: the journal, the raw copies and the samples stay where they are. What others state
    meanwhile stands in journal.jsonl, and the first command on the new database applies it.

    Example: labbook db copy mybook postgresql+psycopg://lab@server/mybook
    """
    from labbook.book.copying_database import copy_database

    with progress("copying", None, shown=not as_json) as step:
        done = copy_database(source, target, step)
    total = sum(done.rows.values())
    lines = [
        f"{total} rows of {len(done.rows)} tables copied to {done.database}; each is the same in both.",
        done.to_do,
    ]
    emit(done, lines, as_json)
