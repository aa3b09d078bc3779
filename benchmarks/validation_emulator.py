"""The emulator study in a closed loop: campaigns with a known truth, from charges alone and through files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.worlds.conditions import run_row
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.conditions import ConditionSummary, ConditionValues, RunNumber
from labbook.analysis.outcomes.run_energy import joules_per_mah
from labbook.demo.records import CampaignFiles
from labbook.demo.running import make_campaign_book
from labbook.demo.studies.emulator import (
    CONSTANT,
    JUMPS,
    RATIO,
    REST_LENGTH_M,
    RUN_HEIGHT,
    VOLTAGE_V,
    Truth,
    emulator_campaign,
    emulator_files,
    truths,
)
from labbook.demo.writers import SheetRun
from labbook.studies.emulator import SAME_PERCENT, Controller, EmulatorStudy, ask, emulator_study
from labbook.studies.study import Asked, Found, S_co
from reports.numbers import Number, Result
from stats.compare.shared_error import SharedError
from stats.lines.passive_drain import PassiveDrain, fit_passive_drain

LEVEL = 0.95
SHOWN = ((100.0, Controller.SCALED), (300.0, Controller.CONSTANT), (500.0, Controller.SCALED))


def true_changes(jumps: int = JUMPS) -> dict[str, float]:
    """Return what is true of the savings and of the apexes lost that are looked at; trends are less the true ones."""
    known = {(one.gain, one.damping_gain): one for one in truths(jumps)}
    found = {}
    for gain, controller in SHOWN:
        damping = CONSTANT if controller is Controller.CONSTANT else round(gain / RATIO)
        control, treated = known[int(gain), 0], known[int(gain), damping]
        found[_saving(gain, controller)] = 100.0 * (1.0 - treated.joules / control.joules)
        found[_lost(gain, controller)] = 100.0 * (1.0 - treated.apex_m / control.apex_m)
    return {**found, **dict.fromkeys((_trend(one) for one in (Controller.CONSTANT, Controller.SCALED)), 0.0)}


def true_slope(controller: Controller, gains: Sequence[float], jumps: int = JUMPS) -> float:
    """Return the slope of the true savings over the true apexes, which follow no line, at these gains."""
    known = {(one.gain, one.damping_gain): one for one in truths(jumps)}
    apex_cm, savings = [], []
    for gain in map(int, gains):
        control = known[gain, 0]
        treated = known[gain, CONSTANT if controller is Controller.CONSTANT else round(gain / RATIO)]
        apex_cm.append(100.0 * control.apex_m)
        savings.append(100.0 * (1.0 - treated.joules / control.joules))
    return float(np.polyfit(apex_cm, savings, 1)[0])


def _saving(gain: float, controller: Controller) -> str:
    return f"saving, {controller}, gain {gain:g}"


def _trend(controller: Controller) -> str:
    return f"trend, {controller}"


def _lost(gain: float, controller: Controller) -> str:
    return f"apex lost, {controller}, gain {gain:g}"


def intervals(study: EmulatorStudy) -> Mapping[str, tuple[float, float] | Undefined]:
    """Return the intervals that are looked at."""
    found: dict[str, tuple[float, float] | Undefined] = {}
    for row in study.gains:
        saving, loss = row.saving_percent, row.apex_loss_percent
        if (row.gain, row.controller) in SHOWN and saving is not None and loss is not None:
            found[_saving(row.gain, row.controller)] = saving.ci
            found[_lost(row.gain, row.controller)] = loss.ci
    for trend in study.trends:
        ci = None if trend.line is None else trend.line.slope.ci
        if trend.line is not None and isinstance(ci, tuple):
            true = true_slope(trend.controller, [*map(float, trend.line.groups)])
            found[_trend(trend.controller)] = ci[0] - true, ci[1] - true
    return found


def emulator_book(chance: np.random.Generator) -> EmulatorStudy:
    """Draw the campaign through files and ingest."""
    return ingested(ask, emulator_files(emulator_campaign(int(chance.integers(2**31)))))


def from_charges(chance: np.random.Generator, jumps: int = JUMPS) -> EmulatorStudy:
    """Draw what the charger says, and run means of apexes, without files."""
    campaign = emulator_campaign(int(chance.integers(2**31)), jumps=jumps, logs=False)
    idle = [(run.duration_s, run.charge_mah) for run in campaign if not run.levels]
    line = fit_passive_drain([seconds for seconds, _ in idle], [mah for _, mah in idle], resolution_mah=1.0)
    worth_j = joules_per_mah(VOLTAGE_V, jumps)
    known = {(one.gain, one.damping_gain): one for one in truths(jumps)}
    joules, apexes = [], []
    for run in campaign:
        if not run.levels:
            continue
        levels = {factor: str(level) for factor, level in run.levels.items()}
        row = run_row(
            run.name,
            run.date.isoformat(),
            levels,
            is_control=run.levels["b_ad_gain"] == 0,
            duration_s=run.duration_s,
        )
        joules.append(charged(row, run, line, worth_j))
        apexes.append(
            RunNumber(
                row,
                _apex_m(chance, known[run.levels["k_gain"], run.levels["b_ad_gain"]]),
                SharedError(),
                Result(),
            )
        )
    conditions = {Outcome.JOULES: conditions_of(joules), Outcome.APEX: conditions_of(apexes)}
    return emulator_study(
        conditions,
        "k_gain",
        "b_ad_gain",
        constant=CONSTANT,
        ratio=RATIO,
        same_percent=SAME_PERCENT,
        resolution_j=worth_j,
        level=LEVEL,
    )


def _apex_m(chance: np.random.Generator, truth: Truth) -> float:
    return truth.apex_m + chance.normal(0.0, RUN_HEIGHT) * (truth.apex_m - REST_LENGTH_M)


def charged(row: RunRow, run: SheetRun, line: PassiveDrain, worth_j: float) -> RunNumber:
    """Return a run's joules as the charger reads them."""
    value_j = worth_j * (run.charge_mah - line.at(run.duration_s).charge_mah)
    return RunNumber(row, value_j, drain_error(line, run.duration_s, worth_j), Result())


def ingested(ask: Callable[[Asked], Found[S_co]], files: CampaignFiles) -> S_co:
    """Ingest a campaign's files into a book, and ask the study of it."""
    with TemporaryDirectory() as folder:
        book = make_campaign_book(Path(folder) / "demo", files, lambda _what: None, lambda _line: None)
        return ask(Asked(book)).study


def drain_error(line: PassiveDrain, duration_s: float, worth_j: float) -> SharedError:
    """Return what the error of the drain line makes of a run's joules; `worth_j` is those of 1 mAh."""
    terms = {("drain", term): -worth_j * mah for term, mah in line.error_terms_mah(duration_s).items()}
    return SharedError(terms, {"drain": line.df})


def conditions_of(runs: Sequence[RunNumber]) -> list[ConditionValues]:
    """Return runs by condition."""
    by_condition: dict[str, list[RunNumber]] = {}
    for one in runs:
        by_condition.setdefault(one.run.condition_key, []).append(one)
    none = Number(0.0, "1")
    return [
        ConditionValues(key, own[0].run.is_control, own[0].run.levels, tuple(own), ConditionSummary(none, none, ()))
        for key, own in by_condition.items()
    ]
