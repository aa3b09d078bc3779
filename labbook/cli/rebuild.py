"""`labbook rebuild`: the database anew from raw copies and journal."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, emit, progress


def rebuild(
    journal: Annotated[bool, typer.Option("--journal", help="Write journal.jsonl from the database instead.")] = False,
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make the database anew from the raw copies and the journal; the old one is kept beside it.

    Example: labbook rebuild
    """
    from labbook.book.opening import find_folder
    from labbook.book.rebuilding import rebuild_database, rewrite_journal

    folder = find_folder(book or Path.cwd())
    if journal:
        count = rewrite_journal(folder)
        emit({"entries": count}, [f"journal.jsonl written anew: {count} entries."], as_json)
        return
    with progress("rebuilding", None, shown=not as_json) as step:
        done = rebuild_database(folder, step)
    kept = f"the old database is kept as {done.old}" if done.old else "there was no old database"
    emit(done, [f"rebuilt from {done.entries} entries; {kept}.", *done.sentences], as_json)
