"""The demonstration campaign's calendar: which run is made on which day, and in which order.

Follows the thesis, 5.1.3: larger foot and stiffer gain first, by and large; within that, blocks of all
conditions in random order; at least one control for each foot and gain of a day; days not consecutive.
"""

from __future__ import annotations

import datetime as dt
from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from data_schema.errors import UsageError
from data_schema.vocabulary import RunKind
from labbook.demo.truth import CONTROL_GAIN, Condition, Truth

FIRST_DAY = dt.date(2021, 6, 14)
IDLE_MINUTES = (20, 24, 30, 40, 50, 60)
"""Durations of the idle runs (thesis 5.1.4)."""

_RUNS_A_DAY = 14
_DAY_STEPS = (1, 1, 1, 2, 2, 3, 4)
_SATURDAY = 5


@dataclass(frozen=True, slots=True)
class Slot:
    """One run to be made: a condition, an idle run of some minutes, or the force-plate characterisation."""

    kind: RunKind
    condition: Condition | None = None
    idle_minutes: int | None = None


@dataclass(frozen=True, slots=True)
class Day:
    """One day of the campaign: its date and its runs in order."""

    date: dt.date
    slots: tuple[Slot, ...]


@dataclass(slots=True)
class _Part:
    """The runs of one foot and gain within a day, while the calendar is drawn."""

    day: int
    group: tuple[str, int]
    conditions: list[Condition]

    @property
    def controls(self) -> int:
        return sum(condition.is_control for condition in self.conditions)


def draw_calendar(
    rng: np.random.Generator, truth: Truth, runs_per_condition: int, extra_controls: int
) -> tuple[Day, ...]:
    """Draw the whole campaign: every condition `runs_per_condition` times and `extra_controls` more controls.

    Raises `UsageError` when a day would lack a control because there are too few extra ones.
    """
    parts = _parts(rng, truth, runs_per_condition)
    _add_controls(rng, parts, extra_controls)
    n_days = parts[-1].day + 1
    slots: list[list[Slot]] = [[] for _ in range(n_days)]
    for part in parts:
        slots[part.day] += [Slot(RunKind.JUMPS, condition) for condition in part.conditions]
    # Idle runs end the day: 20 to 60 minutes of waiting while the next day is prepared.
    idle_days = np.linspace(0, n_days - 1, len(IDLE_MINUTES)).round().astype(int)
    for day, minutes in zip(idle_days, rng.permutation(IDLE_MINUTES), strict=True):
        slots[day].append(Slot(RunKind.IDLE, idle_minutes=int(minutes)))
    first = truth.groups[0]
    slots[-1].append(Slot(RunKind.CHARACTERISATION, Condition(first.foot, first.k_gain, CONTROL_GAIN)))
    return tuple(Day(date, tuple(day_slots)) for date, day_slots in zip(_dates(rng, n_days), slots, strict=True))


def _parts(rng: np.random.Generator, truth: Truth, runs_per_condition: int) -> list[_Part]:
    """Blocks of all conditions of a foot and gain, end to end, cut into days of about equal length."""
    queue = [
        Condition(group.foot, group.k_gain, int(gain))
        for group in truth.groups
        for _ in range(runs_per_condition)
        for gain in rng.permutation((CONTROL_GAIN, *truth.ad_gains))
    ]
    n_days = max(1, round(len(queue) / _RUNS_A_DAY))
    cuts = np.linspace(0, len(queue), n_days + 1).round().astype(int)
    cuts[1:-1] += rng.integers(-2, 3, n_days - 1)
    parts: list[_Part] = []
    for day, (start, stop) in enumerate(pairwise(cuts)):
        for condition in queue[start:stop]:
            group = (condition.foot, condition.k_gain)
            if not parts or (parts[-1].day, parts[-1].group) != (day, group):
                parts.append(_Part(day, group, []))
            parts[-1].conditions.append(condition)
    return parts


def _add_controls(rng: np.random.Generator, parts: list[_Part], extra_controls: int) -> None:
    """Put the extra controls where a day has none, then wherever a foot and gain has fewest."""
    without = [part for part in parts if part.controls == 0]
    if len(without) > extra_controls:
        raise UsageError(
            f"{extra_controls} extra controls are too few: {len(without)} days would lack a control; "
            f"give at least {len(without)}."
        )
    given: Counter[tuple[str, int]] = Counter()
    for number in range(extra_controls):
        if number < len(without):
            part = without[number]
        else:
            part = min(parts, key=lambda part: (given[part.group], part.controls / len(part.conditions)))
        given[part.group] += 1
        control = Condition(*part.group, CONTROL_GAIN)
        part.conditions.insert(int(rng.integers(len(part.conditions) + 1)), control)


def _dates(rng: np.random.Generator, n_days: int) -> list[dt.date]:
    """Working days, not consecutive, from the first day on."""
    dates = [FIRST_DAY]
    while len(dates) < n_days:
        date = dates[-1] + dt.timedelta(days=int(rng.choice(_DAY_STEPS)))
        while date.weekday() >= _SATURDAY:
            date += dt.timedelta(days=1)
        dates.append(date)
    return dates
