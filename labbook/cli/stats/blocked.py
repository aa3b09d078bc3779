"""`labbook stats blocked`: groups over several days."""

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
    app.command("blocked")(blocked)


def blocked(
    file: FileArgument = None,
    value: ValueOption = None,
    by: ByOption = None,
    control: ControlOption = None,
    day: DayOption = None,
    run: Annotated[
        str | None,
        typer.Option(
            "--run-within-day",
            metavar="COLUMN",
            help="The table's column of runs; on the book, run: every jump, within its run (--quantity apex).",
        ),
    ] = None,
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
    """Compare groups over days, the day being a random effect: y ~ group + (1 | day) by REML with Satterthwaite's
    degrees of freedom, as lmerTest does, and the exact F-test where the design has one. Groups that share no day
    are confounded with their days; what follows is said.

    On the book the values are one a run, those of the report, on the runs' days.

    Example: labbook stats blocked data.csv --value energy_J --by controller --control CE --day date;
    labbook stats blocked --quantity apex --run-within-day run --where "foot=small and k_gain=400"
    """
    from labbook.actions.stats.blocked import block
    from labbook.actions.stats.data import DataSource
    from labbook.actions.stats.pictures import Pictures

    given = DataSource(file, text_of(file), value, by, control, where, missing, decimal, quantity, book, day, run)
    pictures = Pictures(plot, qq, residuals)
    with progress("stats blocked", None, shown=not as_json) as step:
        told = block(given, alpha, level, pooled, pictures, step)
    print_output(told, as_json)
