"""The emulator study in a closed loop: campaigns with a known truth, from charges alone and through files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.worlds.conditions import conditions_of, run_number, run_row
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.conditions import RunNumber
from labbook.analysis.outcomes.run_energy import joules_per_mah
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
from labbook.demo.writers import CampaignFiles, SheetRun
from labbook.studies.emulator import SAME_PERCENT, Controller, EmulatorStudy, ask, emulator_study
from labbook.studies.study import Asked, Found, S_co
from stats.compare.shared_error import SharedError
from stats.lines.passive_drain import PassiveDrain, fit_passive_drain

LEVEL = 0.95
SHOWN = ((100.0, Controller.SCALED), (300.0, Controller.CONSTANT), (500.0, Controller.SCALED))


def _pairs(jumps: int) -> Callable[[float, Controller], tuple[Truth, Truth]]:
    """Return what gives the control and the treated condition of a gain."""
    known = {(one.gain, one.damping_gain): one for one in truths(jumps)}

    def pair(gain: float, controller: Controller) -> tuple[Truth, Truth]:
        damping = CONSTANT if controller is Controller.CONSTANT else round(gain / RATIO)
        return known[int(gain), 0], known[int(gain), damping]

    return pair


def true_changes(jumps: int = JUMPS) -> dict[str, float]:
    """Return what is true of the savings and of the apexes lost that are looked at; trends are less the true ones."""
    found, pair = {}, _pairs(jumps)
    for gain, controller in SHOWN:
        control, treated = pair(gain, controller)
        found[_saving(gain, controller)] = 100.0 * (1.0 - treated.joules / control.joules)
        found[_lost(gain, controller)] = 100.0 * (1.0 - treated.apex_m / control.apex_m)
    return {**found, **dict.fromkeys((_trend(one) for one in (Controller.CONSTANT, Controller.SCALED)), 0.0)}


def true_slope(controller: Controller, gains: Sequence[float], jumps: int = JUMPS) -> float:
    """Return the slope of the true savings over the true apexes, which follow no line, at these gains."""
    pairs = [_pairs(jumps)(gain, controller) for gain in gains]
    savings = [100.0 * (1.0 - treated.joules / control.joules) for control, treated in pairs]
    return float(np.polyfit([100.0 * control.apex_m for control, _ in pairs], savings, 1)[0])


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
        is_control = run.levels["b_ad_gain"] == 0
        row = run_row(run.name, run.date.isoformat(), levels, is_control=is_control, duration_s=run.duration_s)
        joules.append(charged(row, run, line, worth_j))
        truth = known[run.levels["k_gain"], run.levels["b_ad_gain"]]
        apexes.append(run_number(row, _apex_m(chance, truth)))
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
    return run_number(row, value_j, drain_error(line, run.duration_s, worth_j))


def ingested(ask: Callable[[Asked], Found[S_co]], files: CampaignFiles) -> S_co:
    """Ingest a campaign's files into a book, and ask the study of it."""
    with TemporaryDirectory() as folder:
        book = make_campaign_book(Path(folder) / "demo", files, lambda _what: None, lambda _line: None)
        return ask(Asked(book)).study


def drain_error(line: PassiveDrain, duration_s: float, worth_j: float) -> SharedError:
    """Return what the error of the drain line makes of a run's joules; `worth_j` is those of 1 mAh."""
    terms = {("drain", term): -worth_j * mah for term, mah in line.error_terms_mah(duration_s).items()}
    return SharedError(terms, {"drain": line.df})
