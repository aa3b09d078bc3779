"""`labbook correct`: a fact was wrong."""

import json
from typing import Annotated, Any

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
    from labbook.actions.correcting import correct as state_correction
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.desk(person, correcting=True) as desk:
        changed = state_correction(opened_book, desk, target, fields, why)
        stale = desk.stale
    lines = [f"{target}: {', '.join(fields)}."]
    lines += _stale_lines(stale)
    emit({"target": target, "changed": changed, "stale": stale}, lines, as_json)


SCOPES_NAMED = 6
"""Results of one kind that are named; --json lists them all."""


def _stale_lines(stale: list[tuple[str, str]]) -> list[str]:
    """Return one line a kind of result: how many, and what the first are about."""
    if not stale:
        return ["No further results became stale."]
    by_kind: dict[str, list[str]] = {}
    for kind, scope in stale:
        by_kind.setdefault(kind, []).append(_about(json.loads(scope)))
    lines = [f"{len(stale)} results are stale and will be computed anew by the next report:"]
    for kind, about in by_kind.items():
        different = list(dict.fromkeys(filter(None, about)))
        more = f", and {len(different) - SCOPES_NAMED} more" if len(different) > SCOPES_NAMED else ""
        named = f": {', '.join(different[:SCOPES_NAMED])}{more}" if different else ""
        lines.append(f"  {kind.replace('_', ' ')} ({len(about)}){named}")
    return lines


def _about(scope: dict[str, Any]) -> str:
    """Say what a result is about; a result of many words is about its label."""
    return str(next((scope[name] for name in ("run", "label", "condition", "pack", "study") if name in scope), ""))
