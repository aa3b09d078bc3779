"""What the campaigns of studies that are kept in a book have in common: labbook.toml, sheets, and making the book."""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from data_schema.vocabulary import RunKind
from labbook.book.opening import CONFIGURATION
from labbook.demo.files import MARK
from labbook.demo.running import Stopwatch, make_book_of, new_folder
from labbook.demo.writers import RunRow, SheetRow, charger_sheet, run_sheet

_TEMPLATE = """\
# Demonstration: the {study} study of the thesis ({section}), simulated with known truth (truth.json).
# Nothing in it was measured. What it says is described in docs/{study}.md.

[study]
name = "{name} (synthetic)"
kind = "{kind}"
reference_voltage_v = {voltage_v}
jumps_nominal = {jumps}
time_zone = "America/New_York"

[people]
"Ada Nwosu" = "AN"

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

[files]
run_pattern = '^(?P<run>r\\d+)'

"""
_FIRST_AT, _APART = dt.time(9, 0), dt.timedelta(minutes=25)


@dataclass(frozen=True, slots=True)
class StudyRun:
    """A run of a campaign: what it was made with, by factor (nothing: idle), how long it took, and its recharge."""

    name: str
    date: dt.date
    position: int
    levels: Mapping[str, int]
    jumps: int
    duration_s: int
    charge_mah: int

    @property
    def started(self) -> dt.datetime:
        """Local time at which it began."""
        return dt.datetime.combine(self.date, _FIRST_AT) + (self.position - 1) * _APART


@dataclass(frozen=True, slots=True)
class StudyFiles:
    """What is written of a campaign: its configuration, its runs, logs and records by path, and what is true."""

    configuration: str
    voltage_v: float
    factors: tuple[str, ...]
    runs: Sequence[StudyRun]
    write_records: Callable[[Path, Callable[[str], None]], None]
    truth: Mapping[str, Any]


def configuration(further: str, **values: object) -> str:
    """Write labbook.toml: the values that studies differ by, and the tables that a study has `further`."""
    return _TEMPLATE.format(**values) + further


def make_study_book(folder: Path, files: StudyFiles, step: Callable[[str], None], say: Callable[[str], None]) -> Path:
    """Write a campaign's files below a new folder and ingest them into a book; returns the book's folder."""
    new_folder(folder)
    clock, instruments = Stopwatch(say), folder / "instruments"
    (instruments / "charger").mkdir(parents=True)
    (folder / CONFIGURATION).write_text(files.configuration, encoding="utf-8")
    (instruments / "runs.csv").write_bytes(run_sheet(files.factors, map(_row, files.runs)))
    for date, of_day in groupby(files.runs, key=lambda run: run.date):
        sheet = charger_sheet([_recharge(run, files.voltage_v) for run in of_day])
        (instruments / "charger" / f"{date:%Y-%m-%d}_charger_{MARK}.csv").write_bytes(sheet)
    files.write_records(instruments, step)
    (folder / "truth.json").write_text(json.dumps(files.truth, indent=1) + "\n", encoding="utf-8")
    clock.lap(f"wrote the instruments' files of {len(files.runs)} runs to {instruments}")
    return make_book_of(folder, step, clock)


def _row(run: StudyRun) -> RunRow:
    return RunRow(
        run=run.name,
        started=run.started,
        position=run.position,
        kind=RunKind.JUMPS if run.jumps else RunKind.IDLE,
        levels=run.levels,
        battery="A",
        robot="hopper",
        duration_s=run.duration_s,
        jumps_made=run.jumps,
        starts=1,
        note="synthetic" if run.jumps else "held, motors off",
    )


def _recharge(run: StudyRun, voltage_v: float) -> SheetRow:
    minutes = run.charge_mah // 16 + 4
    ended = (run.started + dt.timedelta(seconds=run.duration_s, minutes=minutes + 1)).replace(second=0)
    return SheetRow(run.name, run.charge_mah, minutes, voltage_v, "A", ended)
