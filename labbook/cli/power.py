"""`labbook power`: how many runs a study needs, or how many values a test."""

from dataclasses import asdict, dataclass
from typing import Annotated

import typer

from labbook.actions.planning.asked import PowerRequest
from labbook.cli.common import BookOption, opened, options_given
from labbook.terminal import Shown, columns


@dataclass(frozen=True, slots=True)
class OfTest:
    """The options of one test."""

    low: Annotated[float | None, typer.Option(help="With --test tost: the lower bound.")] = None
    high: Annotated[float | None, typer.Option(help="With --test tost: the upper bound.")] = None
    percent: Annotated[
        bool,
        typer.Option("--percent", help="With --test tost: bounds are in percent of the control's mean (--mean)."),
    ] = False
    one_sided: Annotated[
        bool,
        typer.Option(
            "--one-sided",
            help="With --test t or welch: only a difference above 0 counts, as for non-inferiority, where --difference "
            "is that from the bound.",
        ),
    ] = False
    alpha: Annotated[float | None, typer.Option(help="With --test: its level; default 0.05.")] = None


def power(
    ctx: typer.Context,
    test: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="No study but one test: t, welch, anova or tost (equivalence)."),
    ] = None,
    *,
    request: PowerRequest,
    of_test: OfTest,
    book: BookOption = None,
) -> Shown:
    """Show how many runs of each condition the book's study needs, and on how many days, to find a saving or a
    difference by the tests that [analysis] decides on, and what --n runs and the plans that stand can find. The scatter
    is what is expected (--sd), or that of the runs so far. Nothing is drawn, stated or stored. A fourth shared day
    turns a test within days into a paired one: where that lowers the power, both powers are said.

    With --test no book is needed: how likely that test finds a true difference with n values a group, or the smallest n
    that finds it with the power wanted. Values are taken to be independent.

    Example: labbook power --saving 10 --sd 4 --mean 42;
    labbook power --test t --difference 1.5 --sd 1.2 --power 0.9;
    labbook power --test tost --low -3 --high 3 --percent --mean 0.3 --sd 0.004
    """
    from data_schema.errors import UsageError

    if test:
        from labbook.actions.planning.power import plan_test

        given = {f"--{name}": value for name, value in options_given(ctx).items() if value is not None}
        return Shown(*plan_test(test, {name: given[name] for name in given if name not in ("--test", "--json")}))
    idle_options = [
        f"--{name.replace('_', '-')}" for name, value in asdict(of_test).items() if value not in (None, False)
    ]
    if idle_options:
        raise UsageError(
            f"the study is planned as its [analysis] decides, with no use for {' and '.join(idle_options)}: leave that "
            "out, or name one test with --test."
        )
    from labbook.actions.planning.power import power_foot, power_head, power_table, study_power

    with opened(book) as opened_book:
        found = study_power(opened_book, request)
    head, rows = power_table(found)
    return Shown(found, [*power_head(found), "", *columns(head, rows), "", *power_foot(found)])
