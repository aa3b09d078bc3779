"""What the commands of `labbook stats` share: where the values come from, what is drawn."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labbook.cli.common import columns, emit

if TYPE_CHECKING:
    from labbook.actions.stats.output import CommandOutput

FileArgument = Annotated[
    Path | None,
    typer.Argument(metavar="FILE", show_default=False, help="A CSV file, one value a row; without it, the book."),
]
ValueOption = Annotated[str | None, typer.Option("--value", metavar="COLUMN", help="The table's column of values.")]
ByOption = Annotated[
    str | None,
    typer.Option("--by", metavar="NAME", help="What makes the groups: a column of the table, a factor of the book."),
]
ControlOption = Annotated[
    str | None,
    typer.Option(
        "--control",
        metavar="GROUP",
        help="What the others are compared with; default: the study's control, or of a table the first in order.",
    ),
]
DayOption = Annotated[
    str | None, typer.Option("--day", metavar="COLUMN", help="The table's column of days; a book knows its own.")
]
WhereOption = Annotated[
    str | None,
    typer.Option("--where", metavar="TEXT", help='Which rows or runs, for example "foot=small and k_gain=400".'),
]
MissingOption = Annotated[
    str,
    typer.Option("--missing", metavar="WAY", help="What to do with empty cells: refuse, or drop and say how many."),
]
DecimalOption = Annotated[
    str | None,
    typer.Option(
        "--decimal",
        metavar="SIGN",
        help="The table's decimal sign, . or , where it is unclear; with , points before three digits are thousands.",
    ),
]
QuantityOption = Annotated[
    str | None,
    typer.Option("--quantity", metavar="NAME", help="The book's joules (of a jump; default) or apex (heights)."),
]
AlphaOption = Annotated[
    float | None, typer.Option("--alpha", help="Level of the tests; default: the book's [analysis], or 0.05.")
]
LevelOption = Annotated[
    float | None, typer.Option("--level", help="Level of the intervals, 1 - alpha: another way to say it.")
]
PlotOption = Annotated[
    Path | None,
    typer.Option("--plot", metavar="FILE", help="All values and the differences: a .png, .svg or .pdf file."),
]
QqOption = Annotated[
    Path | None, typer.Option("--qq", metavar="FILE", help="The residuals beside normal quantiles: a figure.")
]
ResidualsOption = Annotated[
    Path | None, typer.Option("--residuals", metavar="FILE", help="The residuals by group and by day: a figure.")
]


def text_of(file: Path | None) -> str:
    """Read the table that is named, if one is."""
    from labbook.cli.reading import read_text

    return "" if file is None else read_text(file, marked_utf_16=True)


def print_output(told: "CommandOutput", as_json: bool) -> None:
    """Print what was found."""
    lines: list[str] = []
    for item in told.lines:
        lines += [item] if isinstance(item, str) else [f"  {line}" for line in columns(item[0], item[1:])]
    emit(told.data, lines, as_json)
