"""The emulator study in a closed loop: campaigns with a known truth, from charges alone and through files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import RunKind, RunState, Undefined
from labbook.actions.studies.emulator import emulator_study_of
from labbook.analysis.outcomes.conditions import ConditionSummary, ConditionValues, RunNumber
from labbook.analysis.outcomes.energy import joules_per_mah
from labbook.analysis.results.codec import StoredResult
from labbook.analysis.studies.emulator import Controller, EmulatorStudy, emulator_study
from labbook.demo.studies.emulator import (
    CONSTANT,
    JUMPS,
    RATIO,
    REST_LENGTH_M,
    VOLTAGE_V,
    EmulatorRun,
    EmulatorScatter,
    Truth,
    emulator_campaign,
    truths,
)
from labbook.demo.studies.emulator_files import make_emulator_book
from reports.numbers import Number
from stats.compare.shared_error import SharedError
from stats.lines.passive_drain import fit_passive_drain

LEVEL, SAME_PERCENT = 0.95, 2.0
SHOWN = ((100.0, Controller.SCALED), (300.0, Controller.CONSTANT), (500.0, Controller.SCALED))


def true_changes(jumps: int = JUMPS) -> dict[str, float]:
    """Return what is true of the savings and of the apexes lost that are looked at."""
    known = {(one.gain, one.damping_gain): one for one in truths(jumps)}
    found = {}
    for gain, controller in SHOWN:
        damping = CONSTANT if controller is Controller.CONSTANT else round(gain / RATIO)
        control, treated = known[int(gain), 0], known[int(gain), damping]
        found[_saving(gain, controller)] = 100.0 * (1.0 - treated.joules / control.joules)
        found[_lost(gain, controller)] = 100.0 * (1.0 - treated.apex_m / control.apex_m)
    return found


def _saving(gain: float, controller: Controller) -> str:
    return f"saving, {controller}, gain {gain:g}"


def _lost(gain: float, controller: Controller) -> str:
    return f"apex lost, {controller}, gain {gain:g}"


def intervals(study: EmulatorStudy) -> Mapping[str, tuple[float, float] | Undefined]:
    """Return the intervals that are looked at."""
    found: dict[str, tuple[float, float] | Undefined] = {}
    for row in study.rows:
        if (row.gain, row.controller) in SHOWN and row.saving is not None and row.apex_loss is not None:
            found[_saving(row.gain, row.controller)] = row.saving.ci
            found[_lost(row.gain, row.controller)] = row.apex_loss.ci
    return found


def emulator_book(chance: np.random.Generator) -> EmulatorStudy:
    """Draw the campaign through files and ingest."""
    campaign = emulator_campaign(int(chance.integers(2**31)))
    with TemporaryDirectory() as folder:
        book = make_emulator_book(Path(folder) / "demo", campaign, lambda _what: None, lambda _line: None)
        return emulator_study_of(book, None, CONSTANT, RATIO, SAME_PERCENT, LEVEL, lambda _what: None).study


def from_charges(chance: np.random.Generator, jumps: int = JUMPS) -> EmulatorStudy:
    """Draw what the charger says, and run means of apexes, without files."""
    campaign = emulator_campaign(int(chance.integers(2**31)), jumps=jumps, logs=False)
    idle = [(run.duration_s, run.charge_mah) for run in campaign if run.condition is None]
    line = fit_passive_drain([seconds for seconds, _ in idle], [mah for _, mah in idle], resolution_mah=1.0)
    worth_j = joules_per_mah(VOLTAGE_V, jumps)
    known = {(one.gain, one.damping_gain): one for one in truths(jumps)}
    joules, apexes = [], []
    for run in campaign:
        if run.condition is None:
            continue
        at = line.at(run.duration_s)
        shared = {("drain", term): -worth_j * mah for term, mah in line.error_terms_mah(run.duration_s).items()}
        value_j = worth_j * (run.charge_mah - at.charge_mah)
        joules.append((run, value_j, SharedError(shared, {"drain": line.df})))
        apexes.append((run, _apex_m(chance, known[run.condition]), SharedError()))
    conditions = {Outcome.JOULES: list(_conditions(joules)), Outcome.APEX: list(_conditions(apexes))}
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
    return truth.apex_m + chance.normal(0.0, EmulatorScatter().run_height) * (truth.apex_m - REST_LENGTH_M)


def _conditions(values: list[tuple[EmulatorRun, float, SharedError]]) -> Iterator[ConditionValues]:
    by_condition: dict[tuple[int, int], list[RunNumber]] = {}
    for run, value, shared in values:
        assert run.condition is not None
        by_condition.setdefault(run.condition, []).append(RunNumber(_row(run), value, shared, StoredResult()))
    none = Number(0.0, "1")
    for (gain, damping), runs in by_condition.items():
        levels = {"k_gain": str(gain), "b_ad_gain": str(damping)}
        yield ConditionValues(f"{gain} {damping}", damping == 0, levels, tuple(runs), ConditionSummary(none, none, ()))


def _row(run: EmulatorRun) -> RunRow:
    return RunRow(
        uid=run.name,
        name=run.name,
        kind=RunKind.JUMPS,
        state=RunState.COMPLETE,
        day=run.date.isoformat(),
        position_in_day=run.position,
        condition_uid=None,
        condition_key="",
        is_control=False,
        levels={},
        robot="hopper",
        robot_uid="",
        battery="A",
        started_utc=None,
        duration_s=run.duration_s,
        jumps_made=run.jumps,
        starts=1,
        planned=False,
    )
