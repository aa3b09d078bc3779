"""`labbook stats anova`: several groups at once."""

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
    app.command("anova")(anova)


def anova(
    file: FileArgument = None,
    value: ValueOption = None,
    by: ByOption = None,
    control: ControlOption = None,
    day: DayOption = None,
    alpha: AlphaOption = None,
    level: LevelOption = None,
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
    """Analyse the variance of several groups: the classic F and Welch's, tests of equal variances, all pairs by Tukey
    and by Games and Howell, each group against the control by Dunnett, and Welch's tests against it by Holm.

    On the book the values are one a run, those of the report.

    Example: labbook stats anova data.csv --value energy_J --by gain --control 0 --plot energy.pdf;
    labbook stats anova --where "foot=small and k_gain=400" --quantity apex
    """
    from labbook.actions.stats.anova import analyse
    from labbook.actions.stats.data import DataSource
    from labbook.actions.stats.pictures import Pictures

    given = DataSource(file, text_of(file), value, by, control, where, missing, decimal, quantity, book, day)
    pictures = Pictures(plot, qq, residuals)
    with progress("stats anova", None, shown=not as_json) as step:
        told = analyse(given, alpha, level, pictures, step)
    print_output(told, as_json)
