"""The sheet of a study in the field: what two robots took from their batteries on the same walks (thesis 2.2.3)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ingest.formats.study_sheets import read_power, read_walks
from labbook.analysis.studies.field import FieldStudy, Walk, field_study


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
    sheet = read_walks(read(sheet_path), str(sheet_path), decimal)
    energies_j = sheet.energies_j
    if energies_j is None:
        paths = {name: sheet_path.parent / name for name in sheet.logs}
        logs = [read_power(read(path), name, decimal_of_log(path)) for name, path in paths.items()]
        energies_j = [float(np.trapezoid(power_w, time_s)) for time_s, power_w in logs]
    rows = zip(sheet.robots, sheet.walks, energies_j, sheet.masses_kg, sheet.distances_m, sheet.lines, strict=True)
    return field_study([Walk(*row) for row in rows], level, sheet.doubt())
