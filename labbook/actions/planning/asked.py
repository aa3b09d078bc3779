"""What is asked of `labbook plan` and `labbook power`, an option a field. Light: help loads it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from data_schema.vocabulary import PlanMethod


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """How a plan is drawn and written."""

    n: Annotated[int, typer.Option(help="Runs of each condition.")] = 10
    per_day: Annotated[int, typer.Option(help="Runs a day at most.")] = 16
    method: Annotated[PlanMethod, typer.Option(help="Or blocked by group.")] = PlanMethod.RANDOMISED
    start: Annotated[str | None, typer.Option(metavar="DATE", help="The first day; default today.")] = None
    idle: Annotated[bool, typer.Option("--idle/--no-idle", help="Include the protocol's idle runs.")] = True
    looks: Annotated[int, typer.Option(help="At how many times the data are looked at.")] = 1
    out: Annotated[Path, typer.Option(metavar="FILE", help="The run sheet to write.")] = Path("runs.csv")


@dataclass(frozen=True, slots=True)
class PowerRequest:
    """The effect to be found and the scatter expected: of the primary outcome, in J or m; and how runs are drawn.

    A study takes one of what may be given several times, for a test alone.
    """

    saving: Annotated[
        float | None, typer.Option(metavar="PERCENT", help="The saving to be found, of the control's mean.")
    ] = None
    difference: Annotated[
        float | None,
        typer.Option(metavar="VALUE", help="The difference to be found, as --sd."),
    ] = None
    sd: Annotated[
        list[float] | None,
        typer.Option(
            metavar="VALUE",
            help="Standard deviation within groups; default that of the book's runs so far. For welch also two: "
            "--sd 4 --sd 6.",
        ),
    ] = None
    mean: Annotated[
        list[float] | None,
        typer.Option(
            metavar="VALUE",
            help="The control's mean; default as for --sd. For anova one for each group: --mean 10 --mean 12.",
        ),
    ] = None
    apex_sd: Annotated[float | None, typer.Option(metavar="M", help="--sd of apex heights.")] = None
    apex_mean: Annotated[float | None, typer.Option(metavar="M", help="--mean of apex heights.")] = None
    n: Annotated[
        list[int] | None,
        typer.Option(
            help="Show the power of so many runs of each condition, or values a group; not for anova also two, the "
            "control's first for tost.",
        ),
    ] = None
    power: Annotated[float, typer.Option(help="The power wanted: show the n it needs.")] = 0.8
    per_day: Annotated[int, typer.Option(help="Runs a day at most.")] = 16
    method: Annotated[PlanMethod, typer.Option(help="How runs are drawn; or blocked by group.")] = PlanMethod.RANDOMISED
    idle: Annotated[bool, typer.Option("--idle/--no-idle", help="Whether idle runs are among the runs.")] = True
