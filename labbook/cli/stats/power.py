"""`labbook stats power`: how many values a test needs."""

from typing import Annotated

import typer

from labbook.cli.common import JsonOption
from labbook.cli.stats.options import print_output


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("power")(power)


def power(
    test: Annotated[str, typer.Option("--test", metavar="NAME", help="t, welch, anova or tost (equivalence).")] = "t",
    difference: Annotated[
        float | None, typer.Option("--difference", help="The true difference of the means; for tost 0 without it.")
    ] = None,
    sd: Annotated[
        list[float] | None,
        typer.Option("--sd", help="The standard deviation within groups; for welch one for each, given twice."),
    ] = None,
    mean: Annotated[
        list[float] | None,
        typer.Option("--mean", help="For anova: a true mean for each group; repeatable. For tost: the control's."),
    ] = None,
    low: Annotated[float | None, typer.Option("--low", help="For tost: the lower bound.")] = None,
    high: Annotated[float | None, typer.Option("--high", help="For tost: the upper bound.")] = None,
    percent: Annotated[
        bool, typer.Option("--percent", help="For tost: the bounds are in percent of the control's mean (--mean).")
    ] = False,
    n: Annotated[
        list[int] | None, typer.Option("--n", help="Values a group, or of each of two, given twice: show the power.")
    ] = None,
    wanted: Annotated[
        float | None, typer.Option("--power", help="The power wanted: show the n it needs; default 0.8.")
    ] = None,
    alpha: Annotated[float | None, typer.Option("--alpha", help="Level of the test; default 0.05.")] = None,
    one_sided: Annotated[
        bool,
        typer.Option(
            "--one-sided",
            help="For t and welch: only a difference above 0 counts, as for non-inferiority, where --difference is "
            "that from the bound.",
        ),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show how likely a test finds a true difference with n values a group, or the smallest n that finds it with the
    power wanted. No data are needed; values are taken to be independent.

    Example: labbook stats power --difference 1.5 --sd 1.2 --power 0.9;
    labbook stats power --test tost --low -5 --high 5 --sd 4 --n 10;
    labbook stats power --test tost --low -3 --high 3 --percent --mean 0.3 --sd 0.004
    """
    from labbook.actions.stats.power import PowerRequest, plan_power

    request = PowerRequest(
        test,
        difference,
        tuple(sd or ()),
        tuple(mean or ()),
        low,
        high,
        tuple(n or ()),
        wanted,
        alpha,
        one_sided,
        percent,
    )
    print_output(plan_power(request), as_json)
