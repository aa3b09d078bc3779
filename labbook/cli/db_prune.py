"""`labbook db prune`: what lies about in a book and nothing needs."""

from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, columns, emit, progress


def prune_command(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="NAME", help="Only these of the list; without one, all of it.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Remove them; without, they are only listed.")] = False,
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """List what nothing needs: old databases, files of commands that were cut off, results that no report shows.

    Never a raw copy that a row or the journal speaks of. Files written to within an hour are left out. What was set
    aside from the journal is removed only by its name. The book is checked before anything is removed.

    Example: labbook db prune --yes
    """
    from labbook.actions.upkeep.pruning import leftovers, named, prune
    from labbook.book.opening import opened

    with opened(book) as opened_book:
        if yes:
            found = prune(opened_book, names or (), lambda total: progress("checking", total, shown=not as_json))
        else:
            with opened_book.reading() as connection:
                found = named(leftovers(opened_book, connection), names or ())
    rows = [[one.name, "" if one.n_bytes is None else f"{one.n_bytes / 1e6:.1f} MB", one.what] for one in found]
    lines = columns(["name", "size", "what it is"], rows) if rows else []
    if not found:
        lines.append("nothing lies about.")
    elif yes:
        lines.append(f"{len(found)} removed.")
    else:
        lines.append("nothing was removed: --yes removes all of these, names before it only those.")
    emit({"removed": yes, "leftovers": found}, lines, as_json)
