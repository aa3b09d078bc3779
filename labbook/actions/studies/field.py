"""The sheet of a study in the field: what two robots took from their batteries on the same walks (thesis 2.2.3)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from data_schema.errors import InputRefused
from labbook.actions.studies.sheet import Quantity, read_study_sheet
from labbook.analysis.studies.field import FieldStudy, Walk, field_study

_QUANTITIES = {
    "mass": Quantity("kg", "robot's mass"),
    "distance": Quantity("m", "distance walked"),
    "energy": Quantity("J", "energy taken from the battery", needed=False),
    "charge": Quantity("A*s", "charge put back", needed=False),
    "voltage": Quantity("V", "battery's voltage", needed=False),
}
_EXAMPLE = "walk,robot,mass_kg,distance_m,energy_Wh (or charge_mAh,voltage_V, or log)"
_LOG = {
    "time": Quantity("s", "time", any_sign=True),
    "power": Quantity("W", "power taken from the battery", needed=False, any_sign=True),
    "current": Quantity("A", "battery's current", needed=False, any_sign=True),
    "voltage": Quantity("V", "battery's voltage", needed=False),
}
_LOG_EXAMPLE = "time_s,power_W (or current_A,voltage_V)"
_LONGEST_STEP, _LONGEST_SHARE = 10.0, 0.01
"""A gap of a log that is refused: longer than so many usual steps, and than this share of the walk."""


def field_study_of(
    sheet_path: Path, read: Callable[[Path], str], level: float, decimal: str | None = None
) -> FieldStudy:
    """Read a sheet with one robot on one walk a row, and compare the robots.

    `read` returns a file's text. Energies stand in the sheet, or are charges times voltages, or come of the power log
    that a row names, whose path counts from the sheet's folder. Raises `InputRefused` as `read_study_sheet` and
    `field_study` do, for a sheet that says energies in no way or in two, and for a log with a gap.
    """
    file, words = str(sheet_path), ("walk", "robot")
    sheet = read_study_sheet(read(sheet_path), file, _QUANTITIES, words, _EXAMPLE, decimal, optional_words=("log",))
    values, logs = sheet.values, sheet.words.get("log")
    said = [
        name
        for name, there in (("energies", "energy" in values), ("charges", "charge" in values), ("logs", logs))
        if there
    ]
    if len(said) > 1:
        raise InputRefused(f"{file} has {' and '.join(said)}: keep the one that is meant.")
    if logs is not None:
        energies_j = [_energy_j(read(sheet_path.parent / name), name, decimal) for name in logs]
    elif "energy" in values:
        energies_j = list(values["energy"])
    elif "charge" in values and "voltage" in values:
        energies_j = [charge * volts for charge, volts in zip(values["charge"], values["voltage"], strict=True)]
    else:
        raise InputRefused(
            f"{file} says no energies, nor charges and voltages, nor logs: name the columns as in {_EXAMPLE}."
        )
    rows = zip(sheet.words["robot"], sheet.words["walk"], energies_j, values["mass"], values["distance"], strict=True)
    return field_study([Walk(*row) for row in rows], level)


def _energy_j(text: str, name: str, decimal: str | None) -> float:
    """Integrate a log's power over time by the trapezoidal rule."""
    log = read_study_sheet(text, name, _LOG, (), _LOG_EXAMPLE, decimal)
    time_s = np.array(log.values["time"])
    if "power" in log.values:
        power_w = np.array(log.values["power"])
    elif "current" in log.values and "voltage" in log.values:
        power_w = np.array(log.values["current"]) * np.array(log.values["voltage"])
    else:
        raise InputRefused(f"{name} has no power, nor current and voltage: name its columns as in {_LOG_EXAMPLE}.")
    steps_s = np.diff(time_s)
    if steps_s.size == 0 or steps_s.min() <= 0.0:
        raise InputRefused(
            f"the time of {name} does not rise from row to row: give the log of one walk as it was made."
        )
    place = int(steps_s.argmax())
    gap_s, whole_s = float(steps_s[place]), float(time_s[-1] - time_s[0])
    if gap_s > _LONGEST_STEP * np.median(steps_s) and gap_s > _LONGEST_SHARE * whole_s:
        raise InputRefused(
            f"{name} has nothing for {gap_s:g} s from line {log.lines[place]} on, so that its energy would be a guess: "
            "give the walk's charge instead, or leave the walk out for both robots."
        )
    energy_j = float(np.trapezoid(power_w, time_s))
    if energy_j <= 0.0:
        raise InputRefused(f"{name} says {energy_j:g} J were taken: turn the current's sign, taken is positive.")
    return energy_j
