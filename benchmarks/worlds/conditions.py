"""Conditions of simulated campaigns in the form in which the analysis has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from data_schema.queries.runs import RunRow
from data_schema.vocabulary import RunKind, RunState
from labbook.analysis.outcomes.conditions import ConditionSummary, ConditionValues, RunNumber
from reports.numbers import Number, Result
from stats.compare.shared_error import SharedError

_NONE = Number(0.0, "1")


def condition(
    levels: Mapping[str, str],
    values: Sequence[float],
    days: Sequence[str],
    *,
    is_control: bool,
    positions: Sequence[int] | None = None,
) -> ConditionValues:
    """Return a condition whose runs have these values, days and positions in the day."""
    key = " ".join(f"{name}={label}" for name, label in levels.items())
    runs = tuple(
        RunNumber(
            run_row(f"{key} {at}", day, levels, is_control=is_control, position=position),
            float(value),
            SharedError(),
            Result(),
        )
        for at, (value, day, position) in enumerate(zip(values, days, positions or range(len(days)), strict=True))
    )
    return ConditionValues(key, is_control, levels, runs, ConditionSummary(_NONE, _NONE, ()))


def run_row(
    name: str,
    day: str,
    levels: Mapping[str, str],
    *,
    is_control: bool,
    position: int = 1,
    duration_s: float | None = None,
    jumps: int = 25,
) -> RunRow:
    """Return a drawn run as a book has it."""
    key = " ".join(f"{name}={label}" for name, label in levels.items())
    return RunRow(
        uid=name, name=name, kind=RunKind.JUMPS, state=RunState.COMPLETE, day=day, position_in_day=position,
        condition_uid=key, condition_key=key, is_control=is_control, levels=levels, robot="hopper", robot_uid="hopper",
        battery="A", started_utc=None, duration_s=duration_s, jumps_made=jumps, starts=1, planned=True,
    )  # fmt: skip
