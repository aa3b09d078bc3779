"""Cells of hand-kept sheets: quantities with or without their unit, durations as 12:30, modes as people write them."""

from __future__ import annotations

import re
from dataclasses import dataclass

from data_schema.vocabulary import ChargeMode
from ingest.tables.header_cells import normal_unit, squash
from ingest.text.cells import CellFault, parse_cell

# Factors from the units that sheets use to the unit a recharge is stored in.
FACTORS = {
    "charge": {"mAh": 1.0, "Ah": 1e3},
    "duration": {"s": 1.0, "min": 60.0, "h": 3600.0},
    "end_voltage": {"V": 1.0, "mV": 1e-3},
}
STORED_UNIT = {"charge": "mAh", "duration": "s", "end_voltage": "V"}

LIMITS = {"charge": (0.0, 1e5), "duration": (1.0, 172_800.0), "end_voltage": (0.5, 100.0)}
"""What a recharge of a robot's pack can be, in stored units."""

# No other blank: a damaged digit may be one.
_QUANTITY = re.compile("([+-]?[\\d.,' ]*\\d[.,]?)[ \t\u00a0\u202f]*([A-Za-zµ*.]*)")
_CLOCK = re.compile(r"(?:(\d+):)?(\d+):(\d\d)")
_MODES = {
    "": None, "charge": ChargeMode.CHARGE, "charging": ChargeMode.CHARGE, "chg": ChargeMode.CHARGE,
    "c": ChargeMode.CHARGE, "balance": ChargeMode.CHARGE, "balancecharge": ChargeMode.CHARGE,
    "storage": ChargeMode.CHARGE,
    "discharge": ChargeMode.DISCHARGE, "discharging": ChargeMode.DISCHARGE, "dchg": ChargeMode.DISCHARGE,
    "dsc": ChargeMode.DISCHARGE, "d": ChargeMode.DISCHARGE,
}  # fmt: skip

UNIT_MISSING = CellFault("unit_missing", "The unit is neither in the header nor in the cell; the row is left out.")
UNIT_OTHER = CellFault("unit_differs", "The cell names another unit than its column; the row is left out.")
NO_QUANTITY = CellFault("not_a_number", "A cell is no number; the row is left out.")
THOUSAND = CellFault(
    "thousands_separator",
    "A whole number of mAh with three decimals may be thousands; the row is left out; write 1234 or 1.2.",
)
OUT_OF_RANGE = CellFault("out_of_range", "No recharge has such a value: a wrong unit or a slip; the row is left out.")


@dataclass(frozen=True, slots=True)
class Quantity:
    """A value in its stored unit, and the step of its last digit."""

    value: float
    resolution: float


def parse_quantity(role: str, text: str, unit: str | None, decimal: bytes) -> Quantity | CellFault:
    """Read a cell of the column `role` (a key of `FACTORS`); `unit` is the header's. The text is not blank."""
    if role == "duration" and (clock := _CLOCK.fullmatch(text)):
        return _from_clock(clock, unit)
    match = _QUANTITY.fullmatch(text)
    if match is None:
        return NO_QUANTITY
    own = normal_unit(match[2]) if match[2] else None
    if own is not None and unit is not None and own != unit:
        return UNIT_OTHER
    factor = FACTORS[role].get(own or unit or "")
    if factor is None:
        return UNIT_MISSING
    number = match[1].strip()
    parsed = parse_cell(number.encode("ascii", errors="replace"), decimal)
    if isinstance(parsed, CellFault):
        return parsed
    decimals = len(re.split(r"[.,]", number)[1]) if re.search(r"[.,]", number) else 0
    if role == "charge" and factor == 1.0 and decimals == 3:
        return THOUSAND
    low, high = LIMITS[role]
    value = parsed * factor
    if not low <= abs(value) <= high:
        return OUT_OF_RANGE
    return Quantity(value, factor * 10.0**-decimals)


def _from_clock(clock: re.Match[str], unit: str | None) -> Quantity | CellFault:
    """Read `h:mm:ss`, or `12:30`: minutes and seconds in a column of minutes, hours and minutes in one of hours."""
    first, second, third = int(clock[1] or 0), int(clock[2]), int(clock[3])
    if clock[1] is not None:
        seconds = 3600 * first + 60 * second + third
    elif unit == "min":
        seconds = 60 * second + third
    elif unit == "h":
        seconds = 3600 * second + 60 * third
    else:
        return UNIT_MISSING
    low, high = LIMITS["duration"]
    return Quantity(float(seconds), 1.0) if low <= seconds <= high else OUT_OF_RANGE


def parse_mode(text: str) -> ChargeMode | CellFault | None:
    """Read what the charger was doing; None for a blank cell."""
    try:
        return _MODES[squash(text)]
    except KeyError:
        return CellFault(
            "mode_unknown", f"{text!r} is no mode of a charger: write 'charge' or 'discharge'; the row is left out."
        )
