"""`labbook backup`: what a book cannot be made anew without, in another folder."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, emit, progress


def backup(
    destination: Annotated[
        Path, typer.Argument(metavar="DEST", help="A folder for this book's backup, best on another disk.")
    ],
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """Copy the journal, the raw copies and labbook.toml to DEST; the next time only what is new.

    Every copy is read again and compared with its hash. Others may go on writing to the book. The database is made anew
    from these by `labbook restore`, also where it is PostgreSQL; the pages of reports by `labbook report`.

    Example: labbook backup /media/stick/mybook
    """
    from labbook.book.backing_up import back_up
    from labbook.book.opening import find_folder

    done = back_up(
        find_folder(book or Path.cwd()), destination, lambda total: progress("backing up", total, shown=not as_json)
    )
    raw = done.raw
    lines = [
        f"backup in {done.last.where}: {done.last.entries} entries and {raw.raw_copies} raw copies; {raw.written} "
        f"written ({raw.n_bytes / 1e6:.1f} MB), {raw.raw_copies - raw.written} there already, all read and compared.",
    ]
    if raw.replaced:
        lines.append(f"{raw.replaced} of them {'were' if raw.replaced > 1 else 'was'} damaged in the backup.")
    emit(done, [*lines, *done.remarks], as_json)
