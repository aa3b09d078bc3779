"""`labbook power`: how many runs a study needs, or how many values a test."""

from typing import Annotated, Any

import typer

from labbook.cli.common import BookOption, JsonOption, options_given, with_options
from labbook.terminal import columns, emit

USUAL_N = 10

_LOW = typer.Option("--low", help="With --test tost: the lower bound.")
_HIGH = typer.Option("--high", help="With --test tost: the upper bound.")
_PERCENT = typer.Option("--percent", help="With --test tost: bounds are in percent of the control's mean (--mean).")
_ONE_SIDED = typer.Option(
    "--one-sided",
    help="With --test t or welch: only a difference above 0 counts, as for non-inferiority, where --difference is that "
    "from the bound.",
)
_ALPHA = typer.Option("--alpha", help="With --test: its level; default 0.05.")
_OF_TEST: dict[str, tuple[Any, Any]] = {
    "low": (Annotated[float | None, _LOW], None),
    "high": (Annotated[float | None, _HIGH], None),
    "percent": (Annotated[bool, _PERCENT], False),
    "one_sided": (Annotated[bool, _ONE_SIDED], False),
    "alpha": (Annotated[float | None, _ALPHA], None),
}
"""The options of one test by parameter, each with its default."""


@with_options("of_test", _OF_TEST)
def power(
    ctx: typer.Context,
    saving: Annotated[
        float | None, typer.Option("--saving", metavar="PERCENT", help="The saving to be found, of the control's mean.")
    ] = None,
    difference: Annotated[
        float | None,
        typer.Option("--difference", metavar="VALUE", help="The difference to be found, as --sd."),
    ] = None,
    sd: Annotated[
        list[float] | None,
        typer.Option(
            "--sd",
            metavar="VALUE",
            help="Standard deviation within groups; default that of the book's runs so far. For welch also two: "
            "--sd 4 --sd 6.",
        ),
    ] = None,
    mean: Annotated[
        list[float] | None,
        typer.Option(
            "--mean",
            metavar="VALUE",
            help="The control's mean; default as for --sd. For anova one for each group: --mean 10 --mean 12.",
        ),
    ] = None,
    apex_sd: Annotated[float | None, typer.Option("--apex-sd", metavar="M", help="--sd of apex heights.")] = None,
    apex_mean: Annotated[float | None, typer.Option("--apex-mean", metavar="M", help="--mean of apex heights.")] = None,
    n: Annotated[
        list[int] | None,
        typer.Option(
            "--n",
            help="Show the power of so many runs of each condition, or values a group; not for anova also two, the "
            "control's first for tost.",
        ),
    ] = None,
    wanted: Annotated[float, typer.Option("--power", help="The power wanted: show the n it needs.")] = 0.8,
    per_day: Annotated[int, typer.Option("--per-day", help="Runs a day at most.")] = 16,
    method: Annotated[
        str, typer.Option("--method", help="How runs are drawn: randomised, or blocked by group.")
    ] = "randomised",
    idle: Annotated[bool, typer.Option("--idle/--no-idle", help="Whether idle runs are among the runs.")] = True,
    test: Annotated[
        str | None,
        typer.Option("--test", metavar="NAME", help="No study but one test: t, welch, anova or tost (equivalence)."),
    ] = None,
    *,
    of_test: dict[str, Any],
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
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
        from labbook.actions.planning.named_test import plan_test

        given = {f"--{name}": value for name, value in options_given(ctx).items() if value is not None}
        emit(*plan_test(test, {name: given[name] for name in given if name not in ("--test", "--json")}), as_json)
        return
    idle_options = [f"--{name.replace('_', '-')}" for name, value in of_test.items() if value not in (None, False)]
    if idle_options:
        raise UsageError(
            f"the study is planned as its [analysis] decides, with no use for {' and '.join(idle_options)}: leave that "
            "out, or name one test with --test."
        )
    for option, values in (("--sd", sd), ("--mean", mean), ("--n", n)):
        if values and len(values) > 1:
            raise UsageError(f"{option} is given {len(values)} times: a study takes one, or name one test with --test.")
    from labbook.actions.planning.power import PowerRequest, study_power
    from labbook.actions.planning.power_lines import power_foot, power_head, power_table
    from labbook.book.opening import opened

    request = PowerRequest(
        saving_percent=saving,
        difference=difference,
        sd=sd[0] if sd else None,
        mean=mean[0] if mean else None,
        apex_sd_m=apex_sd,
        apex_mean_m=apex_mean,
        target=wanted,
        n=n[0] if n else USUAL_N,
        per_day=per_day,
        method=method,
        idle=idle,
    )
    with opened(book) as opened_book:
        found = study_power(opened_book, request)
    head, rows = power_table(found)
    emit(found, [*power_head(found), "", *columns(head, rows), "", *power_foot(found)], as_json)
