"""What the campaigns of studies have in common: labbook.toml, the sheets of runs, and making the book."""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from data_schema.vocabulary import RunKind
from labbook.book.opening import CONFIGURATION
from labbook.demo.files import MARK, STUDY_TOML
from labbook.demo.running import RUN_SHEET, Stopwatch, make_book_of
from labbook.demo.writers import SheetRun, charger_sheet, run_sheet, string_pot_log

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


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StudyRun(SheetRun):
    """A run of a campaign.

    The log's channels, by name with unit, have one element a recorded sample of `log_ms`.
    """

    log_ms: NDArray[np.int64] | None = None
    channels: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)


def written_run(
    number: int, date: dt.date, position: int, levels: Mapping[str, int], jumps: int, duration_s: int, charge_mah: int
) -> dict[str, Any]:
    """Return what is written down of a run of some jumps (none: idle), by field; runs are 25 minutes apart."""
    started = dt.datetime.combine(date, dt.time(9, 0)) + (position - 1) * dt.timedelta(minutes=25)
    minutes = charge_mah // 16 + 4
    ended = started + dt.timedelta(seconds=duration_s, minutes=minutes + 1)
    return {
        "name": f"r{number:03d}",
        "started": started,
        "position": position,
        "kind": RunKind.JUMPS if jumps else RunKind.IDLE,
        "levels": levels,
        "duration_s": duration_s,
        "jumps_made": jumps,
        "note": "synthetic" if jumps else "held, motors off",
        "charge_mah": charge_mah,
        "recharge_minutes": minutes,
        "recharge_ended": ended.replace(second=0),
    }


@dataclass(frozen=True, slots=True)
class StudyFiles:
    """What is written of a campaign: its configuration, its sheets, logs and records, and what is true.

    `records` are paths below `instruments` and contents, made one after the other. `runs`, if there are any, are made
    with `factors`.
    """

    configuration: str
    records: Iterable[tuple[str, bytes]]
    truth: Mapping[str, Any]
    runs: Sequence[StudyRun] = ()
    factors: tuple[str, ...] = ()


def logs_of(runs: Iterable[StudyRun], decimals: Mapping[str, int]) -> Iterator[tuple[str, bytes]]:
    """Write the logs that runs have."""
    for run in runs:
        if run.log_ms is not None:
            yield f"logs/{run.name}_{MARK}.csv", string_pot_log(run.log_ms, run.channels, decimals)


def make_study_book(folder: Path, files: StudyFiles, step: Callable[[str], None], say: Callable[[str], None]) -> Path:
    """Write a campaign's files below a new folder and ingest them into a book; returns the book's folder."""
    clock, instruments = Stopwatch(say), folder / "instruments"
    instruments.mkdir(parents=True)
    (folder / CONFIGURATION).write_text(files.configuration, encoding="utf-8")
    for path, content in (*_sheets(files), *files.records):
        step(f"writing {path}")
        (instruments / path).parent.mkdir(exist_ok=True)
        (instruments / path).write_bytes(content)
    (folder / "truth.json").write_text(json.dumps(files.truth, indent=1) + "\n", encoding="utf-8")
    clock.lap(f"wrote the campaign's files to {instruments}")
    return make_book_of(folder, step, clock)


def _sheets(files: StudyFiles) -> Iterator[tuple[str, bytes]]:
    """Write the run sheet, and the charger's sheet of each day."""
    if files.runs:
        yield RUN_SHEET, run_sheet(files.factors, files.runs)
    for date, of_day in groupby(files.runs, key=lambda run: run.date):
        yield f"charger/{date:%Y-%m-%d}_charger_{MARK}.csv", charger_sheet(of_day)
