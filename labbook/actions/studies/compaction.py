"""The sheet of a study of compaction: water measured in flasks of several sizes (thesis 5.1.2)."""

from __future__ import annotations

import math
from pathlib import Path

from data_schema.errors import InputRefused, UsageError
from labbook.actions.studies.sheet import Quantity, read_study_sheet
from labbook.analysis.studies.compaction import Compaction, compaction
from stats.packing import fraction_from_water

_QUANTITIES = {
    "radius": Quantity("m", "inner radius of the spherical flask"),
    "water": Quantity("m^3", "water that filled the gaps"),
    "flask": Quantity("m^3", "volume of the flask", needed=False),
}
_EXAMPLE = "radius_mm,state,water_ml"


def compaction_of(text: str, file: Path, grain_mm: float, level: float, decimal: str | None = None) -> Compaction:
    """Read a sheet with one measurement a row, and extrapolate each state to an infinite container.

    Its columns are the radius of the flask, the state of the grains (two words, such as loose and compacted) and the
    water that filled what they left; a column of the flasks' volumes is used where there is one, else that of a sphere.
    Raises `InputRefused` as `read_study_sheet` and `compaction` do.
    """
    if not 0.0 < grain_mm < math.inf:
        raise UsageError(f"--grain {grain_mm:g}: give the grains' diameter in mm, such as --grain 3.4.")
    sheet = read_study_sheet(text, str(file), _QUANTITIES, ("state",), _EXAMPLE, decimal)
    radii_m, water_m3 = sheet.values["radius"], sheet.values["water"]
    volumes_m3 = sheet.values.get("flask", [4.0 / 3.0 * math.pi * radius_m**3 for radius_m in radii_m])
    by_state: dict[str, list[tuple[float, float]]] = {}
    rows = zip(sheet.words["state"], radii_m, volumes_m3, water_m3, sheet.lines, strict=True)
    for state, radius_m, volume_m3, water, line in rows:
        if water > volume_m3:
            raise InputRefused(
                f"line {line} of {file} has more water than the flask of {radius_m * 1e3:g} mm holds "
                f"({water * 1e6:.4g} of {volume_m3 * 1e6:.4g} ml): check both."
            )
        by_state.setdefault(state, []).append((radius_m, fraction_from_water(volume_m3, water).fraction))
    return compaction(by_state, grain_mm / 1e3, level)
