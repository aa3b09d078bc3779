"""The sheet of a study of compaction: water measured in flasks of several sizes (5.1.2)."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path

from data_schema.errors import InputRefused, UsageError
from data_schema.units import conversion
from labbook.actions.stats.table import LongTable, numbers_of, read_table
from labbook.analysis.studies.compaction import Compaction, compaction
from stats.packing import fraction_from_water

_COLUMNS = {
    "radius": ("m", "inner radius of the spherical flask"),
    "water": ("m^3", "water that filled the gaps"),
    "flask": ("m^3", "volume of the flask, where it was measured"),
}
"""Quantities of a sheet: the unit that they are turned into, and what they are."""
_WITH_UNIT = re.compile(
    r"(radius|water|flask)(?:[ _]volume)?(?:_([A-Za-z0-9^]+)|\s*[(\[]([^)\]]+)[)\]])", re.IGNORECASE
)
_EXAMPLE = "radius_mm,state,water_ml"


def compaction_of(text: str, file: Path, grain_mm: float, level: float, decimal: str | None = None) -> Compaction:
    """Read a sheet with one measurement a row, and extrapolate each state to an infinite container.

    Its columns are the radius of the flask, the state of the grains (two words, such as loose and compacted) and the
    water that filled what they left, with units in their names; a column of the flasks' volumes is used where there is
    one, else that of a sphere. Raises `InputRefused` for columns that are missing, other than two states, flasks that
    were not measured in both, and fewer than three sizes.
    """
    table = read_table(text, str(file))
    columns = _columns(table)
    if not 0.0 < grain_mm < math.inf:
        raise UsageError(f"--grain {grain_mm:g}: give the grains' diameter in mm, such as --grain 3.4.")
    measured = {name: _values(table, *columns[name], decimal) for name in columns}
    volumes = measured.get("flask", [4.0 / 3.0 * math.pi * radius**3 for radius in measured["radius"]])
    states = _cells(table, "state")
    by_state: dict[str, list[tuple[float, float]]] = {}
    for state, radius, volume, water in zip(states, measured["radius"], volumes, measured["water"], strict=True):
        by_state.setdefault(state, []).append((radius, fraction_from_water(volume, water).fraction))
    return compaction(by_state, grain_mm / 1e3, level)


def _columns(table: LongTable) -> Mapping[str, tuple[str, float]]:
    """Return by quantity the column that holds it and the factor to SI."""
    found: dict[str, tuple[str, float]] = {}
    for column in table.columns:
        if matched := _WITH_UNIT.fullmatch(column):
            quantity = matched[1].lower()
            factor, _offset = conversion(matched[2] or matched[3], _COLUMNS[quantity][0])
            found[quantity] = column, factor
    for quantity in ("radius", "water"):
        if quantity not in found:
            raise InputRefused(
                f"{table.file} has no column of the {_COLUMNS[quantity][1]} with its unit: name the columns as in "
                f"{_EXAMPLE}."
            )
    return found


def _values(table: LongTable, column: str, factor: float, decimal: str | None) -> list[float]:
    numbers = numbers_of(table, column, "the compaction", decimal)
    for number, line in zip(numbers, table.lines, strict=True):
        if number is None or number <= 0:
            raise InputRefused(
                f"line {line} of {table.file} has no positive {column}: measure it, or leave the row out."
            )
    return [float(number or 0) * factor for number in numbers]


def _cells(table: LongTable, name: str) -> tuple[str, ...]:
    for column in table.columns:
        if column.lower() == name:
            return table.columns[column]
    raise InputRefused(f"{table.file} has no column {name!r}: name the columns as in {_EXAMPLE}.")
