"""What commands print: text that a terminal does not obey, JSON, columns, progress.

Names and notes come from files and from others, and a terminal obeys some letters.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import typer

from data_schema.vocabulary import Undefined

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


def listed(names: Sequence[str], most: int = 12) -> str:
    """Return names in a row; of more than `most` these, and how many more there are."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def say(line: str, *, err: bool = False) -> None:
    """Print a line for people."""
    typer.echo(printable(line), err=err)


@dataclass(frozen=True, slots=True)
class Shown:
    """What a command answers: data for programs, lines for people, who see the data where there are none; exit code.

    `one_line`: its JSON is on one line, as of a command that has told of other things before, a document a line.
    """

    data: object
    lines: Sequence[str] | None = None
    code: int = 0
    one_line: bool = False


_FOR_PROGRAM = ContextVar("what is printed is for a program", default=False)


def for_program() -> bool:
    """Tell whether a program reads what is printed, for which nothing stands beside the JSON and nobody is asked."""
    return _FOR_PROGRAM.get()


@contextlib.contextmanager
def printing_for(*, program: bool) -> Iterator[None]:
    """Let what is printed while this is open be for a program, or for people."""
    before = _FOR_PROGRAM.set(program)
    try:
        yield
    finally:
        _FOR_PROGRAM.reset(before)


def show(shown: Shown, as_json: bool) -> int:
    """Print what a command answers for a program or for people, and return the exit code."""
    emit(shown.data, shown.lines or (), as_json or shown.lines is None, one_line=shown.one_line)
    return shown.code


def tell_now(data: object, lines: Sequence[str]) -> bool:
    """Print something that happens while a command runs: a line of JSON, or lines for people; False if nobody reads."""
    heard = emit(data, lines, for_program(), one_line=True)
    with contextlib.suppress(BrokenPipeError):
        sys.stdout.flush()
        return heard
    _let_nobody_read()
    return False


def with_files(data: Mapping[str, Any], lines: Sequence[str], files: Mapping[str, Path | None]) -> Shown:
    """Answer with the files that were written beside it, too, by what they are."""
    written = {name: str(path) for name, path in files.items() if path is not None}
    return Shown({**data, **written}, [*lines, *written.values()])


def emit(data: object, lines: Sequence[str], as_json: bool, *, one_line: bool = False) -> bool:
    """Print `data` as JSON, or the lines for people; a reader who has seen enough (`| head`) is no error, but False."""
    said = [] if as_json else printable_items(lines)
    if as_json:
        indent = None if one_line else 2
        said = [printable_json(json.dumps(plain(data), ensure_ascii=False, indent=indent, allow_nan=False))]
    try:
        if said:
            typer.echo("\n".join(said))  # at once: a line each takes a second of a list of a hundred thousand
    except BrokenPipeError:
        _let_nobody_read()
        return False
    return True


def _let_nobody_read() -> None:
    """Let what is printed from now on go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


NOT_IN_JSON = {"json": False}
"""Metadata of a field that figures read, and that is too much for JSON."""


def plain(value: Any) -> Any:
    """Turn rows into what JSON can hold; what is undefined is its reason in words."""
    if isinstance(value, Undefined):
        return {"reason": value.reason}
    if is_dataclass(value) and not isinstance(value, type):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value) if one.metadata.get("json", True)}
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    return value if isinstance(value, str | int | float | bool) or value is None else str(value)


def columns(head: Sequence[str], rows: Iterable[Sequence[object]], none: str | None = None) -> list[str]:
    """Set rows in columns under their heads; the last column is not padded, None is blank.

    Where there are no rows, `none` is said instead.
    """
    rows = [["" if cell is None else str(cell) for cell in row] for row in rows]
    if not rows and none is not None:
        return [none]
    widths = [max(map(len, cells)) for cells in zip(head, *rows, strict=True)]
    form = "  ".join(f"{{:<{width}}}" for width in widths[:-1])
    form = f"{form}  {{}}" if form else "{}"
    return [form.format(*row).rstrip() for row in (head, *rows)]


@contextlib.contextmanager
def progress(what: str, total: int | None, shown: bool = True) -> Iterator[Callable[[str], None]]:
    """Show a progress bar on the terminal while work goes on; yields the function that says one step is done."""
    with _bar(what, total, "", shown) as advance:
        yield lambda step: advance(1, step)


@contextlib.contextmanager
def counted(what: str, total: int, unit: str, shown: bool = True) -> Iterator[Callable[[int], None]]:
    """Show on the terminal how much of many is done and when all will be.

    Yields the function that says how many more are; what it is told first was there before, and took no time.
    """
    with _bar(what, total, f" {unit}", shown) as advance:
        yield lambda more: advance(more, what)


@contextlib.contextmanager
def _bar(what: str, total: int | None, unit: str, shown: bool) -> Iterator[Callable[[int, str], None]]:
    """Show a bar, or without a total that work goes on; yields the function that says how many more are, and which."""
    if not shown or for_program() or not sys.stderr.isatty():
        yield lambda _more, _step: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    count = TextColumn("{task.completed:,.0f}/{task.total:,.0f}" + unit)
    parts = [] if total is None else [BarColumn(), count, TimeRemainingColumn()]
    described = TextColumn("{task.description}", markup=False)
    console = Console(stderr=True)
    with Progress(
        SpinnerColumn(), described, *parts, TimeElapsedColumn(), console=console, transient=True, redirect_stdout=False
    ) as bar:
        task, began = bar.add_task(what, total=total), False

        def advance(more: int, step: str) -> None:
            nonlocal began
            if unit and not began:
                bar.reset(task, total=total, completed=more)
            else:
                bar.update(task, advance=more, description=printable(step[:40]))
            began = True

        yield advance


def asking() -> bool:
    """Tell whether a person sits at the terminal and can be asked."""
    return not for_program() and sys.stdin.isatty() and sys.stderr.isatty()
