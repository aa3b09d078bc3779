"""Studies of a sheet: oscillations of a leg (thesis 4.2.6), grains in flasks (5.1.2), walks in the field (2.2.3)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from data_schema.errors import UsageError
from ingest.formats.study_sheets import read_flasks, read_oscillation, read_power, read_trials, read_walks
from labbook.actions.files.named_files import own_name
from labbook.analysis.studies.characterisation import Characterisation, Oscillation, characterisation
from labbook.analysis.studies.compaction import Compaction, compaction
from labbook.analysis.studies.field import FieldStudy, Walk, field_study
from stats.packing import fraction_from_water


def characterisation_of(
    sheet_path: Path, read: Callable[[Path], str], level: float, decimal: Callable[[Path], str | None]
) -> Characterisation:
    """Read the sheet with one trajectory a row, and the log of each, whose path counts from the sheet's folder.

    `read` returns a file's text, `decimal` its decimal sign, None where it shows. Raises `InputRefused` as
    `read_trials`, `read_oscillation` and `characterisation` do.
    """
    sheet = read_trials(read(sheet_path), own_name(sheet_path), decimal(sheet_path))
    unknown: Sequence[float | None] = [None] * len(sheet.lines)
    columns = (sheet.words["file"], *(sheet.values[name] for name in ("gain", "damping_gain")))
    neutral_m = sheet.values.get("neutral", unknown)
    found = []
    for name, gain, damping_gain, length_m, mass_kg in zip(*columns, neutral_m, sheet.values["mass"], strict=True):
        path = sheet_path.parent / name
        log = read_oscillation(read(path), name, decimal(path))
        found.append(Oscillation(name, gain, damping_gain, length_m, mass_kg, *log))
    return characterisation(found, level)


_FINEST_MM = 0.05
"""Below it grains are silt, or their diameter was given in metres."""


def compaction_of(text: str, file: Path, grain_mm: float, level: float, decimal: str | None = None) -> Compaction:
    """Read a sheet with one measurement a row, and extrapolate each state to an infinite container.

    Raises `InputRefused` as `read_flasks` and `compaction` do, `UsageError` for grains finer than sand.
    """
    if not 0.0 < grain_mm < math.inf:
        raise UsageError(f"--grain {grain_mm:g}: give the grains' diameter in mm, such as --grain 3.4.")
    if grain_mm < _FINEST_MM:
        raise UsageError(
            f"grains of {grain_mm:g} mm are finer than {_FINEST_MM:g} mm: give their diameter in mm, such as 3.4 "
            "(--grain, or grain_mm in labbook.toml)."
        )
    sheet = read_flasks(text, own_name(file), decimal)
    by_state: dict[str, list[tuple[float, float, int]]] = {}
    columns = (sheet.radii_m, sheet.flasks_m3, sheet.water_m3)
    for state, radius_m, flask_m3, water_m3, line in zip(sheet.states, *columns, sheet.lines, strict=True):
        by_state.setdefault(state, []).append((radius_m, fraction_from_water(flask_m3, water_m3).fraction, line))
    return compaction(by_state, grain_mm / 1e3, level, sheet.doubt())


def field_study_of(
    sheet_path: Path,
    read: Callable[[Path], str],
    level: float,
    decimal: str | None = None,
    decimal_of_log: Callable[[Path], str | None] = lambda _path: None,
) -> FieldStudy:
    """Read a sheet with one robot on one walk a row, and compare the robots.

    `read` returns a file's text; decimal signs are None where they show. Energies stand in the sheet, or come of the
    power log that a row names, whose path counts from the sheet's folder. Raises `InputRefused` as `read_walks`,
    `read_power` and `field_study` do.
    """
    sheet = read_walks(read(sheet_path), own_name(sheet_path), decimal)
    energies_j = sheet.energies_j
    if energies_j is None:
        paths = {name: sheet_path.parent / name for name in sheet.logs}
        logs = [read_power(read(path), name, decimal_of_log(path)) for name, path in paths.items()]
        energies_j = [float(np.trapezoid(power_w, time_s)) for time_s, power_w in logs]
    rows = zip(sheet.robots, sheet.walks, energies_j, sheet.masses_kg, sheet.distances_m, sheet.lines, strict=True)
    return field_study([Walk(*row) for row in rows], level, sheet.doubt())
