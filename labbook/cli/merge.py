"""`labbook merge`: the field laptop's book comes home."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def merge(
    other: Annotated[Path, typer.Argument(metavar="OTHER", help="The folder of the other book; it is only read.")],
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Show what would come, and write nothing.")] = False,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Bring in what another book of the same study says beyond this one, all of it or nothing.

    What follows the common beginning of both is added, each statement with its own time and person. What both books
    name alike (a run, a level, the bytes of a file) is one thing; where they contradict each other everything is
    listed and nothing is written. Merging again adds what is new since.

    Example: labbook merge /media/laptop/book --dry-run
    """
    from labbook.actions.upkeep.merging import merge as bring_in
    from labbook.book.opening import opened

    with opened(book) as opened_book:
        done = bring_in(opened_book, other, person, dry_run=dry_run)
    counts = ", ".join(f"{what}: {count}" for what, count in done.entries.items())
    total = sum(done.entries.values())
    came = f"{'would come' if dry_run else 'came'} from {other}"
    entries, copies = _counted(total, "entry", "entries"), _counted(done.raw_copies, "raw copy", "raw copies")
    lines = [f"{came}: {entries} ({counts}), {copies}."]
    if not total:
        lines = [] if done.conflicts else [f"{other} says nothing that this book does not have: nothing to add."]
    if done.there_already:
        had = _counted(done.there_already, "entry", "entries")
        lines.append(f"this book had already {had} of those after the first {done.common}, which both share.")
    lines += [f"in the way: {sentence}" for sentence in done.conflicts]
    emit(done, lines, as_json)
    if done.conflicts:
        raise typer.Exit(1)


def _counted(number: int, one: str, several: str) -> str:
    return f"{number} {one if number == 1 else several}"
