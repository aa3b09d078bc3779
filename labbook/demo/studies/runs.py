"""What the campaigns of studies with runs have in common: labbook.toml, days of runs and their charges, logs."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from data_schema.vocabulary import RunKind
from labbook.demo.files import STUDY_TOML
from labbook.demo.truth import recharged_mah
from labbook.demo.writers import MARK, Record, SheetRun, string_pot_log

RUNS_TOML = (
    """\
# Demonstration: the {study} study of the thesis ({section}), simulated with known truth (truth.json).
# Nothing in it was measured. What it says is described in docs/{study}.md.

"""
    + STUDY_TOML
    + """\
[factors.k_gain]
kind = "number"
title = "extension stiffness"
levels = {gains}

{protocol}
detector = "robust"
exclude_gap_jumps = true
charger_resolution_mah = 1
idle_minutes = {idle_minutes}

[gains.k_gain]
symbol = "k"
slope = 2.56
offset = 67.36
unit = "N/m"

[robots.hopper]
body_mass_kg = {body_mass_kg}
foot_mass_kg = 0.175
link_1_m = 0.1
link_2_m = 0.2
rest_length_m = {rest_length_m}
leg_min_m = 0.1
leg_max_m = 0.3

[batteries.A]
cells = 4
capacity_mah = {capacity_mah}

"""
)
C = TypeVar("C")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StudyRun(SheetRun):
    """A run of a campaign.

    The log's channels, by name with unit, have one element a recorded sample of `log_ms`.
    """

    log_ms: NDArray[np.int64] | None = None
    channels: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)


R = TypeVar("R", bound=StudyRun)


@dataclass(frozen=True, slots=True)
class StudyScatter:
    """Standard deviations of what the battery gives: as shares by day and by run, and of each recharge."""

    day: float
    run: float
    recharge_mah: float = 0.35


@dataclass(frozen=True, slots=True)
class Made:
    """Jumps that a run made: its factors' levels, how long it took, joules of all jumps, and what was recorded of it,
    by field of the run, drawn after its charge.
    """

    levels: Mapping[str, int]
    jumps: int
    duration_s: int
    joules: float
    record: Callable[[], Mapping[str, Any]]


def drawn_days(
    rng: Generator,
    kind: Callable[..., R],
    scatter: StudyScatter,
    dates: Sequence[dt.date],
    idle_s: tuple[int, int],
    voltage_v: float,
    order: Callable[[], Sequence[C]],
    make: Callable[[C, float], Made],
) -> list[R]:
    """Draw days of runs, 25 minutes apart: the day's conditions in their order, between two idle runs.

    `make` is given a condition and the share by which the day's joules are larger.
    """
    runs: list[R] = []
    for date in dates:
        of_day = rng.normal(0.0, scatter.day)
        for position, condition in enumerate((None, *order(), None), start=1):
            if condition is None:
                made = Made({}, 0, idle_s[position > 1] + int(rng.integers(-2, 3)), 0.0, dict)
            else:
                made = make(condition, of_day)
            charge_mah = recharged_mah(rng, made.duration_s, made.joules, voltage_v, scatter.recharge_mah)
            started = dt.datetime.combine(date, dt.time(9, 0)) + (position - 1) * dt.timedelta(minutes=25)
            minutes = charge_mah // 16 + 4
            ended = started + dt.timedelta(seconds=made.duration_s, minutes=minutes + 1)
            runs.append(
                kind(
                    name=f"r{len(runs) + 1:03d}",
                    started=started,
                    position=position,
                    kind=RunKind.JUMPS if made.jumps else RunKind.IDLE,
                    levels=made.levels,
                    duration_s=made.duration_s,
                    jumps_made=made.jumps,
                    note="synthetic" if made.jumps else "held, motors off",
                    charge_mah=charge_mah,
                    recharge_minutes=minutes,
                    recharge_ended=ended.replace(second=0),
                    end_voltage_v=voltage_v,
                    **made.record(),
                )
            )
    return runs


def samples_not_dropped(rng: Generator, n: int, dropped: int, longest: int, first: int = 0) -> NDArray[np.bool_]:
    """Draw which samples of a log arrive where so many packets are dropped, none before the sample `first`."""
    recorded = np.ones(n, dtype=np.bool_)
    for _ in range(dropped):
        start = int(rng.integers(first, n))
        recorded[start : start + int(rng.integers(2, longest + 1))] = False
    return recorded


def logs_of(runs: Iterable[StudyRun], decimals: Mapping[str, int]) -> Iterator[Record]:
    """Write the logs that runs have."""
    for run in runs:
        if run.log_ms is not None:
            yield Record(f"logs/{run.name}_{MARK}.csv", string_pot_log(run.log_ms, run.channels, decimals))
