"""The emulator campaign as files in the instruments' formats, and as a book that has ingested them."""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from itertools import groupby
from pathlib import Path

from data_schema.errors import UsageError
from data_schema.vocabulary import RunKind
from labbook.book.opening import CONFIGURATION
from labbook.demo.emulator import GAINS, IDLE_S, VOLTAGE_V, EmulatorRun, dampings, truths
from labbook.demo.files import MARK
from labbook.demo.running import Stopwatch, make_book_of
from labbook.demo.writers import RunRow, SheetRow, charger_sheet, run_sheet, string_pot_log

_TEMPLATE = """\
# Demonstration: the emulator study of the thesis (4.3), simulated with known truth (truth.json).
# Nothing in it was measured. What it says is described in docs/emulator.md.

[study]
name = "ground emulator (synthetic)"
kind = "emulator"
reference_voltage_v = {voltage}
jumps_nominal = {jumps}
time_zone = "America/New_York"

[people]
"Ada Nwosu" = "AN"

[factors.k_gain]
kind = "number"
title = "extension stiffness"
levels = {gains}

[factors.b_ad_gain]
kind = "number"
title = "active-damping coefficient"
levels = {dampings}
control = 0

# The first two jumps, and those that touch a dropped packet, are left out (thesis 4.3.3).
[protocol]
detector = "robust"
exclude_first_jumps = 2
exclude_gap_jumps = true
charger_resolution_mah = 1
idle_minutes = {idle}

[gains.k_gain]
symbol = "k"
slope = 2.56
offset = 67.36
unit = "N/m"

[gains.b_ad_gain]
symbol = "d"
slope = 3.32
offset = 0
unit = "kg/s"
zero = 0

[robots.hopper]
body_mass_kg = 1.575
foot_mass_kg = 0.175
link_1_m = 0.1
link_2_m = 0.2
rest_length_m = 0.25
leg_min_m = 0.1
leg_max_m = 0.3

[batteries.A]
cells = 4
capacity_mah = 7200

[files]
run_pattern = '^(?P<run>r\\d+)'

[analysis]
primary_outcome = "joules"
family = "each"
apex_bounds_percent = [-6, 6]
unit_of_analysis = "shared_days"

[simulation]
scene = "emulator"
factors = {{ k_gain = "k_extension", b_ad_gain = "b_ad" }}

[hypotheses.saves]
text = "Active damping saves energy at every gain"
source = "thesis 4.3"
published = "in all conditions"
claim = "saves"

[hypotheses.no_lower_apex]
text = "It costs less than 6 % of the apex height"
source = "thesis 4.3.3"
published = "less than 6 %"
claim = "not_lower"
outcome = "apex"
within_percent = 6

[hypotheses.torque_limit]
text = "The apex is the same at gains 400 and 500"
source = "thesis 4.3.3"
published = "no appreciable difference"
claim = "same"
side = "control"
outcome = "apex"
between = "k_gain"
levels = [400, 500]
within_percent = 2
"""
_FIRST_AT, _APART = dt.time(9, 0), dt.timedelta(minutes=25)


def write_emulator_campaign(campaign: Sequence[EmulatorRun], folder: Path, step: Callable[[str], None]) -> None:
    """Write labbook.toml, the run sheet, charger sheets, logs and truth.json below `folder`."""
    instruments = folder / "instruments"
    for part in ("logs", "charger"):
        (instruments / part).mkdir(parents=True)
    jumps = max(run.jumps for run in campaign)
    text = _TEMPLATE.format(
        voltage=VOLTAGE_V,
        jumps=jumps,
        gains=list(GAINS),
        dampings=sorted({damping for gain in GAINS for damping in dampings(gain)}),
        idle=[seconds // 60 for seconds in IDLE_S],
    )
    (folder / CONFIGURATION).write_text(text, encoding="utf-8")
    (instruments / "runs.csv").write_bytes(run_sheet(("k_gain", "b_ad_gain"), _run_rows(campaign)))
    for date, of_day in groupby(campaign, key=lambda run: run.date):
        sheet = charger_sheet([_recharge(run) for run in of_day])
        (instruments / "charger" / f"{date:%Y-%m-%d}_charger_{MARK}.csv").write_bytes(sheet)
    for number, run in enumerate(campaign, start=1):
        step(f"writing run {number} of {len(campaign)}")
        if run.log_ms is not None and run.channels is not None:
            log = string_pot_log(run.log_ms, run.channels, {"k_gain": 1, "b_ad_gain": 1})
            (instruments / "logs" / f"{run.name}_{MARK}.csv").write_bytes(log)
    truth = {"conditions": [asdict(one) for one in truths(jumps)]}
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")


def _started(run: EmulatorRun) -> dt.datetime:
    return dt.datetime.combine(run.date, _FIRST_AT) + (run.position - 1) * _APART


def _run_rows(campaign: Sequence[EmulatorRun]) -> Iterator[RunRow]:
    for run in campaign:
        idle = run.condition is None
        yield RunRow(
            run=run.name,
            started=_started(run),
            position=run.position,
            kind=RunKind.IDLE if idle else RunKind.JUMPS,
            levels={} if run.condition is None else dict(zip(("k_gain", "b_ad_gain"), run.condition, strict=True)),
            battery="A",
            robot="hopper",
            duration_s=run.duration_s,
            jumps_made=run.jumps,
            starts=1,
            note="held, motors off" if idle else "ground emulator, synthetic",
        )


def _recharge(run: EmulatorRun) -> SheetRow:
    minutes = run.charge_mah // 20 + 4
    ended = (_started(run) + dt.timedelta(seconds=run.duration_s + 60 * (minutes + 1))).replace(second=0)
    return SheetRow(run.name, run.charge_mah, minutes, VOLTAGE_V, "A", ended)


def make_emulator_book(
    folder: Path, campaign: Sequence[EmulatorRun], step: Callable[[str], None], say: Callable[[str], None]
) -> Path:
    """Write the campaign's files and ingest them into a new book; returns the book's folder."""
    if folder.exists() and any(folder.iterdir()):
        raise UsageError(f"{folder} is not empty: name a new folder for the demonstration.")
    clock = Stopwatch(say)
    write_emulator_campaign(campaign, folder, step)
    clock.lap(f"wrote the instruments' files of {len(campaign)} runs to {folder / 'instruments'}")
    return make_book_of(folder, step, clock)
