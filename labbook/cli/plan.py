"""`labbook plan`: the order of the experiments; `labbook power`: how many runs a study needs, or values a test."""

from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Annotated

import typer

from labbook.actions.planning.asked import PlanRequest, PowerRequest
from labbook.cli.common import AsOption, BookOption, opened, options_given, stating
from labbook.terminal import Shown, columns

if TYPE_CHECKING:
    from labbook.actions.planning.plan import PlanMade


def plan(
    ctx: typer.Context,
    seed: Annotated[int | None, typer.Option(help="The same seed draws the same plan, to the byte.")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Write the sheet; state nothing.")] = False,
    withdraw: Annotated[
        bool, typer.Option("--withdraw", help="Take back what is still to be made, of the plan with --seed or of all.")
    ] = False,
    why: Annotated[str | None, typer.Option(help="With --withdraw: why it will not be made.")] = None,
    sheet: Annotated[
        bool, typer.Option("--sheet", help="Write the sheet of the plan with --seed again; state nothing.")
    ] = False,
    *,
    request: PlanRequest,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Draw the order of the experiments, write the run sheet (CSV, and HTML to print), and state the plan.

    Every day has a control for each group (foot and gain) in it, and every condition reaches its n. The order of a day
    is random, but for controls and treated runs of a group being equally early on average, as nearly as they can be: a
    drift over the day favours neither.

    With --withdraw, runs that are planned and not made are no longer planned; those that were made stay. The seed is
    how a plan is called: while runs of it are to be made, no other plan is drawn with that seed.

    With --sheet the sheet of a plan that was stated is written once more, its first day today or that of --start.

    With --looks 5, reports may be made five times as the runs come in: at each, p is compared with a lower level, and
    intervals are wider, so that all looks together err as often as one. That is decided before the first measurement.

    Where shared days decide the test, its power for a difference of one standard deviation of runs is said, and where
    fewer runs would find more. `labbook power` says how many runs a study needs.

    Example: labbook plan --seed 7 --n 10 --per-day 16 --start 2021-06-01; labbook plan --withdraw --why "new foot"
    """
    from data_schema.errors import UsageError
    from data_schema.rounding import p_text
    from labbook.actions.planning.plan import make_plan, sheet_again, withdraw_plans

    if withdraw and sheet:
        raise UsageError("--withdraw and --sheet exclude each other: give one of them.")
    if withdraw:
        if why is None:
            raise UsageError("withdrawing a plan needs a reason: add --why, the journal keeps it.")
        _refuse_drawing(ctx, "--withdraw", "--seed, --why and --dry-run")
        with stating(book, person, dry_run=dry_run) as (_opened_book, session):
            gone = withdraw_plans(session, seed, why)
        stay = f" {len(gone.made)} that were made stay." if gone.made else ""
        dry = " (dry run: nothing stored)" if dry_run else ""
        return Shown(gone, [f"{len(gone.withdrawn)} planned runs withdrawn{dry}.{stay}"])
    if seed is None:
        raise UsageError("a plan needs a seed: add for example --seed 7, the same seed draws the same plan.")
    if why is not None:
        raise UsageError("--why belongs to --withdraw: leave it out, or withdraw the plan.")
    if sheet:
        _refuse_drawing(ctx, "--sheet", "--seed, --start and --out", "start", "out")
        with opened(book) as opened_book:
            again = sheet_again(opened_book, seed, request.start, request.out)
        line = f"{again.sheet} to fill in, {again.printed} to print: {again.runs} runs."
        return Shown(again, [line, *(f"look again: {remark}" for remark in again.remarks)])
    with opened(book) as opened_book:
        done = make_plan(opened_book, seed, request, person, dry_run=dry_run)
    at = [f"{look.runs} runs ({p_text(look.level, name=False)})" for look in done.looks]
    looks = [f"{len(at)} looks, with the level that p is compared with if they are at {', '.join(at)}."] if at else []
    return Shown(
        done,
        [
            f"{done.runs} runs on {done.days} day{'' if done.days == 1 else 's'}, {done.controls} of them controls, "
            f"{done.idle} idle.",
            *_tested(done),
            *looks,
            f"{done.sheet} to fill in, {done.printed} to print; then `labbook runs import {done.sheet}`.",
            *(f"look again: {remark}" for remark in done.remarks),
        ],
    )


def _refuse_drawing(ctx: typer.Context, option: str, used: str, *others: str) -> None:
    """Raise `UsageError` for options that say how a plan is drawn, beside one that draws none."""
    from data_schema.errors import UsageError

    given = options_given(ctx)
    names = {one.name.replace("_", "-"): "" for one in fields(PlanRequest)} | {"idle": "/--no-idle"}
    drawing = [f"--{name}{other}" for name, other in names.items() if given[name] is not None and name not in others]
    if drawing:
        raise UsageError(
            f"{option} draws no plan and has no use for {' and '.join(drawing)}: leave that out, {used} go with it."
        )


def _tested(done: "PlanMade") -> list[str]:
    """Say by which test the report will decide, as the days of the plan allow, and what that finds."""
    from data_schema.vocabulary import Undefined
    from stats.days.decision import LEAST_DAYS

    days = done.shared_days
    if days is None:
        return []
    if days == 0:
        return ["No day has both sides of some comparison: the report will claim nothing of it."]
    test = "on day means"
    if days < LEAST_DAYS:
        test = f"within days (fewer than {LEAST_DAYS}), and its claim holds for these days"
    found = ""
    if isinstance(done.power, float):
        found = f" It finds a difference of one standard deviation of runs with a power of {100.0 * done.power:.1f} %."
    if done.too_few:
        why = done.power.reason if isinstance(done.power, Undefined) else "that is below alpha"
        found += f" Too few runs to test, {why}: give more with --n."
    lines = [f"Compared conditions share at least {days} day{'s' * (days > 1)}: the test is {test}.{found}"]
    return [*lines, *([] if done.crossing is None else [done.crossing.sentence])]


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
