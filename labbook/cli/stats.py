"""`labbook stats`: the statistics of the reports on any table, or on the book.

What all its commands take is declared once, in `_SHARED`; a command is its own options, what its help says, and a call.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from data_schema.outcomes import Outcome
from labbook.cli.common import BookOption, JsonOption, with_options
from labbook.terminal import columns, emit, progress, within_width

if TYPE_CHECKING:
    from labbook.actions.stats.answering import Answer, Question

_FILE = typer.Argument(metavar="FILE", show_default=False, help="A CSV file, one value a row; without it, the book.")
_VALUE = typer.Option("--value", metavar="COLUMN", help="The table's column of values.")
_BY = typer.Option("--by", metavar="NAME", help="What makes the groups: a column of the table, a factor of the book.")
_CONTROL = typer.Option(
    "--control",
    metavar="GROUP",
    help="What the others are compared with; default: the study's control, or of a table the first in order.",
)
_DAY = typer.Option("--day", metavar="COLUMN", help="The table's column of days; a book knows its own.")
_WHERE = typer.Option("--where", metavar="TEXT", help='Which rows or runs, for example "foot=small and k_gain=400".')
_MISSING = typer.Option(
    "--missing", metavar="WAY", help="What to do with empty cells: refuse, or drop and say how many."
)
_DECIMAL = typer.Option(
    "--decimal",
    metavar="SIGN",
    help="The table's decimal sign, . or , where it is unclear; with , points before three digits are thousands.",
)
_QUANTITY = typer.Option(
    "--quantity",
    metavar="NAME",
    help=f"What of a book's runs: {', '.join(item.key for item in Outcome)}; default: joules (of a jump).",
)
_ALPHA = typer.Option("--alpha", help="Level of the tests; default: the book's [analysis], or 0.05.")
_PLOT = typer.Option("--plot", metavar="FILE", help="All values and the differences: a .png, .svg or .pdf file.")
_QQ = typer.Option("--qq", metavar="FILE", help="The residuals beside normal quantiles: a figure.")
_RESIDUALS = typer.Option("--residuals", metavar="FILE", help="The residuals by group and by day: a figure.")
_FULL = typer.Option("--full", help="Show every field of the results, too, and what each means.")

_SHARED: dict[str, tuple[Any, Any]] = {
    "file": (Annotated[Path | None, _FILE], None),
    "value": (Annotated[str | None, _VALUE], None),
    "by": (Annotated[str | None, _BY], None),
    "control": (Annotated[str | None, _CONTROL], None),
    "day": (Annotated[str | None, _DAY], None),
    "where": (Annotated[str | None, _WHERE], None),
    "alpha": (Annotated[float | None, _ALPHA], None),
    "missing": (Annotated[str, _MISSING], "refuse"),
    "decimal": (Annotated[str | None, _DECIMAL], None),
    "quantity": (Annotated[str | None, _QUANTITY], None),
    "book": (BookOption, None),
    "plot": (Annotated[Path | None, _PLOT], None),
    "qq": (Annotated[Path | None, _QQ], None),
    "residuals": (Annotated[Path | None, _RESIDUALS], None),
    "full": (Annotated[bool, _FULL], False),
    "as_json": (JsonOption, False),
}
"""The options of every command by parameter, each with its default."""

LevelOption = Annotated[
    float | None, typer.Option("--level", help="Level of the intervals, 1 - alpha: another way to say it.")
]
PooledOption = Annotated[bool, typer.Option("--pooled", help="Take all groups but the control as one.")]
RouteOption = Annotated[
    str,
    typer.Option("--route", metavar="NAME", help="welch, student, or f_then_t (thesis: F-test, then one of them)."),
]
TestRouteOption = Annotated[str, typer.Option("--route", metavar="NAME", help="welch or student.")]
RunOption = Annotated[
    str | None,
    typer.Option(
        "--run-within-day",
        metavar="COLUMN",
        help="The table's column of runs; on the book, run: every jump, within its run (--quantity apex).",
    ),
]
LowOption = Annotated[
    float | None, typer.Option("--low", help="The lower bound of group minus control; alone: non-inferiority.")
]
HighOption = Annotated[float | None, typer.Option("--high", help="The upper bound of group minus control.")]
PercentOption = Annotated[
    bool, typer.Option("--percent", help="The bounds are in percent of the control's mean, not in the values' unit.")
]

app = typer.Typer(no_args_is_help=True)


@dataclass(frozen=True, slots=True)
class Shared:
    """A command's name, and the shared options as given, by parameter."""

    command: str
    options: dict[str, Any]

    def answer(
        self,
        ask: Callable[["Question"], "Answer"],
        level: float | None = None,
        pooled: bool = False,
        run: str | None = None,
    ) -> None:
        """Ask it of the values and print the answer, with --full the fields behind it, and the files written.

        `level`, `pooled` and `run` are options that some commands have.
        """
        from labbook.actions.stats.answering import answer
        from labbook.actions.stats.data import DataSource
        from labbook.cli.reading import read_text

        given = self.options
        file = given["file"]
        text = "" if file is None else read_text(file, marked_utf_16=True)
        named = {
            key: given[key]
            for key in ("value", "by", "control", "where", "missing", "decimal", "quantity", "book", "day")
        }
        source = DataSource(file, text, **named, run=run)
        alpha, files = given["alpha"], {name: given[name] for name in ("plot", "qq", "residuals")}
        pictures = {name: path for name, path in files.items() if path is not None}
        with progress(f"stats {self.command}", None, shown=not given["as_json"]) as step:
            found = answer(source, ask, alpha=alpha, level=level, pooled=pooled, pictures=pictures, step=step)
        lines = within_width(found.lines)
        for item in found.fields if given["full"] else ():
            lines += (
                within_width([item]) if isinstance(item, str) else [f"  {line}" for line in columns(item[0], item[1:])]
            )
        emit(found.data, [*lines, *found.files], given["as_json"])


def command(own: Callable[..., None]) -> None:
    """Add a command that takes all shared options and its own, which follow its first parameter."""

    @functools.wraps(own)
    def run(shared: dict[str, Any], **given: Any) -> None:
        own(Shared(own.__name__, shared), **given)

    app.command(own.__name__)(with_options("shared", _SHARED)(run))


@command
def compare(
    shared: Shared, route: RouteOption = "welch", level: LevelOption = None, pooled: PooledOption = False
) -> None:
    """Compare groups with a control. Where days are known, by --day or in the book, the report's test by shared days
    leads: paired on day means from four on, within days below; a plan that counts runs or days keeps its test. Then
    Welch's t or another by --route, the difference with its interval, Hedges's g; several groups also by Holm's method.
    --full adds an F-test and Brown and Forsythe's of the variances.

    On the book the values are one a run, those of the report, and so are the numbers: joules carry the error of the
    passive drain that the groups share. Nothing is written but figures.

    Example: labbook stats compare data.csv --value energy_J --by controller --control CE --plot energy.pdf;
    labbook stats compare --where "foot=small and k_gain=400" --pooled
    """
    from labbook.actions.stats.comparing import compare

    shared.answer(functools.partial(compare, route=route), level, pooled)


@command
def anova(shared: Shared, level: LevelOption = None) -> None:
    """Analyse the variance of several groups: the classic F and Welch's, tests of equal variances, all pairs by Tukey
    and by Games and Howell, each group against the control by Dunnett, and Welch's tests against it by Holm.

    On the book the values are one a run, those of the report.

    Example: labbook stats anova data.csv --value energy_J --by gain --control 0 --plot energy.pdf;
    labbook stats anova --where "foot=small and k_gain=400" --quantity apex
    """
    from labbook.actions.stats.anova import analyse

    shared.answer(analyse, level)


@command
def savings(shared: Shared, level: LevelOption = None, pooled: PooledOption = False) -> None:
    """Show what groups save, (control - group) / control in percent, with Fieller's interval. Where days are known, by
    --day or in the book, the report's savings by shared days lead, as in `stats compare`; then those of all values,
    ignoring days. --full adds their delta interval and that of the logarithm.

    On the book the values are the joules of its runs, with the error of the passive drain that they share, as in the
    report.

    Example: labbook stats savings data.csv --value energy_J --by controller --control CE;
    labbook stats savings --where "foot=small and k_gain=400" --pooled --plot savings.pdf
    """
    from labbook.actions.stats.comparing import save

    shared.answer(save, level, pooled)


@command
def equivalence(
    shared: Shared,
    low: LowOption = None,
    high: HighOption = None,
    percent: PercentOption = False,
    route: TestRouteOption = "welch",
    pooled: PooledOption = False,
) -> None:
    """Test whether groups differ from the control by less than what matters: two one-sided t-tests (TOST), or one for a
    single bound. The interval has level 1 - 2 alpha. Where days are known the report's test by shared days leads, as in
    `stats compare`; a single bound is tested ignoring days.

    On the book the values are one a run, those of the report; for its apex heights (in metres) the bounds of its
    [analysis] are taken where none are given.

    Example: labbook stats equivalence data.csv --value apex_mm --by controller --control CE --low -5 --high 5;
    labbook stats equivalence --quantity apex --low -3 --percent --pooled --plot apex.pdf
    """
    from labbook.actions.stats.equivalence import equal

    shared.answer(functools.partial(equal, given=(low, high, percent), route=route), pooled=pooled)


@command
def blocked(shared: Shared, run: RunOption = None, level: LevelOption = None, pooled: PooledOption = False) -> None:
    """Compare groups over days, the day being a random effect: y ~ group + (1 | day) by REML with Satterthwaite's
    degrees of freedom, as lmerTest does, and the exact F-test where the design has one. Groups that share no day
    are confounded with their days; what follows is said.

    On the book the values are one a run, those of the report, on the runs' days.

    Example: labbook stats blocked data.csv --value energy_J --by controller --control CE --day date;
    labbook stats blocked --quantity apex --run-within-day run --where "foot=small and k_gain=400"
    """
    from data_schema.errors import UsageError
    from labbook.actions.stats.blocked import block

    if shared.options["file"] is not None and shared.options["day"] is None:
        raise UsageError("comparing over days needs the table's column of days: add --day COLUMN.")
    shared.answer(block, level, pooled, run)
