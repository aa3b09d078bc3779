"""`labbook power`: how many runs a study needs, or how many values a test."""

from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption
from labbook.terminal import columns, emit

USUAL_POWER, USUAL_N, USUAL_PER_DAY, USUAL_METHOD = 0.8, 10, 16, "randomised"


def power(
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
    wanted: Annotated[
        float | None, typer.Option("--power", help="The power wanted: show the n it needs; default 0.8.")
    ] = None,
    per_day: Annotated[int | None, typer.Option("--per-day", help="Runs a day at most; default 16.")] = None,
    method: Annotated[
        str | None, typer.Option("--method", help="How runs are drawn: randomised, or blocked by group.")
    ] = None,
    idle: Annotated[
        bool | None, typer.Option("--idle/--no-idle", help="Whether idle runs are among the runs; default yes.")
    ] = None,
    test: Annotated[
        str | None,
        typer.Option("--test", metavar="NAME", help="No study but one test: t, welch, anova or tost (equivalence)."),
    ] = None,
    low: Annotated[float | None, typer.Option("--low", help="With --test tost: the lower bound.")] = None,
    high: Annotated[float | None, typer.Option("--high", help="With --test tost: the upper bound.")] = None,
    percent: Annotated[
        bool,
        typer.Option("--percent", help="With --test tost: bounds are in percent of the control's mean (--mean)."),
    ] = False,
    one_sided: Annotated[
        bool,
        typer.Option(
            "--one-sided",
            help="With --test t or welch: only a difference above 0 counts, as for non-inferiority, where --difference "
            "is that from the bound.",
        ),
    ] = False,
    alpha: Annotated[float | None, typer.Option("--alpha", help="With --test: its level; default 0.05.")] = None,
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

    of_study = {
        "--saving": saving,
        "--apex-sd": apex_sd,
        "--apex-mean": apex_mean,
        "--per-day": per_day,
        "--method": method,
        "--idle/--no-idle": idle,
        "--book": book,
    }
    of_test = {
        "--low": low,
        "--high": high,
        "--percent": percent or None,
        "--one-sided": one_sided or None,
        "--alpha": alpha,
    }
    idle_options = [option for option, value in (of_study if test else of_test).items() if value is not None]
    if idle_options and test:
        raise UsageError(
            f"--test {test} plans no study and has no use for {' and '.join(idle_options)}: leave that out, or --test."
        )
    if idle_options:
        raise UsageError(
            f"the study is planned as its [analysis] decides, with no use for {' and '.join(idle_options)}: leave that "
            "out, or name one test with --test."
        )
    if test:
        from labbook.actions.planning.named_test import NamedTest, plan_test

        sds, means, sizes = tuple(sd or ()), tuple(mean or ()), tuple(n or ())
        named = NamedTest(test, difference, sds, means, low, high, sizes, wanted, alpha, one_sided, percent)
        data, lines = plan_test(named)
        emit(data, lines, as_json)
        return
    from labbook.actions.planning.power import PowerRequest, study_power
    from labbook.actions.planning.power_lines import power_foot, power_head, power_table
    from labbook.book.opening import opened

    for option, values in (("--sd", sd), ("--mean", mean), ("--n", n)):
        if values and len(values) > 1:
            raise UsageError(f"{option} is given {len(values)} times: a study takes one, or name one test with --test.")
    request = PowerRequest(
        saving_percent=saving,
        difference=difference,
        sd=sd[0] if sd else None,
        mean=mean[0] if mean else None,
        apex_sd_m=apex_sd,
        apex_mean_m=apex_mean,
        target=USUAL_POWER if wanted is None else wanted,
        n=n[0] if n else USUAL_N,
        per_day=USUAL_PER_DAY if per_day is None else per_day,
        method=method or USUAL_METHOD,
        idle=idle is not False,
    )
    with opened(book) as opened_book:
        found = study_power(opened_book, request)
    head, rows = power_table(found)
    emit(found, [*power_head(found), "", *columns(head, rows), "", *power_foot(found)], as_json)
