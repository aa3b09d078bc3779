"""What all commands share: options, output, progress. Light, because every command loads it."""

from __future__ import annotations

import contextlib
import functools
import inspect
import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from data_schema.vocabulary import Undefined
from labbook.presenting.terminal import printable, printable_items, printable_json, say

BookOption = Annotated[
    Path | None, typer.Option("--book", metavar="DIR", help="The book; without it, the one that holds this folder.")
]
AsOption = Annotated[
    str | None,
    typer.Option(
        "--as", metavar="NAME", envvar="LABBOOK_AS", help="Who states this: a name or initials that labbook.toml lists."
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for programs.")]


class Fold(StrEnum):
    """Which reading of a local time: by the offset from UTC before the change of clocks, or after it."""

    FIRST = "first"
    SECOND = "second"


FoldOption = Annotated[
    Fold | None, typer.Option("--fold", help="Which of a local time that clocks show twice, or skip.")
]
WhereOption = Annotated[
    str | None,
    typer.Option("--where", metavar="TEXT", help='Which runs, for example "k_gain=400 and day>=2021-06-01".'),
]


def with_options(parameter: str, options: Mapping[str, tuple[Any, Any]]) -> Callable[[Callable[..., Any]], Any]:
    """Let a command take `options`, each an annotation and a default, where its function has one dict of them."""

    def decorated(own: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(own)
        def run(**given: Any) -> Any:
            taken = {name: given.pop(name) for name in options}
            return own(**given, **{parameter: taken})

        every: list[inspect.Parameter] = []
        for one in inspect.signature(own).parameters.values():
            if one.name == parameter:
                every += [
                    inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
                    for name, (kind, default) in options.items()
                ]
            else:
                every.append(one.replace(kind=inspect.Parameter.KEYWORD_ONLY))
        run.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
        run.__annotations__ = {one.name: one.annotation for one in every}
        return run

    return decorated


def options_given(context: typer.Context) -> dict[str, object]:
    """Return a command's options by name, each with the value that the command line gave it, else None."""
    values: dict[str, object] = {}
    for parameter in context.command.params:
        name = str(parameter.name)
        source = context.get_parameter_source(name)
        given = context.params.get(name) if source is not None and source.name == "COMMANDLINE" else None
        values |= {word.removeprefix("--"): given for word in parameter.opts if word.startswith("--")}
    return values


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


def plain(value: Any) -> Any:
    """Turn rows into what JSON can hold; what is undefined is its reason in words."""
    if isinstance(value, Undefined):
        return {"reason": value.reason}
    if is_dataclass(value) and not isinstance(value, type):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value)}
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
