"""Text on its way to a terminal: names and notes come from files and from others, and a terminal obeys some letters."""

from __future__ import annotations

import re
import shutil
import sys
import textwrap
from collections.abc import Sequence

import typer

_OBEYED = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
"""Control characters except tab and the end of a line, and those that turn the direction of writing."""


def printable(text: str) -> str:
    """Return a text with all that a terminal would obey written out, an escape as \\x1b."""
    return _OBEYED.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def printable_item(text: str) -> str:
    """Return one line of output; further lines, of a name or a note, are marked, or they could pass for labbook's."""
    return printable(text).replace("\n", "\n    | ")


def printable_items(lines: Sequence[str]) -> list[str]:
    """Return lines of output as `printable_item` does; a long list in which there is nothing to mark, in one look."""
    text = "\n".join(lines)
    if text.count("\n") == len(lines) - 1 and not _OBEYED.search(text):
        return [text]
    return [printable_item(line) for line in lines]


def within_width(lines: Sequence[str]) -> list[str]:
    """Break sentences between words where a terminal is narrower; a file or a pipe gets them whole.

    What goes on below a line that is set in is set in further.
    """
    if not sys.stdout.isatty():
        return list(lines)
    width = shutil.get_terminal_size().columns
    return [
        part
        for line in lines
        for part in textwrap.wrap(
            line, width, break_long_words=False, subsequent_indent="      " if line.startswith("  ") else ""
        )
        or [""]
    ]


def printable_json(text: str) -> str:
    """Return JSON that a terminal shows as it is; to a program it says the same."""
    return _OBEYED.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def say(line: str, *, err: bool = False) -> None:
    """Print a line for people."""
    typer.echo(printable(line), err=err)
