"""The sheet of a characterisation, and the logs that it names: oscillations of a mass on a leg (thesis 4.2.6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from labbook.actions.studies.sheet import Quantity, read_study_sheet
from labbook.analysis.studies.characterisation import Characterisation, Oscillation, characterisation

_TRIAL = {
    "gain": Quantity("1", "position gain"),
    "damping_gain": Quantity("1", "velocity gain", any_sign=True),
    "mass": Quantity("kg", "mass that the leg carries"),
    "neutral": Quantity("m", "leg's length without load", needed=False),
}
_EXAMPLE = "file,gain,damping_gain,mass_kg,neutral_cm"
_LOG = {
    "time": Quantity("s", "time", any_sign=True),
    "position": Quantity("m", "leg's compression", any_sign=True),
    "velocity": Quantity("m/s", "rate of compression", any_sign=True),
}
_LOG_EXAMPLE = "time_ms,position_mm,velocity (m/s)"


def characterisation_of(
    sheet_path: Path, read: Callable[[Path], str], level: float, decimal: str | None = None
) -> Characterisation:
    """Read the sheet with one trajectory a row, and the log of each, whose path counts from the sheet's folder.

    `read` returns a file's text. A log has the columns time, position and velocity with their units. Raises
    `InputRefused` as `read_study_sheet` and `characterisation` do.
    """
    sheet = read_study_sheet(read(sheet_path), str(sheet_path), _TRIAL, ("file",), _EXAMPLE, decimal)
    unknown: Sequence[float | None] = [None] * len(sheet.words["file"])
    neutral_m = sheet.values.get("neutral", unknown)
    columns = (sheet.values[name] for name in ("gain", "damping_gain", "mass"))
    found = []
    for name, gain, damping_gain, mass_kg, length_m in zip(sheet.words["file"], *columns, neutral_m, strict=True):
        path = sheet_path.parent / name
        log = read_study_sheet(read(path), name, _LOG, (), _LOG_EXAMPLE, decimal).values
        time_s, position_m, velocity_m_s = (np.array(log[column]) for column in _LOG)
        found.append(Oscillation(name, gain, damping_gain, length_m, mass_kg, time_s, position_m, velocity_m_s))
    return characterisation(found, level)
