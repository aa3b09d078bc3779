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
from labbook.terminal import emit, progress, within_width

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
    "as_json": (JsonOption, False),
}
"""The options of every command by parameter, each with its default."""

PooledOption = Annotated[bool, typer.Option("--pooled", help="Take all groups but the control as one.")]
RouteOption = Annotated[
    str | None,
    typer.Option(
        "--route",
        metavar="NAME",
        help="A test of all values, whatever their days: welch, student, or f_then_t (thesis: F-test, then either).",
    ),
]
VariancesOption = Annotated[
    str,
    typer.Option(
        "--variances", metavar="NAME", help="unequal (Welch; Games and Howell) or equal (classic, thesis; Tukey)."
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
        pooled: bool = False,
    ) -> None:
        """Ask it of the values and print the answer and the files written; not all commands have pooled."""
        from labbook.actions.files.named_files import read_bytes
        from labbook.actions.stats.answering import answer
        from labbook.actions.stats.data import DataSource

        given = self.options
        file = given["file"]
        content = b"" if file is None else read_bytes(file)
        named = {
            key: given[key]
            for key in ("value", "by", "control", "where", "missing", "decimal", "quantity", "book", "day")
        }
        source = DataSource(file, content, **named)
        files = {name: given[name] for name in ("plot", "qq", "residuals") if given[name] is not None}
        with progress(f"stats {self.command}", None, shown=not given["as_json"]) as step:
            data, lines = answer(source, ask, alpha=given["alpha"], pooled=pooled, pictures=files, step=step)
        emit(data, [*within_width(lines), *map(str, files.values())], given["as_json"])


def command(own: Callable[..., None]) -> None:
    """Add a command that takes all shared options and its own, which follow its first parameter."""

    @functools.wraps(own)
    def run(shared: dict[str, Any], **given: Any) -> None:
        own(Shared(own.__name__, shared), **given)

    app.command(own.__name__)(with_options("shared", _SHARED)(run))


@command
def compare(shared: Shared, route: RouteOption = None, pooled: PooledOption = False) -> None:
    """Compare groups with a control. Where days are known, by --day or in the book, by the report's test on shared
    days: paired on day means from four on, within days below. Without days, where the plan counts runs or days, or with
    --route, by Welch's t or another, with the difference, its interval and Hedges's g. Several groups are adjusted by
    Holm's method.

    On the book the values are one a run, those of the report, and so are the numbers: joules carry the error of the
    passive drain that the groups share. Nothing is written but figures.

    Example: labbook stats compare data.csv --value energy_J --by controller --control CE --plot energy.pdf;
    labbook stats compare --where "foot=small and k_gain=400" --pooled
    """
    from labbook.actions.stats.answering import compare

    shared.answer(functools.partial(compare, route=route), pooled)


@command
def anova(shared: Shared, variances: VariancesOption = "unequal") -> None:
    """Analyse the variance of several groups: F, all pairs with simultaneous intervals, and whether the groups scatter
    alike (Brown and Forsythe). Days are left out.

    On the book the values are one a run, those of the report.

    Example: labbook stats anova data.csv --value energy_J --by gain --control 0 --plot energy.pdf;
    labbook stats anova --where "foot=small and k_gain=400" --quantity apex --variances equal
    """
    from labbook.actions.stats.answering import analyse

    shared.answer(functools.partial(analyse, variances=variances))


@command
def savings(shared: Shared, pooled: PooledOption = False) -> None:
    """Show what groups save, (control - group) / control in percent, with Fieller's interval: by shared days where
    these are known, by --day or in the book, as in `stats compare`, else of all values.

    On the book the values are the joules of its runs, with the error of the passive drain that they share, as in the
    report.

    Example: labbook stats savings data.csv --value energy_J --by controller --control CE;
    labbook stats savings --where "foot=small and k_gain=400" --pooled --plot savings.pdf
    """
    from labbook.actions.stats.answering import save

    shared.answer(save, pooled)


@command
def equivalence(
    shared: Shared,
    low: LowOption = None,
    high: HighOption = None,
    percent: PercentOption = False,
    pooled: PooledOption = False,
) -> None:
    """Test whether groups differ from the control by less than what matters: two one-sided t-tests (TOST), or one for a
    single bound. The interval has level 1 - 2 alpha. Where days are known the test is the report's by shared days, as
    in `stats compare`; without days all values are as of one day.

    On the book the values are one a run, those of the report; for its apex heights (in metres) the bounds of its
    [analysis] are taken where none are given.

    Example: labbook stats equivalence data.csv --value apex_mm --by controller --control CE --low -5 --high 5;
    labbook stats equivalence --quantity apex --low -3 --percent --pooled --plot apex.pdf
    """
    from labbook.actions.stats.answering import equal

    shared.answer(functools.partial(equal, given=(low, high, percent)), pooled)
