"""Conditions of simulated campaigns in the form in which the analysis has them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from data_schema.queries.runs import RunRow
from data_schema.vocabulary import RunKind, RunState
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from reports.numbers import Number, Result
from reports.results import ConditionSummary
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
    rows = (
        run_row(f"{levels} {at}", day, levels, is_control=is_control, position=position)
        for at, (day, position) in enumerate(zip(days, positions or range(len(days)), strict=True))
    )
    (found,) = conditions_of([run_number(row, value) for row, value in zip(rows, values, strict=True)])
    return found


def conditions_of(runs: Iterable[RunNumber]) -> list[ConditionValues]:
    """Return runs by condition, in the order in which the conditions come."""
    by_condition: dict[str, list[RunNumber]] = {}
    for one in runs:
        by_condition.setdefault(one.run.condition_key, []).append(one)
    return [
        ConditionValues(key, own[0].run.is_control, own[0].run.levels, tuple(own), ConditionSummary(_NONE, _NONE, ()))
        for key, own in by_condition.items()
    ]


def run_number(row: RunRow, value: float, shared: SharedError | None = None) -> RunNumber:
    """Return the number of a run, with the error that it has in common with others."""
    return RunNumber(row, float(value), shared or SharedError(), Result())


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
