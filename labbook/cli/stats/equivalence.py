"""`labbook stats equivalence`: differences too small to matter."""

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
    app.command("equivalence")(equivalence)


def equivalence(
    file: FileArgument = None,
    value: ValueOption = None,
    by: ByOption = None,
    control: ControlOption = None,
    day: DayOption = None,
    low: Annotated[
        float | None, typer.Option("--low", help="The lower bound of group minus control; alone: non-inferiority.")
    ] = None,
    high: Annotated[float | None, typer.Option("--high", help="The upper bound of group minus control.")] = None,
    percent: Annotated[
        bool,
        typer.Option("--percent", help="The bounds are in percent of the control's mean, not in the values' unit."),
    ] = False,
    route: Annotated[str, typer.Option("--route", metavar="NAME", help="welch or student.")] = "welch",
    alpha: AlphaOption = None,
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
    """Test whether groups differ from the control by less than what matters: two one-sided t-tests (TOST), or one for a
    single bound. The interval has level 1 - 2 alpha.

    On the book the values are one a run, those of the report; for its apex heights (in metres) the bounds of its
    [analysis] are taken where none are given.

    Example: labbook stats equivalence data.csv --value apex_mm --by controller --control CE --low -5 --high 5;
    labbook stats equivalence --quantity apex --low -3 --percent --pooled --plot apex.pdf
    """
    from labbook.actions.stats.data import DataSource
    from labbook.actions.stats.equivalence import EquivalenceRequest, equal
    from labbook.actions.stats.pictures import Pictures

    given = DataSource(file, text_of(file), value, by, control, where, missing, decimal, quantity, book, day)
    pictures = Pictures(plot, qq, residuals)
    with progress("stats equivalence", None, shown=not as_json) as step:
        told = equal(given, EquivalenceRequest(low, high, percent, route, alpha, pooled), pictures, step)
    print_output(told, as_json)
