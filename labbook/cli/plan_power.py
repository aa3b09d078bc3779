"""`labbook plan --power`: its options, and what it prints."""

from dataclasses import dataclass
from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, columns, emit

PowerOption = Annotated[
    bool, typer.Option("--power", help="Draw nothing: say how many runs of each condition the study needs.")
]
SavingOption = Annotated[
    float | None,
    typer.Option("--saving", metavar="PERCENT", help="With --power: the saving to be found, of the control's mean."),
]
DifferenceOption = Annotated[
    float | None,
    typer.Option("--difference", metavar="VALUE", help="With --power: the same in J, or in m for apex heights."),
]
SdOption = Annotated[
    float | None,
    typer.Option(
        "--sd", metavar="VALUE", help="With --power: standard deviation between runs; default that of the runs so far."
    ),
]
MeanOption = Annotated[
    float | None, typer.Option("--mean", metavar="VALUE", help="With --power: the control's mean; default as for --sd.")
]
ApexSdOption = Annotated[
    float | None, typer.Option("--apex-sd", metavar="M", help="With --power: --sd of apex heights, for their bounds.")
]
ApexMeanOption = Annotated[
    float | None, typer.Option("--apex-mean", metavar="M", help="With --power: --mean of apex heights.")
]
TargetOption = Annotated[
    float | None, typer.Option("--target", help="With --power: the chance that is wanted; default 0.8.")
]

OF_POWER = {
    "saving": "--saving",
    "difference": "--difference",
    "sd": "--sd",
    "mean": "--mean",
    "apex_sd": "--apex-sd",
    "apex_mean": "--apex-mean",
    "target": "--target",
}
"""Options, by parameter, that say what is assumed; each is None where it was not given."""

TARGET = 0.8


@dataclass(frozen=True, slots=True)
class Assumptions:
    """The options of `OF_POWER` as given, None where not."""

    saving: float | None
    difference: float | None
    sd: float | None
    mean: float | None
    apex_sd: float | None
    apex_mean: float | None
    target: float | None


def show_power(
    assumed: Assumptions,
    n: int,
    per_day: int,
    method: str,
    idle: bool,
    book: BookOption,
    as_json: JsonOption,
) -> None:
    """Print what the study needs."""
    from labbook.actions.planning.power import study_power
    from labbook.actions.planning.power_lines import power_foot, power_head, power_table
    from labbook.actions.planning.power_request import PowerRequest
    from labbook.book.opening import opened

    request = PowerRequest(
        saving_percent=assumed.saving,
        difference=assumed.difference,
        sd=assumed.sd,
        mean=assumed.mean,
        apex_sd_m=assumed.apex_sd,
        apex_mean_m=assumed.apex_mean,
        target=TARGET if assumed.target is None else assumed.target,
        n=n,
        per_day=per_day,
        method=method,
        idle=idle,
    )
    with opened(book) as opened_book:
        found = study_power(opened_book, request)
    head, rows = power_table(found)
    emit(found, [*power_head(found), "", *columns(head, rows), "", *power_foot(found)], as_json)
