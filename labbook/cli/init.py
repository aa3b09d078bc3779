"""`labbook init`: make a book."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, emit


def init(
    folder: Annotated[Path, typer.Argument(help="The folder of the new book.")],
    person: Annotated[str, typer.Option("--as", metavar="NAME", envvar="LABBOOK_AS", help="Who makes the book.")],
    database: Annotated[
        str | None,
        typer.Option(
            "--database", metavar="URL", help="An empty PostgreSQL database for the tables, for a shared book."
        ),
    ] = None,
    store: Annotated[
        Path | None,
        typer.Option("--store", metavar="DIR", help="Where raw copies and journal lie, if not in the book."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Make a book: a folder with labbook.toml, its database, its journal and its store.

    An existing labbook.toml in the folder is used as it is; otherwise a commented one is written to be filled in.
    Where there is a book already, it stays as it is; one whose making was interrupted is finished.

    Example: labbook init mybook --as "Ada Nwosu"
    """
    from labbook.book.making import make_book

    if not make_book(folder, person, database, store):
        emit({"book": str(folder.resolve())}, [f"{folder.resolve()} is a book already: nothing was made."], as_json)
        return
    emit(
        {"book": str(folder.resolve())},
        [
            f"made the book {folder.resolve()}.",
            f"Next: describe the study in {folder / 'labbook.toml'}, then `labbook plan`.",
            "Decide there under [analysis], before the first run is ingested, what will be compared and how.",
        ],
        as_json,
    )
