"""A charger that shows mAh in steps, some of them coarser than what its charges scatter by."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.worlds.conditions import conditions_of, run_row
from benchmarks.worlds.world import Campaign, World, holds_truth
from data_schema.outcomes import Outcome
from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import ChargeMode, Undefined
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.charger_step import with_display_step
from labbook.analysis.outcomes.conditions import coarse_scatter, run_numbers
from labbook.analysis.outcomes.run_energy import energies_with_drains
from stats.lines.passive_drain import fit_passive_drain

_SAVED = 0.05
_LEAST_MAH, _MOST_MAH = 20.0, 40.0
_DRAIN_MAH_MIN, _RUN_MIN, _JUMPS, _VOLTAGE_V = 0.6, 5.0, 25, 15.4
_IDLE_MIN = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0)
_CONTROL, _TREATED = "0", "100"
_RUNS_A_DAY = {_CONTROL: 3, _TREATED: 5}


def _run(name: str, day: int, level: str) -> RunRow:
    of_day = f"2021-03-{day + 1:02d}"
    return run_row(
        name, of_day, {"b_ad": level}, is_control=level == _CONTROL, duration_s=60.0 * _RUN_MIN, jumps=_JUMPS
    )


def _charge(run: str, mah: float, step_mah: float) -> list[ChargeOfRun]:
    """Return a charge as its display shows it, which a person copies: whole mAh, or with one decimal."""
    shown, typed = round(round(mah / step_mah) * step_mah, 1), min(1.0, step_mah)
    return [ChargeOfRun(run, run, shown, typed, None, None, ChargeMode.CHARGE, None, None, None, added=False)]


def _simulate(generator: np.random.Generator, step_mah: float, run_sd: float, day_sd: float, days: int) -> Campaign:
    mean_mah = generator.uniform(_LEAST_MAH, _MOST_MAH)
    idle = {f"idle {minutes:g}": minutes for minutes in _IDLE_MIN}
    charges = {
        name: _charge(name, _DRAIN_MAH_MIN * minutes + generator.normal(0.0, 0.05), step_mah)
        for name, minutes in idle.items()
    }
    runs = []
    for day in range(days):
        of_day = 1.0 + day_sd * generator.standard_normal()
        for level, count in _RUNS_A_DAY.items():
            mah = mean_mah * of_day * (1.0 - _SAVED if level == _TREATED else 1.0)
            for number in range(count):
                run = _run(f"{level}, {day}, {number}", day, level)
                drawn = mah * (1.0 + run_sd * generator.standard_normal()) + _DRAIN_MAH_MIN * _RUN_MIN
                charges[run.name] = _charge(run.name, drawn, step_mah)
                runs.append(run)
    charges = with_display_step(charges, None)
    of_idle = [charges[name][0] for name in idle]
    line = fit_passive_drain(
        [60.0 * minutes for minutes in _IDLE_MIN], [one.charge_mah for one in of_idle], of_idle[0].resolution_mah
    )
    numbers = run_numbers(runs, energies_with_drains(runs, charges, {"hopper": line}, _VOLTAGE_V), Outcome.JOULES)
    control, treated = conditions_of(numbers)
    found = contrast_of(Pair("", "", {}, "", (control,), (treated,))).savings()
    finds = not isinstance(found.p, Undefined) and found.p <= 0.05
    return Campaign(holds_truth(found.ci, 100.0 * _SAVED), finds, coarse_scatter(numbers) is not None)


def _worlds() -> Iterator[World]:
    cases = [
        *((step, sd, 0.0, days) for days in (2, 5) for step in (10.0, 1.0, 0.1) for sd in (3.0, 0.5)),
        *((1.0, 0.5, 6.0, days) for days in (2, 5)),
    ]
    for step_mah, run_sd, day_sd, days in cases:
        # By days from four days on: what days differ by makes rounding independent, too
        scatter_percent = run_sd if days < 4 else float(np.hypot(run_sd, day_sd))
        of_days = f", of days {day_sd:g} %" if day_sd else ""
        yield World(
            f"charger's steps {step_mah:g} mAh, SD of runs {run_sd:g} %{of_days}, {days} days",
            "5 %",
            scatter_percent / 100.0 * _MOST_MAH < 0.5 * step_mah,
            partial(_simulate, step_mah=step_mah, run_sd=run_sd / 100.0, day_sd=day_sd / 100.0, days=days),
        )


WORLDS = tuple(_worlds())
