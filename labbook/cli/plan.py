"""`labbook plan`: the order of the experiments."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("plan")(plan)


def plan(
    seed: Annotated[int, typer.Option("--seed", help="The same seed draws the same plan, to the byte.")],
    n: Annotated[int, typer.Option("--n", help="Runs of each condition.")] = 10,
    per_day: Annotated[int, typer.Option("--per-day", help="Runs a day at most.")] = 16,
    method: Annotated[str, typer.Option("--method", help="randomised, or blocked by group.")] = "randomised",
    start: Annotated[str | None, typer.Option("--start", metavar="DATE", help="The first day; default today.")] = None,
    idle: Annotated[bool, typer.Option("--idle/--no-idle", help="Include the protocol's idle runs.")] = True,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The run sheet to write.")] = Path("runs.csv"),
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Write the sheet; state nothing.")] = False,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Draw the order of the experiments, write the run sheet (CSV, and HTML to print), and state the plan.

    Every day has a control for each group (foot and gain) in it, and every condition reaches its n.

    Example: labbook plan --seed 7 --n 10 --per-day 16 --start 2021-06-01
    """
    from labbook.actions.planning import PlanRequest, make_plan
    from labbook.book.opening import opened

    request = PlanRequest(seed, n, per_day, method, start, idle, out, dry_run)
    with opened(book) as opened_book:
        done = make_plan(opened_book, request, person)
    emit(
        done,
        [
            f"{done.runs} runs on {done.days} days, {done.controls} of them controls, {done.idle} idle.",
            f"{done.sheet} to fill in, {done.printed} to print; then `labbook runs import {done.sheet}`.",
        ],
        as_json,
    )
