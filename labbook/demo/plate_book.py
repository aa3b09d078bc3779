"""The force-plate campaign as files in the instruments' formats, and as a book that has ingested them."""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from data_schema.errors import UsageError
from data_schema.vocabulary import RunKind
from labbook.book.opening import CONFIGURATION
from labbook.demo.files import MARK
from labbook.demo.force_plate import GAINS, HOPS, IDLE_S, VOLTAGE_V, PlateStudyRun
from labbook.demo.running import Stopwatch, make_book_of
from labbook.demo.writers import RunRow, SheetRow, bertec_text, charger_sheet, run_sheet, string_pot_log

_TEMPLATE = """\
# Demonstration: the force-plate study of the thesis (3.2.2), simulated with known truth (truth.json).
# Nothing in it was measured. What it says is described in docs/force-plate.md.

[study]
name = "force plate (synthetic)"
kind = "force_plate"
reference_voltage_v = {voltage}
jumps_nominal = {hops}
time_zone = "America/New_York"

[people]
"Ada Nwosu" = "AN"

[factors.k_gain]
kind = "number"
title = "extension stiffness"
levels = {gains}

[protocol]
run_duration_s = 65
detector = "robust"
exclude_first_jumps = 0
exclude_gap_jumps = true
charger_resolution_mah = 1
idle_minutes = {idle}

[gains.k_gain]
symbol = "k"
slope = 2.56
offset = 67.36
unit = "N/m"

[robots.hopper]
body_mass_kg = 1.825
foot_mass_kg = 0.175
link_1_m = 0.1
link_2_m = 0.2
rest_length_m = 0.27
leg_min_m = 0.1
leg_max_m = 0.3

[batteries.A]
cells = 4
capacity_mah = 6600

[files]
run_pattern = '^(?P<run>r\\d+)'

[simulation]
scene = "force_plate"
factors = {{ k_gain = "k_extension" }}
"""
_FIRST_AT, _APART = dt.time(9, 30), dt.timedelta(minutes=25)


def write_plate_campaign(campaign: Sequence[PlateStudyRun], folder: Path, step: Callable[[str], None]) -> None:
    """Write labbook.toml, the run sheet, charger sheets, plate records, logs and truth.json below `folder`."""
    instruments = folder / "instruments"
    for part in ("force", "logs", "charger"):
        (instruments / part).mkdir(parents=True)
    text = _TEMPLATE.format(
        voltage=VOLTAGE_V, hops=HOPS, gains=sorted(GAINS), idle=[seconds / 60 for seconds in IDLE_S]
    )
    (folder / CONFIGURATION).write_text(text, encoding="utf-8")
    (instruments / "runs.csv").write_bytes(run_sheet(("k_gain",), _run_rows(campaign)))
    for date, of_day in groupby(campaign, key=lambda run: run.date):
        sheet = charger_sheet(_recharges(list(of_day)))
        (instruments / "charger" / f"{date:%Y-%m-%d}_charger_{MARK}.csv").write_bytes(sheet)
    jumped = [run for run in campaign if run.gain is not None]
    for number, run in enumerate(jumped, start=1):
        step(f"writing run {number} of {len(jumped)}")
        assert run.plate is not None and run.log_ms is not None and run.channels is not None  # noqa: S101, PT018
        record = bertec_text(run.plate.time_ms, run.plate.force_n, run.plate.moment_nm, run.plate.cop_m)
        (instruments / "force" / f"{run.name}_bertec_{MARK}.txt").write_bytes(record)
        log = string_pot_log(run.log_ms, run.channels, {"k_gain": 1})
        (instruments / "logs" / f"{run.name}_{MARK}.csv").write_bytes(log)
    truth = {"runs": [_truth(run) for run in jumped]}
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")


def _truth(run: PlateStudyRun) -> dict[str, object]:
    offset_s, drift = run.clocks
    return {
        "run": run.name,
        "k_gain": run.gain,
        "joules_per_jump": run.cost_j,
        "joules_in_stance": run.stance_j,
        "clock_offset_s": offset_s,
        "clock_drift": drift,
    }


def _started(run: PlateStudyRun) -> dt.datetime:
    return dt.datetime.combine(run.date, _FIRST_AT) + (run.position - 1) * _APART


def _run_rows(campaign: Sequence[PlateStudyRun]) -> Iterator[RunRow]:
    for run in campaign:
        idle = run.gain is None
        yield RunRow(
            run=run.name,
            started=_started(run),
            position=run.position,
            kind=RunKind.IDLE if idle else RunKind.JUMPS,
            levels={} if idle else {"k_gain": run.gain},
            battery="A",
            robot="hopper",
            duration_s=run.duration_s,
            jumps_made=0 if idle else run.hops,
            starts=1,
            note="held, motors off" if idle else "force plate, rigid ground, synthetic",
        )


def _recharges(of_day: Sequence[PlateStudyRun]) -> list[SheetRow]:
    rows = []
    for run in of_day:
        minutes = int(np.ceil(run.charge_mah / (1000 / 60))) + 3
        ended = (_started(run) + dt.timedelta(seconds=run.duration_s + 60 * (minutes + 1))).replace(second=0)
        rows.append(SheetRow(run.name, run.charge_mah, minutes, VOLTAGE_V, "A", ended))
    return rows


def make_plate_book(
    folder: Path, campaign: Sequence[PlateStudyRun], step: Callable[[str], None], say: Callable[[str], None]
) -> Path:
    """Write the campaign's files and ingest them into a new book; returns the book's folder."""
    if folder.exists() and any(folder.iterdir()):
        raise UsageError(f"{folder} is not empty: name a new folder for the demonstration.")
    clock = Stopwatch(say)
    write_plate_campaign(campaign, folder, step)
    clock.lap(f"wrote the instruments' files of {len(campaign)} runs to {folder / 'instruments'}")
    return make_book_of(folder, step, clock)
