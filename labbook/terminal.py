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
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass
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


def say(line: str, *, err: bool = False) -> None:
    """Print a line for people."""
    typer.echo(printable(line), err=err)


def emit(data: object, lines: Sequence[str], as_json: bool) -> None:
    """Print `data` as JSON, or the lines for people; a reader who has seen enough (`| head`) is no error."""
    said = [] if as_json else printable_items(lines)
    if as_json:
        said = [printable_json(json.dumps(plain(data), ensure_ascii=False, indent=2, allow_nan=False))]
    try:
        if said:
            typer.echo("\n".join(said))  # at once: a line each takes a second of a list of a hundred thousand
    except BrokenPipeError:
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


def columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Set rows in columns under their heads; the last column is not padded."""
    widths = [max(map(len, cells)) for cells in zip(head, *rows, strict=True)]
    form = "  ".join(f"{{:<{width}}}" for width in widths[:-1])
    form = f"{form}  {{}}" if form else "{}"
    return [form.format(*row).rstrip() for row in (head, *rows)]


@contextlib.contextmanager
def progress(what: str, total: int | None, shown: bool) -> Iterator[Callable[[str], None]]:
    """Show a progress bar on the terminal while work goes on; yields the function that says one step is done."""
    if not shown or not sys.stderr.isatty():
        yield lambda _step: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    parts = [
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    ]
    if total is None:
        parts = [SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()]
    with Progress(*parts, console=Console(stderr=True), transient=True, redirect_stdout=False) as bar:
        task = bar.add_task(what, total=total)
        yield lambda step: bar.update(task, advance=1, description=printable(step[:40]))


@contextlib.contextmanager
def counted(what: str, total: int, unit: str, shown: bool) -> Iterator[Callable[[int], None]]:
    """Show on the terminal how much of many is done, how many a second and when all will be.

    Yields the function that says how many more are; what it is told first was there before, and is not in the rate.
    """
    if not shown or not sys.stderr.isatty():
        yield lambda _more: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    form = "{task.completed:,.0f}/{task.total:,.0f} " + unit + " {task.fields[rate]}"
    parts = [
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn(form),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    ]
    with Progress(*parts, console=Console(stderr=True), transient=True, redirect_stdout=False) as bar:
        task = bar.add_task(what, total=total, rate="")
        began, before = time.perf_counter(), -1

        def advance(more: int) -> None:
            nonlocal began, before
            done = int(bar.tasks[0].completed) + more
            if before < 0:
                bar.reset(task, total=total, completed=more, rate="")
                began, before = time.perf_counter(), more
                return
            rate = (done - before) / max(time.perf_counter() - began, 1e-9)
            bar.update(task, advance=more, rate=f"{rate:,.0f}/s")

        yield advance


def before_work(lines: Sequence[str]) -> None:
    """Say on the terminal, before long work begins, what its result will say too."""
    for line in lines if sys.stderr.isatty() else ():
        say(line, err=True)


def asking() -> bool:
    """Tell whether a person sits at the terminal and can be asked."""
    return sys.stdin.isatty() and sys.stderr.isatty()
