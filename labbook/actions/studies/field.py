"""The sheet of a study in the field: what two robots took from their batteries on the same walks (thesis 2.2.3)."""

from __future__ import annotations

from pathlib import Path

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
_EXAMPLE = "walk,robot,mass_kg,distance_m,energy_Wh (or charge_mAh,voltage_V)"


def field_study_of(text: str, file: Path, level: float, decimal: str | None = None) -> FieldStudy:
    """Read a sheet with one robot on one walk a row, and compare the robots.

    Raises `InputRefused` as `read_study_sheet` and `field_study` do, and for a sheet without energies, or charges and
    voltages.
    """
    sheet = read_study_sheet(text, str(file), _QUANTITIES, ("walk", "robot"), _EXAMPLE, decimal)
    values = sheet.values
    energies_j = values.get("energy")
    if energies_j is not None and "charge" in values:
        raise InputRefused(f"{file} has energies and charges: keep the one that is meant.")
    if energies_j is None:
        if "charge" not in values or "voltage" not in values:
            raise InputRefused(f"{file} says no energies, nor charges and voltages: name the columns as in {_EXAMPLE}.")
        energies_j = [charge * volts for charge, volts in zip(values["charge"], values["voltage"], strict=True)]
    rows = zip(sheet.words["robot"], sheet.words["walk"], energies_j, values["mass"], values["distance"], strict=True)
    return field_study([Walk(*row) for row in rows], level)
