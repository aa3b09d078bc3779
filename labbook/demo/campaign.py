"""The demonstration campaign drawn from its generative model (`docs/demonstration.md`), with its calendar.

The same seed gives the same campaign, and through `labbook.demo.files` the same bytes. Which run is made on which day
follows the thesis, 5.1.3: larger foot and stiffer gain first, by and large; within that, blocks of all conditions in
random order; at least one control for each foot and gain of a day; days not consecutive.
"""

from __future__ import annotations

import datetime as dt
from collections import Counter
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from data_schema.errors import UsageError
from data_schema.vocabulary import RunKind
from labbook.demo.truth import CHAPTER_5, CONTROL_GAIN, Condition, Truth
from labbook.demo.writers import Correction, SheetRun


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DemoRun(SheetRun):
    """One run as it truly was, with what the instruments measured of it.

    `apex_heights_m` and `misfired` have one element a jump made; the apex of a misfired jump was never reached.
    Idle and characterisation runs have no elements in either.
    """

    condition: Condition | None
    apex_heights_m: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    misfired: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))

    @property
    def reached_apexes_m(self) -> NDArray[np.float64]:
        """True apex heights of the jumps that left the ground, in order."""
        return self.apex_heights_m[~self.misfired]


@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """The whole campaign: truth, runs in the order they were made, and the corrections to make."""

    seed: int
    truth: Truth
    runs: tuple[DemoRun, ...]
    corrections: tuple[Correction, ...]

    def of_kind(self, kind: RunKind) -> tuple[DemoRun, ...]:
        """Return the runs of one kind, in order."""
        return tuple(run for run in self.runs if run.kind is kind)


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


def draw_calendar(rng: Generator, truth: Truth, runs_per_condition: int, extra_controls: int) -> tuple[Day, ...]:
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


def _parts(rng: Generator, truth: Truth, runs_per_condition: int) -> list[_Part]:
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


def _add_controls(rng: Generator, parts: list[_Part], extra_controls: int) -> None:
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


def _dates(rng: Generator, n_days: int) -> list[dt.date]:
    """Working days, not consecutive, from the first day on."""
    dates = [FIRST_DAY]
    while len(dates) < n_days:
        date = dates[-1] + dt.timedelta(days=int(rng.choice(_DAY_STEPS)))
        while date.weekday() >= _SATURDAY:
            date += dt.timedelta(days=1)
        dates.append(date)
    return dates


JUMPS_PER_RUN = 25
BATTERIES = ("A", "B", "C")
_PLATE_HOPS = 80
"""Hops of the force-plate characterisation (thesis 3.2.2)."""

_MISFIRE_CHANCE = 0.015
_EARLY_STOP_CHANCE = 0.02
_STARTS_CHANCES = (0.86, 0.11, 0.03)
_CHARGER_MAH_PER_MINUTE = 1000 / 60
_BALANCING_MINUTES = 3


def make_campaign(
    seed: int,
    *,
    truth: Truth = CHAPTER_5,
    runs_per_condition: int = 10,
    extra_controls: int = 24,
    jumps_per_run: int = JUMPS_PER_RUN,
) -> Campaign:
    """Draw a campaign; the defaults give chapter 5's 264 runs and seven more (six idle, one on a force plate).

    Raises `UsageError` when `extra_controls` cannot give every day its controls.
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, 0]))
    days = draw_calendar(rng, truth, runs_per_condition, extra_controls)
    runs: list[DemoRun] = []
    for number, day in enumerate(days):
        rested = number == 0 or (day.date - days[number - 1].date).days > 1
        runs += _day_runs(rng, truth, day, len(runs), jumps_per_run, rested)
    return Campaign(seed, truth, tuple(runs), _wrong_foot(rng, runs))


def _day_runs(rng: Generator, truth: Truth, day: Day, n_before: int, jumps_per_run: int, rested: bool) -> list[DemoRun]:
    """The runs of one day, one after another, the packs in turn; times are local."""
    day_joules = rng.normal(0, truth.scatter.day_joules_per_jump)
    day_apex_m = rng.normal(0, truth.scatter.day_apex_m)
    clock = dt.datetime.combine(day.date, dt.time(9, 10 + int(rng.integers(0, 40))))
    runs = []
    for position, slot in enumerate(day.slots, start=1):
        above_passive_mah, notes, drawn = _draw(rng, truth, slot, jumps_per_run, day_joules, day_apex_m)
        if position == 1:
            cycled = ", packs cycled with 30 jumps first" if rested else ""
            notes.insert(0, f"rail within 1 degree, rod oiled{cycled}")
        nominal_s = truth.run_duration_s if slot.idle_minutes is None else 60 * slot.idle_minutes
        duration_s = int(nominal_s + rng.integers(-2, 5))
        charge_mah = truth.drain.charge_mah(duration_s) + above_passive_mah
        charge_mah += rng.normal(0, truth.scatter.recharge_mah)
        recharge_minutes = int(np.ceil(charge_mah / _CHARGER_MAH_PER_MINUTE)) + _BALANCING_MINUTES
        off = (clock + dt.timedelta(seconds=duration_s)).replace(second=0)
        runs.append(
            DemoRun(
                name=f"r{n_before + position:03d}",
                position=position,
                kind=slot.kind,
                levels={} if slot.condition is None else asdict(slot.condition),
                condition=slot.condition,
                battery=BATTERIES[(position - 1) % len(BATTERIES)],
                started=clock,
                duration_s=duration_s,
                note="; ".join(notes),
                charge_mah=round(charge_mah),
                recharge_minutes=recharge_minutes,
                recharge_ended=off + dt.timedelta(minutes=recharge_minutes + 1),
                end_voltage_v=round(truth.reference_voltage_v + rng.normal(0, 0.01), 2),
                **drawn,
            )
        )
        clock = off + dt.timedelta(minutes=int(rng.integers(9, 16)))
    return runs


def _draw(
    rng: Generator,
    truth: Truth,
    slot: Slot,
    jumps_per_run: int,
    day_joules: float,
    day_apex_m: float,
) -> tuple[float, list[str], dict[str, Any]]:
    """Draw what a slot's kind of run does beyond hanging on its clamp: its charge, remarks, and facts by field."""
    if slot.condition is None:
        return 0.0, ["hanging from the clamp, motors off"], {"jumps_made": 0}
    if slot.kind is RunKind.CHARACTERISATION:
        charge_mah = _PLATE_HOPS * truth.jump_charge_mah(truth.joules_per_jump(slot.condition))
        return charge_mah, ["force plate, rigid ground, synthetic"], {"jumps_made": _PLATE_HOPS}
    return _draw_jumps(rng, truth, slot.condition, jumps_per_run, day_joules, day_apex_m)


def _draw_jumps(
    rng: Generator,
    truth: Truth,
    condition: Condition,
    jumps_per_run: int,
    day_joules: float,
    day_apex_m: float,
) -> tuple[float, list[str], dict[str, Any]]:
    """Charge above passive = jumps made x joules a jump + scatter; a misfired jump costs what any jump does."""
    scatter = truth.scatter
    starts = 1 + int(rng.choice(len(_STARTS_CHANCES), p=_STARTS_CHANCES))
    jumps_made = jumps_per_run
    notes = [f"{starts} starts, leg length read wrong after boot"] if starts > 1 else []
    if rng.random() < _EARLY_STOP_CHANCE:
        jumps_made -= int(rng.integers(1, max(2, jumps_per_run // 4)))
        notes.append(f"stopped after {jumps_made} jumps, string caught on the rail")
    misfired = rng.random(jumps_made) < _MISFIRE_CHANCE
    notes += [f"jump {jump} did not leave the ground" for jump in np.flatnonzero(misfired) + 1]
    run_apex_m = truth.apex_height_m(condition) + day_apex_m + rng.normal(0, scatter.run_apex_m)
    joules = truth.joules_per_jump(condition) + day_joules
    charge_mah = jumps_made * truth.jump_charge_mah(joules) + rng.normal(0, scatter.run_mah)
    apex_heights_m = run_apex_m + rng.normal(0, scatter.jump_apex_m, jumps_made)
    drawn = {"jumps_made": jumps_made, "starts": starts, "apex_heights_m": apex_heights_m, "misfired": misfired}
    return charge_mah, notes, drawn


def _wrong_foot(rng: Generator, runs: list[DemoRun]) -> tuple[Correction, ...]:
    """One active-damping run that is entered in the run sheet with another foot, where there is another."""
    feet = {run.name: run.condition.foot for run in runs if run.condition is not None}
    candidates = [
        run.name
        for run in runs
        if run.kind is RunKind.JUMPS and run.condition is not None and not run.condition.is_control
    ]
    name = candidates[int(rng.integers(len(candidates)))]
    others = sorted(set(feet.values()) - {feet[name]})
    why = "typed wrong: the day's photograph shows the other foot"
    return tuple(Correction(name, "foot", other, feet[name], why) for other in others[:1])
