"""`labbook correct`: a fact was wrong."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("correct")(correct)


def correct(
    target: Annotated[str, typer.Argument(help="A run, or study, robot:NAME, battery:NAME, charge:UID.")],
    fields: Annotated[list[str], typer.Argument(metavar="FIELD=VALUE...", help="What it should say.")],
    why: Annotated[str, typer.Option("--why", help="Why the old value was wrong.")],
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Correct a fact: the old value stays in the journal, and everything that rested on it becomes stale.

    Example: labbook correct r017 foot=large --why "typed wrong"
    """
    from labbook.book import opened
    from labbook.correcting import correct as state_correction

    with opened(book) as opened_book, opened_book.desk(person, correcting=True) as desk:
        changed = state_correction(opened_book, desk, target, fields, why)
        stale = desk.stale
    lines = [f"{target}: {', '.join(fields)}."]
    lines += _stale_lines(stale)
    emit({"target": target, "changed": changed, "stale": stale}, lines, as_json)


def _stale_lines(stale: list[tuple[str, str]]) -> list[str]:
    if not stale:
        return ["Nothing stored rests on it."]
    return [f"{len(stale)} results are stale and will be computed anew by the next report:"] + [
        f"  {kind} {scope}" for kind, scope in stale[:40]
    ] + ([f"  ... and {len(stale) - 40} more (--json lists all)"] if len(stale) > 40 else [])  # fmt: skip
