"""`labbook stats savings`: the share of the control's mean that is saved."""

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
    app.command("savings")(savings)


def savings(
    file: FileArgument = None,
    value: ValueOption = None,
    by: ByOption = None,
    control: ControlOption = None,
    day: DayOption = None,
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
    """Show what groups save, (control - group) / control in percent, with Fieller's interval and, beside it, the delta
    interval and that of the logarithm.

    On the book the values are the joules of its runs, with the error of the passive drain that they share, as in the
    report.

    Example: labbook stats savings data.csv --value energy_J --by controller --control CE;
    labbook stats savings --where "foot=small and k_gain=400" --pooled --plot savings.pdf
    """
    from labbook.actions.stats.data import DataSource
    from labbook.actions.stats.pictures import Pictures
    from labbook.actions.stats.savings import save

    given = DataSource(file, text_of(file), value, by, control, where, missing, decimal, quantity, book, day)
    pictures = Pictures(plot, qq, residuals)
    with progress("stats savings", None, shown=not as_json) as step:
        told = save(given, alpha, level, pooled, pictures, step)
    print_output(told, as_json)
