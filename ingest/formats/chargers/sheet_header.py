"""The header of a hand-kept sheet of recharges: which column plays which role, in which unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ingest.formats.chargers.sheet_cells import FACTORS
from ingest.model import Declarations
from ingest.tables.header_cells import normal_unit, parse_header, squash, strip_comment
from ingest.text.cells import split_cells
from ingest.text.delimiters import CANDIDATES
from ingest.text.source import TextSource

_WRITTEN_AS = {
    "run": "run, run name, run id, run no, run number, experiment, exp, trial, test",
    "charge": "mah, ah, charge, charged, capacity, recharge, mah in, charge in, charged mah, mah charged, mah added",
    "duration": "minutes, min, mins, seconds, hours, duration, time, charge time, charging time, recharge time",
    "end_voltage": "end voltage, voltage, final voltage, end v, v end, volts, v",
    "pack": "pack, battery, pack id, battery id, lipo, accu",
    "ended": "ended, end time, finished, date, datetime, date and time, when, ended at, time ended",
    "mode": "mode, program",
}
_ROLE_OF = {squash(word): role for role, words in _WRITTEN_AS.items() for word in words.split(",")}

# Names that are units themselves, and the end voltage of labbook's own sheet, which is in volts by definition.
_UNIT_OF_NAME = {
    "mah": "mAh", "mahin": "mAh", "chargedmah": "mAh", "mahcharged": "mAh", "mahadded": "mAh", "ah": "Ah",
    "minutes": "min", "min": "min", "mins": "min", "seconds": "s", "hours": "h", "volts": "V", "v": "V",
    "endvoltage": "V",
}  # fmt: skip
_TITLE_LINES = 30


@dataclass(frozen=True, slots=True)
class SheetColumn:
    """One role of a recharge: where it stands, how its header is written, in which unit (None: not stated)."""

    position: int
    name: str
    unit: str | None


@dataclass(frozen=True, slots=True)
class SheetHeader:
    """The header line of a sheet: its number, its cells, the columns by role and the names of those without one."""

    delimiter: bytes
    line: int
    cells: tuple[bytes, ...]
    columns: dict[str, SheetColumn]
    ignored: tuple[str, ...]


def find_sheet_header(source: TextSource, declared: Declarations) -> SheetHeader | None:
    """Return the first line that names a charge and a run or a pack, under the delimiter that explains most of it."""
    for line in source.head_lines(_TITLE_LINES):
        headers = [
            _header(source, line.number, cells, delimiter, declared)
            for delimiter in CANDIDATES[:-1]
            if delimiter in line.content and (cells := split_cells(line.content, delimiter))
        ]
        fitting = [
            header for header in headers if "charge" in header.columns and header.columns.keys() & {"run", "pack"}
        ]
        if fitting:
            return max(fitting, key=lambda header: len(header.columns))
    return None


def _header(
    source: TextSource, number: int, cells: Sequence[bytes], delimiter: bytes, declared: Declarations
) -> SheetHeader:
    columns: dict[str, SheetColumn] = {}
    ignored = []
    for position, raw in enumerate(cells):
        text = strip_comment(source.decode(raw))
        role, unit = _role(text, declared)
        # A column `battery [V]` is a voltage over time and no name of a pack.
        fits = unit is None or unit in FACTORS[role] if role in FACTORS else role is not None and unit is None
        if role is not None and fits and role not in columns:
            columns[role] = SheetColumn(position, text, unit)
        elif text:
            ignored.append(text)
    return SheetHeader(delimiter, number, tuple(cells), columns, tuple(ignored))


def _role(text: str, declared: Declarations) -> tuple[str | None, str | None]:
    """Return role and unit of a header cell, what is declared about it first."""
    cell = parse_header(text)
    base, unit = cell.base, cell.unit
    if cell.suffix_base is not None and squash(cell.suffix_base) in _ROLE_OF and squash(base) not in _ROLE_OF:
        base, unit = cell.suffix_base, cell.suffix_unit
    role = _ROLE_OF.get(squash(base))
    unit = unit or _UNIT_OF_NAME.get(squash(base))
    said = declared.columns.get(text) or declared.columns.get(cell.base)
    if said is not None:
        role = said.channel or role
        unit = (normal_unit(said.unit) if said.unit else None) or unit
    return (role if role in _WRITTEN_AS else None), unit
