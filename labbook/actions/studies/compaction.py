"""The sheet of a study of compaction: water measured in flasks of several sizes (thesis 5.1.2)."""

from __future__ import annotations

import math
from pathlib import Path

from data_schema.errors import UsageError
from ingest.formats.study_sheets import read_flasks
from labbook.analysis.studies.compaction import Compaction, compaction
from stats.packing import fraction_from_water

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
    sheet = read_flasks(text, str(file), decimal)
    by_state: dict[str, list[tuple[float, float, int]]] = {}
    columns = (sheet.radii_m, sheet.flasks_m3, sheet.water_m3)
    for state, radius_m, flask_m3, water_m3, line in zip(sheet.states, *columns, sheet.lines, strict=True):
        by_state.setdefault(state, []).append((radius_m, fraction_from_water(flask_m3, water_m3).fraction, line))
    return compaction(by_state, grain_mm / 1e3, level, sheet.doubt())
