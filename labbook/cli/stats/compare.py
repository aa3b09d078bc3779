"""`labbook stats compare`: groups against a control."""

from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, progress
from labbook.cli.stats.options import (
    AlphaOption,
    ByOption,
    ControlOption,
    DayOption,
    DecimalOption,
    FileArgument,
    LevelOption,
    MissingOption,
    PlotOption,
    QqOption,
    QuantityOption,
    ResidualsOption,
    ValueOption,
    WhereOption,
    print_output,
    text_of,
)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare")(compare)


def compare(
    file: FileArgument = None,
    value: ValueOption = None,
    by: ByOption = None,
    control: ControlOption = None,
    day: DayOption = None,
    route: Annotated[
        str,
        typer.Option("--route", metavar="NAME", help="welch, student, or f_then_t (thesis: F-test, then one of them)."),
    ] = "welch",
    alpha: AlphaOption = None,
    level: LevelOption = None,
    pooled: Annotated[bool, typer.Option("--pooled", help="Take all groups but the control as one.")] = False,
    where: WhereOption = None,
    missing: MissingOption = "refuse",
    decimal: DecimalOption = None,
    quantity: QuantityOption = None,
    book: BookOption = None,
    plot: PlotOption = None,
    qq: QqOption = None,
    residuals: ResidualsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Compare groups with a control: Welch's t or another by --route, the difference with its interval, Hedges's g, an
    F-test and Brown and Forsythe's of the variances; several groups also by Holm's method.

    On the book the values are one a run, those of the report, and so are the numbers: joules carry the error of the
    passive drain that the groups share. Nothing is written but figures.

    Example: labbook stats compare data.csv --value energy_J --by controller --control CE --plot energy.pdf;
    labbook stats compare --where "foot=small and k_gain=400" --pooled
    """
    from labbook.actions.stats.compare import CompareRequest
    from labbook.actions.stats.compare import compare as run
    from labbook.actions.stats.data import DataSource
    from labbook.actions.stats.pictures import Pictures

    given = DataSource(file, text_of(file), value, by, control, where, missing, decimal, quantity, book, day)
    pictures = Pictures(plot, qq, residuals)
    with progress("stats compare", None, shown=not as_json) as step:
        told = run(given, CompareRequest(route, alpha, level, pooled), pictures, step)
    print_output(told, as_json)
