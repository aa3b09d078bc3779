"""What is asked of `labbook plan --power`, and what of it makes no sense."""

from __future__ import annotations

import math
from dataclasses import dataclass

from data_schema.errors import UsageError, unknown_name
from data_schema.vocabulary import PlanMethod


@dataclass(frozen=True, slots=True)
class PowerRequest:
    """What was asked of `labbook plan --power`; the numbers are those of the primary outcome, in J or m."""

    saving_percent: float | None
    difference: float | None
    sd: float | None
    mean: float | None
    apex_sd_m: float | None
    apex_mean_m: float | None
    target: float
    n: int
    per_day: int
    method: str
    idle: bool


def refuse_impossible(request: PowerRequest) -> None:
    """Raise `UsageError` for numbers that no study has."""
    if (request.saving_percent is None) == (request.difference is None):
        raise UsageError(
            "the power needs one effect to be found: add --saving 10 (percent of the control) or --difference 4."
        )
    if request.saving_percent is not None and not 0 < request.saving_percent < 100:
        raise UsageError(f"--saving {request.saving_percent:g} is no saving: give percent between 0 and 100.")
    if request.difference is not None and not (math.isfinite(request.difference) and request.difference != 0):
        raise UsageError(f"--difference {request.difference:g} is none: give the smallest one that matters.")
    for option, value in (
        ("--sd", request.sd),
        ("--mean", request.mean),
        ("--apex-sd", request.apex_sd_m),
        ("--apex-mean", request.apex_mean_m),
    ):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise UsageError(f"{option} {value:g} is not possible: give a number above 0.")
    if not 0 < request.target < 1:
        raise UsageError(f"--target {request.target:g} is no chance: give one between 0 and 1, such as 0.8.")
    if request.n < 2:
        raise UsageError(f"--n {request.n} has no scatter to test against: give 2 or more.")
    if request.method not in tuple(PlanMethod):
        raise unknown_name("method", request.method, tuple(PlanMethod))
