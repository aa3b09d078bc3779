"""Factors from the units of files to those that are stored."""

from __future__ import annotations

import math

from data_schema.errors import InputRefused
from data_schema.units import conversion
from ingest.findings import FILE, FindingCollector
from ingest.model import Declarations
from ingest.tables.header_cells import is_unit

FACTORS = {
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "N": {"N": 1.0, "kN": 1e3},
    "N*m": {"N*m": 1.0, "N*mm": 1e-3},
    "V": {"V": 1.0, "mV": 1e-3},
    "A": {"A": 1.0, "mA": 1e-3, "10 mA": 1e-2},
    "mAh": {"mAh": 1.0, "Ah": 1e3},
    "degC": {"degC": 1.0, "0.1 degC": 0.1, "0.01 degC": 0.01},
    "1": {"1": 1.0},
}
"""The units that logs are full of, by the stored one: the units library, slow to load, is for the others."""


def factor(column: str, unit: str, stored: str, findings: FindingCollector) -> tuple[float, float]:
    """Return `(scale, offset)` with `stored = scale * value + offset`; a unit of another quantity refuses the file."""
    common = FACTORS.get(stored, {}).get(unit)
    if common is not None:
        return common, 0.0
    try:
        return conversion(unit, stored)
    except InputRefused as error:
        findings.add(FILE, "unit_not_convertible", f"Column {column!r}: {error}", column=column, value=unit)
        return 1.0, 0.0


def is_common(unit: str, stored: str) -> bool:
    """Whether a unit is one in which logs often give a quantity that is stored in `stored`."""
    return unit in FACTORS.get(stored, {})


def same_unit(one: str, other: str) -> bool:
    """Whether two spellings mean one unit."""
    if one == other:
        return True
    try:
        scale, offset = conversion(one, other)
    except InputRefused:
        return False
    return math.isclose(scale, 1.0) and offset == 0.0


def refuse_other_unit(
    column: str, own: str | None, stated: str | None, declared: Declarations, findings: FindingCollector
) -> None:
    """Refuse a file whose header says another unit of a column than is declared, unless declarations override it."""
    if own and stated and is_unit(own) and not declared.override_units and not same_unit(own, stated):
        findings.add(
            FILE,
            "unit_contradicts",
            f"The header of column {column!r} says {own} and {stated} is declared: leave the declaration out, "
            "or say `--override-units` if the header is wrong.",
            column=column,
            value=own,
        )


def refuse_two_units(column: str, name: str | None, below: str | None, findings: FindingCollector) -> None:
    """Refuse a column whose name says one unit and the row of units, or the cells, below it another."""
    if name and below and is_unit(name) and is_unit(below) and not same_unit(name, below):
        findings.add(
            FILE,
            "unit_contradicts",
            f"The header of column {column!r} says {name} and below it stands {below}: correct the file, or say which "
            f'holds with `--column "{column}=CHANNEL:{below}" --override-units`.',
            column=column,
            value=below,
        )
