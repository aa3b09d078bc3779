"""Text files that a person names on the command line."""

from __future__ import annotations

import codecs
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import typer

from data_schema.errors import InputRefused, UsageError
from labbook.actions.files.named_files import decoded, own_name, read_bytes, read_file
from labbook.plan.sheet_cells import SheetQuestion
from labbook.terminal import asking, say

_Done = TypeVar("_Done")
USUAL_PAGE = "cp1252"
"""What spreadsheets of Western Europe and America write where they do not write UTF-8."""


def read_text(path: Path, *, marked_utf_16: bool = False) -> str:
    """Read a text file as UTF-8, with or without a byte order mark, or where asked for as UTF-16 with such a mark."""
    return decoded(path, read_file(path), marked_utf_16=marked_utf_16)


def read_sheet(path: Path, page: str | None) -> tuple[str, str | None]:
    """Read a sheet by its byte order mark, as UTF-8, or else by its `page`; returns the text and the page if it was it.

    Raises `UsageError` for a page that does not exist, `InputRefused` for text that is not in it.
    """
    try:
        codecs.lookup(page or USUAL_PAGE)
    except LookupError:
        raise UsageError(f"--encoding {page!r} is not known: give for example cp1252 or iso8859-15.") from None
    try:
        return read_text(path, marked_utf_16=True), None
    except InputRefused as error:
        if not isinstance(error.__cause__, UnicodeDecodeError):
            raise
    try:
        return read_bytes(path).decode(page or USUAL_PAGE), page or USUAL_PAGE
    except UnicodeDecodeError as error:
        raise InputRefused(
            f"{own_name(path)} is neither UTF-8 nor {page or USUAL_PAGE} text (byte {error.start}): name its page with "
            "--encoding, or save it as CSV in UTF-8."
        ) from error


def with_answers(
    attempt: Callable[[dict[str, str | None]], _Done], answers: dict[str, str | None], *, ask: bool
) -> _Done:
    """Call `attempt` with the answers given as options; ask for one that is missing at a terminal, refuse elsewhere."""
    while True:
        try:
            return attempt(answers)
        except SheetQuestion as question:
            if not ask or not asking() or answers.get(question.option) is not None:
                raise
            listed = ", ".join(f"{choice}: {meaning}" for choice, meaning in question.choices.items())
            say(f"{question.sentence} ({listed}).", err=True)
            chosen = ""
            while chosen not in question.choices:
                chosen = typer.prompt(" or ".join(question.choices), err=True).strip()
            answers = {**answers, question.option: chosen}
