"""`labbook stats`: the statistics of the reports on any table, or on the book.

What all its commands take is declared in `labbook/actions/stats/asked.py`; a command is its own options, what its help
says, and a call.
"""

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from labbook.actions.stats.asked import Values
from labbook.terminal import Shown, progress, within_width

if TYPE_CHECKING:
    from labbook.actions.stats.answering import Answer, Question


def _shown(values: Values, ask: Callable[["Question"], "Answer"], pooled: bool = False) -> Shown:
    """Ask it of the values, and answer with the file written; not all commands have pooled."""
    from labbook.actions.stats.answering import answer

    with progress("stats", None) as step:
        data, lines = answer(values, ask, pooled, step)
    return Shown(data, [*within_width(lines), *([str(values.plot)] if values.plot else [])])


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


@app.command()
def compare(values: Values, route: RouteOption = None, pooled: PooledOption = False) -> Shown:
    """Compare groups with a control. Where days are known, by --day or in the book, by the report's test on shared
    days: paired on day means from four on, within days below. Without days, where the plan counts runs or days, or with
    --route, by Welch's t or another, with the difference, its interval and Hedges's g. Several groups are adjusted by
    Holm's method.

    On the book the values are one a run, those of the report, and so are the numbers: joules carry the error of the
    passive drain that the groups share. Nothing is written but the figure.

    Example: labbook stats compare data.csv --value energy_J --by controller --control CE --plot energy.pdf;
    labbook stats compare --where "foot=small and k_gain=400" --pooled
    """
    from labbook.actions.stats.answering import compare

    return _shown(values, functools.partial(compare, route=route), pooled)


@app.command()
def anova(values: Values, variances: VariancesOption = "unequal") -> Shown:
    """Analyse the variance of several groups: F, all pairs with simultaneous intervals, and whether the groups scatter
    alike (Brown and Forsythe). Days are left out.

    On the book the values are one a run, those of the report.

    Example: labbook stats anova data.csv --value energy_J --by gain --control 0 --plot energy.pdf;
    labbook stats anova --where "foot=small and k_gain=400" --quantity apex --variances equal
    """
    from labbook.actions.stats.answering import analyse

    return _shown(values, functools.partial(analyse, variances=variances))


@app.command()
def savings(values: Values, pooled: PooledOption = False) -> Shown:
    """Show what groups save, (control - group) / control in percent, with Fieller's interval: by shared days where
    these are known, by --day or in the book, as in `stats compare`, else of all values.

    On the book the values are the joules of its runs, with the error of the passive drain that they share, as in the
    report.

    Example: labbook stats savings data.csv --value energy_J --by controller --control CE;
    labbook stats savings --where "foot=small and k_gain=400" --pooled --plot savings.pdf
    """
    from labbook.actions.stats.answering import save

    return _shown(values, save, pooled)


@app.command()
def equivalence(
    values: Values,
    low: LowOption = None,
    high: HighOption = None,
    percent: PercentOption = False,
    pooled: PooledOption = False,
) -> Shown:
    """Test whether groups differ from the control by less than what matters: two one-sided t-tests (TOST), or one for a
    single bound. The interval has level 1 - 2 alpha. Where days are known the test is the report's by shared days, as
    in `stats compare`; without days all values are as of one day.

    On the book the values are one a run, those of the report; for its apex heights (in metres) the bounds of its
    [analysis] are taken where none are given.

    Example: labbook stats equivalence data.csv --value apex_mm --by controller --control CE --low -5 --high 5;
    labbook stats equivalence --quantity apex --low -3 --percent --pooled --plot apex.pdf
    """
    from labbook.actions.stats.answering import equal

    return _shown(values, functools.partial(equal, given=(low, high, percent)), pooled)
