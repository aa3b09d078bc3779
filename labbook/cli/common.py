"""The options that commands share, and how what a command returns is shown. Light, because every command loads it."""

from __future__ import annotations

import contextlib
import functools
import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labbook.terminal import Shown, printing_for, say, show

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
_JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for programs.")]
WhereOption = Annotated[
    str | None,
    typer.Option("--where", metavar="TEXT", help='Which runs, for example "k_gain=400 and day>=2021-06-01".'),
]


RunArgument = Annotated[str, typer.Argument(help="The run.")]
PlotOption = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw it: a .png, .svg or .pdf file.")]
WhyOption = Annotated[str, typer.Option("--why", "--reason", help="Why.")]
MaybeWhyOption = Annotated[str | None, typer.Option("--why", "--reason", help="Why.")]


@contextlib.contextmanager
def opened(folder: Path | None) -> Iterator[Book]:
    """Open a book."""
    from labbook.book.opening import opened as open_book

    with open_book(folder) as book:
        yield book


@contextlib.contextmanager
def reading(folder: Path | None) -> Iterator[tuple[Book, sa.Connection]]:
    """Open a book and read from it; says where the journal has more than the database."""
    with opened(folder) as book:
        say_waiting(book)
        with book.reading() as connection:
            yield book, connection


def say_waiting(book: Book) -> None:
    """Say that entries wait that a command which was cut off left in journal.jsonl: what is read lacks them."""
    from data_schema import journal
    from data_schema.errors import BookDamaged

    try:
        last = book.mirror.last()  # before the database is asked, which others may bring up to it meanwhile
    except BookDamaged:
        return  # commands that write say so
    with book.reading() as connection:
        waiting = 0 if last is None else last.seq - journal.head(connection)[0]
    if waiting > 0:
        entries = "1 entry waits" if waiting == 1 else f"{waiting} entries wait"
        say(
            f"{entries} in journal.jsonl that the database does not have yet: the next command that writes applies it.",
            err=True,
        )


@contextlib.contextmanager
def stating(folder: Path | None, person: str | None, *, dry_run: bool = False) -> Iterator[tuple[Book, WriteSession]]:
    """Open a book and state something in it, all or nothing; nothing where it is a dry run."""
    from labbook.book.write_session import DryRun

    with opened(folder) as book, contextlib.suppress(DryRun), book.session(person) as session:
        yield book, session
        if dry_run:
            raise DryRun


def tell(data: Mapping[str, Any], said: Sequence[str]) -> Shown:
    """Answer what was stated, and of `data` how the runs do now (`rig`), which `reports` it bears on, and `remarks`."""
    reports = [
        f"report {report} has numbers that depend on this: `labbook report` makes it anew."
        for report in data.get("reports", ())
    ]
    remarks = [f"look again: {getattr(remark, 'message', remark)}" for remark in data.get("remarks", ())]
    return Shown(data, [*said, *data.get("rig", ()), *reports, *remarks])


def tell_statement(folder: Path | None, person: str | None, make: Callable[[WriteSession], str], **data: Any) -> Shown:
    """Make one statement, and answer its message and which reports it bears on."""
    from labbook.book.report_numbers import outdated_reports

    with stating(folder, person) as (_book, session):
        said = make(session)
        reports = outdated_reports(session)
    return tell({**data, "said": said, "reports": reports}, [said])


def as_command(own: Callable[..., Shown]) -> Callable[..., int]:
    """Return the command of a function: it takes --json, and the options that dataclasses among its parameters
    declare; it shows what the function returns, and returns the exit code.
    """
    parameters = inspect.signature(own).parameters
    declared: dict[str, Any] = {
        name: one.annotation for name, one in parameters.items() if is_dataclass(one.annotation)
    }
    every: dict[str, inspect.Parameter] = {}
    for name, one in parameters.items():
        every |= inspect.signature(declared[name]).parameters if name in declared else {name: one}
    every["as_json"] = inspect.Parameter(
        "as_json", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=_JsonOption
    )

    @functools.wraps(own)
    def run(**given: Any) -> int:
        as_json = given.pop("as_json")
        for name, kind in declared.items():
            given[name] = kind(**{one.name: given.pop(one.name) for one in fields(kind)})
        with printing_for(program=as_json):
            shown = own(**given)
        return show(shown, as_json)

    run.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in every.values()]
    )
    run.__annotations__ = {name: one.annotation for name, one in every.items()}
    return run


def options_given(context: typer.Context) -> dict[str, object]:
    """Return a command's options by name, each with the value that the command line gave it, else None."""
    values: dict[str, object] = {}
    for parameter in context.command.params:
        name = str(parameter.name)
        source = context.get_parameter_source(name)
        given = context.params.get(name) if source is not None and source.name == "COMMANDLINE" else None
        values |= {word.removeprefix("--"): given for word in parameter.opts if word.startswith("--")}
    return values
