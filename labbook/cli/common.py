"""The options that commands share. Light, because every command loads it."""

from __future__ import annotations

import contextlib
import functools
import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labbook.terminal import emit

if TYPE_CHECKING:
    import sqlalchemy as sa

    from labbook.book.opening import Book
    from labbook.book.write_session import WriteSession

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


WhyOption = Annotated[str, typer.Option("--why", "--reason", help="Why.")]
MaybeWhyOption = Annotated[str | None, typer.Option("--why", "--reason", help="Why.")]


@contextlib.contextmanager
def reading(folder: Path | None) -> Iterator[tuple[Book, sa.Connection]]:
    """Open a book and read from it."""
    from labbook.book.opening import opened

    with opened(folder) as book, book.reading() as connection:
        yield book, connection


@contextlib.contextmanager
def stating(folder: Path | None, person: str | None) -> Iterator[tuple[Book, WriteSession]]:
    """Open a book and state something in it, all or nothing."""
    from labbook.book.opening import opened

    with opened(folder) as book, book.session(person) as session:
        yield book, session


def tell(data: Mapping[str, Any], said: Sequence[str], as_json: bool) -> None:
    """Print what was stated, and of `data` how the runs do now (`rig`), what became `stale`, and `remarks`."""
    from labbook.actions.upkeep.stale import stale_lines

    stale = data.get("stale")
    remarks = [f"look again: {getattr(remark, 'message', remark)}" for remark in data.get("remarks", ())]
    emit(data, [*said, *data.get("rig", ()), *(stale_lines(stale) if stale else ()), *remarks], as_json)


def tell_statement(
    folder: Path | None,
    person: str | None,
    make: Callable[[WriteSession], str],
    data: Mapping[str, Any],
    as_json: bool,
) -> None:
    """Make one statement, and print its message and what became stale."""
    with stating(folder, person) as (_book, session):
        said = make(session)
        stale = session.stale
    tell({**data, "said": said, "stale": stale}, [said], as_json)


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
