"""The sheet of a characterisation, and the logs that it names: oscillations of a mass on a leg (thesis 4.2.6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ingest.formats.study_sheets import read_oscillation, read_trials
from labbook.analysis.studies.characterisation import Characterisation, Oscillation, characterisation


def characterisation_of(
    sheet_path: Path, read: Callable[[Path], str], level: float, decimal: Callable[[Path], str | None]
) -> Characterisation:
    """Read the sheet with one trajectory a row, and the log of each, whose path counts from the sheet's folder.

    `read` returns a file's text, `decimal` its decimal sign, None where it shows. Raises `InputRefused` as
    `read_trials`, `read_oscillation` and `characterisation` do.
    """
    sheet = read_trials(read(sheet_path), str(sheet_path), decimal(sheet_path))
    unknown: Sequence[float | None] = [None] * len(sheet.lines)
    columns = (sheet.words["file"], *(sheet.values[name] for name in ("gain", "damping_gain")))
    neutral_m = sheet.values.get("neutral", unknown)
    found = []
    for name, gain, damping_gain, length_m, mass_kg in zip(*columns, neutral_m, sheet.values["mass"], strict=True):
        path = sheet_path.parent / name
        log = read_oscillation(read(path), name, decimal(path))
        found.append(Oscillation(name, gain, damping_gain, length_m, mass_kg, *log))
    return characterisation(found, level)
