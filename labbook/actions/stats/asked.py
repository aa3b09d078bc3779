"""What `labbook stats` is asked about: the values, at which level, and the figure wanted. Light: help loads it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from data_schema.outcomes import Outcome


@dataclass(frozen=True, slots=True)
class Values:
    """The values that a command is about, at which level, and the figure wanted: the options of every command.

    Without `file` the values are the book's; `value`, `by` and `day` name columns of a table, or `by` a factor of a
    book.
    """

    file: Annotated[
        Path | None,
        typer.Argument(metavar="FILE", show_default=False, help="A CSV file, one value a row; without it, the book."),
    ] = None
    value: Annotated[str | None, typer.Option(metavar="COLUMN", help="The table's column of values.")] = None
    by: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="What makes the groups: a column of the table, a factor of the book."),
    ] = None
    control: Annotated[
        str | None,
        typer.Option(
            metavar="GROUP",
            help="What the others are compared with; default: the study's control, or of a table the first in order.",
        ),
    ] = None
    day: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="The table's column of days; a book knows its own.")
    ] = None
    where: Annotated[
        str | None,
        typer.Option(metavar="TEXT", help='Which rows or runs, for example "foot=small and k_gain=400".'),
    ] = None
    alpha: Annotated[
        float | None, typer.Option(help="Level of the tests; default: the book's [analysis], or 0.05.")
    ] = None
    missing: Annotated[
        str, typer.Option(metavar="WAY", help="What to do with empty cells: refuse, or drop and say how many.")
    ] = "refuse"
    decimal: Annotated[
        str | None,
        typer.Option(
            metavar="SIGN",
            help="The table's decimal sign, . or , where it is unclear; with , points before three digits are "
            "thousands.",
        ),
    ] = None
    quantity: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=f"What of a book's runs: {', '.join(item.key for item in Outcome)}; default: joules (of a jump).",
        ),
    ] = None
    book: Annotated[
        Path | None, typer.Option(metavar="DIR", help="The book; without it, the one that holds this folder.")
    ] = None
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="All values and the differences: a .png, .svg or .pdf file."),
    ] = None
