"""`labbook restore`: a book from a backup."""

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, emit, progress


def restore(
    source: Annotated[Path, typer.Argument(metavar="SRC", help="A folder that `labbook backup` made.")],
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the book; empty, or not there.")],
    database: Annotated[
        str | None,
        typer.Option("--database", metavar="URL", help="The empty PostgreSQL database that the book is to have."),
    ] = None,
    sqlite: Annotated[
        bool, typer.Option("--sqlite", help="Make labbook.db in DIR, of a book that was on PostgreSQL.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Make the book of a backup: copy and compare everything, make the database anew, check all of it.

    Cut off, the same command goes on where it was. Pages of reports are not in a backup: `labbook report` makes them.

    Example: labbook restore /media/stick/mybook mybook
    """
    from data_schema.errors import UsageError
    from labbook.actions.upkeep.restoring import Place
    from labbook.actions.upkeep.restoring import restore as restore_book

    if database is not None and sqlite:
        raise UsageError("--database and --sqlite exclude each other: give one of them.")
    place = Place(database) if database is not None or sqlite else None
    with progress("restoring", None, shown=not as_json) as step:
        done = restore_book(source, folder, place, step, lambda _total: contextlib.nullcontext(step))
    lines = [
        f"the book of {source} is restored in {done.folder}: {done.entries} entries, {done.raw.raw_copies} raw copies; "
        "all of it was checked.",
        *done.differences.sentences,
    ]
    if done.moved:
        where = "in the book" if database is None else "in the database given"
        lines.append(f"its labbook.toml says now that the store is in the book, and the tables are {where}.")
    emit(done, lines, as_json)
