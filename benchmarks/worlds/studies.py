"""Campaigns of the studies beside the jumps: force plate, emulator, flasks of grains, oscillating legs."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.signal
from numpy.typing import NDArray

from benchmarks.worlds.conditions import conditions_of, run_number, run_row
from benchmarks.worlds.world import Campaign, World, holds_truth
from data_schema.outcomes import Outcome
from ingest.formats.study_sheets import StudySheet
from labbook.analysis.outcomes.conditions import RunNumber
from labbook.demo.studies.sheets import POSITION_SD_M, STIFFNESS, VELOCITY_SD_M_S, oscillations
from labbook.studies.characterisation import TOGETHER, characterisation
from labbook.studies.compaction import CURVED_P, compaction
from labbook.studies.emulator import SAME_POINTS, Controller, emulator_study
from stats.lines.regression import slope_through_origin

_SLOPE, _JOULES = 1.06, (45.0, 57.0, 63.4, 67.1)


def _plate(runs_of_days: Sequence[int], of_day: float) -> World:
    """Runs of four gains in turn; days and runs scatter by these shares."""

    def simulate(chance: np.random.Generator) -> Campaign:
        days = np.repeat(np.arange(len(runs_of_days)), runs_of_days)
        measured_j = np.resize(_JOULES, days.size)
        shares = 1.0 + chance.normal(0.0, of_day, len(runs_of_days))[days] + chance.normal(0.0, 0.01, days.size)
        found = slope_through_origin(measured_j, _SLOPE * measured_j * shares, days.tolist())
        covers = holds_truth(found.ci, _SLOPE)
        return Campaign(covers, finds=holds_truth(found.ci, 1.0) is False, warns=False)

    name = f"force plate, days of {', '.join(map(str, runs_of_days))} runs, days scatter by {100.0 * of_day:g} %"
    return World(name, f"slope {_SLOPE:g}", warning_needed=False, simulate=simulate)


_APEX_CM = {200: 34.7, 300: 41.8, 400: 46.1, 500: 48.0}
_CE_J = {200: 9.0, 300: 12.0, 400: 14.0, 500: 15.0}
_RANGE_CM = _APEX_CM[500] - _APEX_CM[200]


def _emulator(days: int, what: str, savings: Sequence[float]) -> World:
    """One run of each condition a day; days scatter by 1 %, runs by 1.5 %, apexes by 2 mm.

    It finds that there is none; where the line changes by the bound or more, it has to say that one is not excluded.
    """
    slope = float(np.polyfit([*_APEX_CM.values()], savings, 1)[0])
    change = slope * _RANGE_CM
    is_trend = change > SAME_POINTS - 1e-9

    def simulate(chance: np.random.Generator) -> Campaign:
        runs: dict[Outcome, list[RunNumber]] = {Outcome.JOULES: [], Outcome.APEX: []}
        for day in range(days):
            of_day = 1.0 + chance.normal(0.0, 0.01)
            for saving, (gain, ce_j) in zip(savings, _CE_J.items(), strict=True):
                for damping in (0, 50):
                    levels = {"k_gain": str(gain), "b_ad_gain": str(damping)}
                    date = dt.date(2020, 1, 1) + dt.timedelta(days=day)
                    row = run_row(
                        f"{day}-{gain}-{damping}", date.isoformat(), levels, is_control=not damping, duration_s=60.0
                    )
                    joules = ce_j * (1.0 - 0.01 * saving * (damping > 0)) * of_day * (1.0 + chance.normal(0.0, 0.015))
                    apex_m = 0.01 * _APEX_CM[gain] + chance.normal(0.0, 0.002)
                    for outcome, value in ((Outcome.JOULES, joules), (Outcome.APEX, apex_m)):
                        runs[outcome].append(run_number(row, value))
        study = emulator_study(
            {outcome: conditions_of(of_it) for outcome, of_it in runs.items()},
            "k_gain",
            "b_ad_gain",
            constant=50.0,
            ratio=0.1,
            same_percent=0.5,
            resolution_j=0.0,
            level=0.95,
        )
        (line,) = (trend.line for trend in study.trends if trend.controller is Controller.CONSTANT)
        assert line is not None
        none = line.change.equivalent is True
        return Campaign(holds_truth(line.slope.ci, slope), finds=none, warns=is_trend and not none)

    return World(f"emulator, {days} days, savings {what}", f"{abs(change):.1f} points", is_trend, simulate)


_RADII_M, _GRAIN_M = (0.02, 0.025, 0.035, 0.05, 0.07), 0.0034
_FRACTIONS = {"loose": (0.61, -0.25), "compacted": (0.63, -0.2)}


def _flasks(curvature: float, radii_m: Sequence[float]) -> World:
    """Flasks err by 0.002 and fillings by 0.0015; the wall's effect has this quadratic term.

    It finds that the compacted grains lie more densely, and warns that the fractions follow no line.
    """

    def simulate(chance: np.random.Generator) -> Campaign:
        of_flasks = chance.normal(0.0, 0.002, len(radii_m))
        rows = []
        for state, (fraction, wall) in _FRACTIONS.items():
            x = _GRAIN_M / np.array(radii_m)
            errors = of_flasks + chance.normal(0.0, 0.0015, x.size)
            values = fraction + wall * x + curvature * x**2 + errors
            rows += [(radius_m, 1.0, 1.0 - value, state, 0) for radius_m, value in zip(radii_m, values, strict=True)]
        radii, flasks, water, states, lines = zip(*rows, strict=True)
        found = compaction(
            StudySheet({"radius": radii, "flask": flasks, "water": water}, {"state": states}, lines), 1e3 * _GRAIN_M
        )
        p = found.curvature_p
        return Campaign(
            holds_truth(found.states[0].curved_ci, _FRACTIONS["loose"][0]),
            finds=holds_truth(found.difference.ci, 0.0) is False,
            warns=isinstance(p, float) and p <= CURVED_P,
        )

    name = f"compaction, {len(radii_m)} flasks, quadratic term {curvature:g}"
    return World(name, "0.61 loose", warning_needed=None if curvature > 0.0 else False, simulate=simulate)


def _leg(what: str, correlation: float, white: float = 0.0) -> World:
    """Two masses on one pair of gains; errors of this correlation along a log, and a share `white` of the variance.

    It warns that residuals go together.
    """
    gain = 200.0

    def errors(chance: np.random.Generator, n: int) -> NDArray[np.float64]:
        drawn = chance.normal(0.0, 1.0, n + 200)
        along = scipy.signal.lfilter([(1.0 - correlation**2) ** 0.5], [1.0, -correlation], drawn)[200:]
        return np.asarray((1.0 - white) ** 0.5 * along + white**0.5 * chance.normal(0.0, 1.0, n))

    def simulate(chance: np.random.Generator) -> Campaign:
        drawn = [
            replace(
                one,
                displacement_m=one.displacement_m + POSITION_SD_M * errors(chance, one.time_s.size),
                velocity_m_s=one.velocity_m_s + VELOCITY_SD_M_S * errors(chance, one.time_s.size),
            )
            for one in oscillations(chance, 0.0, 0.0)
            if one.condition.gain == gain and one.mass_kg < 2.0
        ]
        (found,) = characterisation(drawn).conditions
        covers = holds_truth(found.stiffness_n_m.ci, STIFFNESS[0] * gain + STIFFNESS[1])
        return Campaign(covers, finds=found.stiffness_n_m.ci[0] > 0.0, warns=found.widened > TOGETHER)

    return World(f"characterisation, errors {what}", "579.36 N/m", correlation > 0.0, simulate)


WORLDS = (
    _plate((4, 4, 4, 4), 0.01),
    _plate((8, 4, 2, 2), 0.0),
    _plate((8, 4, 2, 2), 0.01),
    _plate((12, 1, 1, 1), 0.01),
    _plate((8, 4, 4, 2, 2, 1), 0.02),
    _leg("independent", 0.0),
    _leg("with a lag-1 correlation of 0.8", 0.8),
    _leg("half white, half slow", 0.95, white=0.5),
    _flasks(0.0, _RADII_M),
    _flasks(0.5, _RADII_M),
    _flasks(1.0, np.geomspace(0.015, 0.08, 12).tolist()),
    _emulator(4, "alike", (14.0,) * 4),
    _emulator(10, "alike", (14.0,) * 4),
    _emulator(4, "on a curve", (8.6, 17.5, 16.5, 14.7)),
    _emulator(10, "at the bound of none", tuple(12.0 + 3.0 * (x - 34.7) / _RANGE_CM for x in _APEX_CM.values())),
)
