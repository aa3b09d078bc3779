"""Columns of a hand-kept sheet of recharges: which one has which role, in which unit; and the values of its cells.

Quantities stand with or without their unit, durations as 12:30, modes as people write them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.vocabulary import ChargeMode
from ingest.channels.names import is_unit, normal_unit, parse_header, squash, strip_comment
from ingest.declared import declared_columns, flag_names, without
from ingest.model import ColumnDeclaration, Declarations
from ingest.text.cells import CANDIDATES, CellFault, parse_cell, split_cells
from ingest.text.source import TextSource

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
_SHOWN = 60
"""Characters of a cell that a finding shows."""
_CLOCK = re.compile(r"(?:(\d+):)?(\d+):(\d\d)")
_MODES = {
    "": None, "charge": ChargeMode.CHARGE, "charging": ChargeMode.CHARGE, "chg": ChargeMode.CHARGE,
    "c": ChargeMode.CHARGE, "balance": ChargeMode.CHARGE, "balancecharge": ChargeMode.CHARGE,
    "storage": ChargeMode.CHARGE,
    "discharge": ChargeMode.DISCHARGE, "discharging": ChargeMode.DISCHARGE, "dchg": ChargeMode.DISCHARGE,
    "dsc": ChargeMode.DISCHARGE, "d": ChargeMode.DISCHARGE,
}  # fmt: skip

UNIT_MISSING = CellFault("unit_missing", "The unit is neither in the header nor in the cell; the row is left out.")
THOUSAND = CellFault(
    "thousands_separator",
    "A whole number of mAh with three decimals may be thousands; the row is left out; write 1234 or 1.2.",
)
BELOW_ONE = CellFault(
    "out_of_range", "A charge below 1 mAh with three decimals is none that a charger shows; the row is left out."
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
        return CellFault("not_a_number", f"{text[:_SHOWN]!r} is no number; the row is left out.")
    own = normal_unit(match[2]) if match[2] else None
    if own is not None and unit is not None and own != unit:
        return _other_unit(text[:_SHOWN], match[2], unit)
    factor = FACTORS[role].get(own or unit or "")
    if factor is None:
        return UNIT_MISSING
    number = match[1].strip()
    parsed = parse_cell(number.encode("ascii", errors="replace"), decimal)
    if isinstance(parsed, CellFault):
        return parsed
    decimals = len(re.split(r"[.,]", number)[1]) if re.search(r"[.,]", number) else 0
    if role == "charge" and factor == 1.0 and decimals == 3:
        return BELOW_ONE if abs(parsed) < 1.0 else THOUSAND
    low, high = LIMITS[role]
    value = parsed * factor
    if not low <= abs(value) <= high:
        return OUT_OF_RANGE
    return Quantity(value, factor * 10.0**-decimals)


def _other_unit(text: str, own: str, unit: str) -> CellFault:
    """Say what is wrong with letters behind a number: another unit than the column's, or none at all, as in `39,l`."""
    if is_unit(own):
        message = f"{text!r} is in {own} and its column in {unit}; the row is left out; give one unit a column."
        return CellFault("unit_differs", message)
    return CellFault("not_a_number", f"{text!r} is no number, for {own!r} is no unit; the row is left out.")


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


ROLES = {
    "run": "run, run name, run id, run no, run number, experiment, exp, trial, test",
    "charge": "mah, ah, charge, charged, capacity, recharge, recharged, mah in, charge in, charged mah, mah charged, "
    "mah added",
    "duration": "minutes, min, mins, seconds, hours, duration, time, charge time, charging time, recharge time",
    "end_voltage": "end voltage, voltage, final voltage, end v, v end, volts, v",
    "pack": "pack, battery, pack id, battery id, lipo, accu",
    "ended": "ended, end time, finished, datetime, date and time, when, ended at, time ended",
    "mode": "mode, program",
    "date": "date",
}
"""What a column of a sheet holds, and the names under which people write it."""

_ROLE_OF = {squash(word): role for role, words in ROLES.items() for word in words.split(",") if word}

# Of two columns of one role the more telling name counts: what was charged, not what the pack can hold.
_LESS_TELLING = {
    "mah": 1, "ah": 1, "charge": 1, "capacity": 2, "voltage": 1, "volts": 1, "v": 1,
    "datetime": 1, "dateandtime": 1, "when": 1,
}  # fmt: skip
_DECLARED = -1

# Names that are units themselves, and the end voltage of labbook's own sheet, which is in volts by definition.
_UNIT_OF_NAME = {
    "mah": "mAh", "mahin": "mAh", "chargedmah": "mAh", "mahcharged": "mAh", "mahadded": "mAh", "ah": "Ah",
    "minutes": "min", "min": "min", "mins": "min", "seconds": "s", "hours": "h", "volts": "V", "v": "V",
    "endvoltage": "V",
}  # fmt: skip
_TITLE_LINES = 30
_IN_UNIT = re.compile(r"(?:^|[\s_(\[/])(m?Ah|[mk]?Wh|k?J|joules?)[)\]]?$")
"""The unit at the end of a heading of charges or energies."""
_NUMBERS = re.compile(rb"[\d\s.,;:|+-]*")
"""A line without a word: no header, unless columns are declared by their places."""


@dataclass(frozen=True, slots=True)
class SheetColumn:
    """One role of a recharge: where it stands, how its header is written, in which unit (None: not stated).

    `header_unit` is the header's own unit where another source states one too; `rank` is the less the more telling the
    name, -1 for a column that is declared.
    """

    position: int
    name: str
    unit: str | None
    header_unit: str | None = None
    rank: int = 0

    @property
    def is_declared(self) -> bool:
        """Whether a person said what the column is."""
        return self.rank == _DECLARED

    @property
    def is_capacity(self) -> bool:
        """Whether the name may as well be that of what a pack can hold."""
        return self.rank == _LESS_TELLING["capacity"]


@dataclass(frozen=True, slots=True)
class SheetHeader:
    """The header line of a sheet: its number, its cells, their names, the columns by role, the names without a role.

    `flags` are how flags name the columns, `rivals` the names of further columns by role that have as good a claim.
    """

    delimiter: bytes
    line: int
    cells: tuple[bytes, ...]
    names: tuple[str, ...]
    flags: tuple[str, ...]
    columns: dict[str, SheetColumn]
    ignored: tuple[str, ...]
    rivals: dict[str, str]


def find_sheet_header(source: TextSource, declared: Declarations) -> SheetHeader | None:
    """Return the first line that names a charge and a run or a pack, under the delimiter that explains most of it.

    Where the header row, or that there is none, is declared, only that line counts; a sheet declared as such needs no
    run and no pack.
    """
    delimiters = CANDIDATES[:-1] if declared.delimiter is None else (declared.delimiter.encode("latin-1"),)
    row = (declared.first_row or 1) if declared.header_row == 0 else declared.header_row
    lines = source.head_lines(_TITLE_LINES) if row is None else source.head_lines()
    by_name = row is None and not declared.columns and not declared.profile_columns
    for line in lines:
        if (row is not None and line.number != row) or (by_name and _NUMBERS.fullmatch(line.content)):
            continue
        headers = [
            _header(source, line.number, cells, delimiter, declared)
            for delimiter in delimiters
            if delimiter in line.content and (cells := split_cells(line.content, delimiter))
        ]
        fitting = [header for header in headers if _is_sheet(header, declared)]
        if fitting:
            return max(fitting, key=lambda header: len(header.columns))
    return None


def advice_on_sheet(source: TextSource, declared: Declarations, *, charges: bool) -> str | None:
    """Return advice on a header that is nearly one of a sheet; None where there is none such.

    It names a run or a pack, and energies for charges; or, where `charges` are looked for, these in unknown words.
    """
    for line in source.head_lines(_TITLE_LINES):
        signs = [sign for sign in CANDIDATES[:-1] if sign in line.content]
        for delimiter in signs if len(signs) == 1 else ():
            cells = split_cells(line.content, delimiter)
            header = _header(source, line.number, cells, delimiter, declared) if cells else None
            if header is None or _is_sheet(header, declared):
                continue
            named = {at: unit[1] for at, text in enumerate(header.names) if (unit := _IN_UNIT.search(text)) is not None}
            charged = [at for at, unit in named.items() if unit in FACTORS["charge"]]
            others = [at for at, text in enumerate(header.names) if text and at not in charged]
            if charges and charged and others:
                run = header.columns["run"].position if "run" in header.columns else others[0]
                flags = f'--column "{header.flags[run]}=run" '
                flags += f'--column "{header.flags[charged[0]]}=charge:{named[charged[0]]}"'
                return f"say which column names the run, or the pack, and which the charge, for example `{flags}`."
            if named and not charged and header.columns.keys() & {"run", "pack"}:
                energy = next(iter(named))
                return (
                    f"its column {header.names[energy]!r} is an energy and labbook counts charge: add what the charger "
                    f'shows in mAh or Ah; if this is it, say `--column "{header.flags[energy]}=charge:UNIT" '
                    "--override-units`."
                )
    return None


def is_sheet_header(source: TextSource, cells: Sequence[bytes], delimiter: bytes, declared: Declarations) -> bool:
    """Whether a line is the header of a sheet: by its names, whatever is declared of columns by their place."""
    places = [name for name in (*declared.columns, *declared.profile_columns) if name.isdigit()]
    by_name = without(declared, places)
    return declared.header_row != 0 and _is_sheet(_header(source, 0, cells, delimiter, by_name), by_name)


def _is_sheet(header: SheetHeader, declared: Declarations) -> bool:
    return "charge" in header.columns and (
        declared.format == "charger_sheet" or bool(header.columns.keys() & {"run", "pack"})
    )


def _header(
    source: TextSource, number: int, cells: Sequence[bytes], delimiter: bytes, declared: Declarations
) -> SheetHeader:
    """Return the header in a line; without one the columns are called by their numbers, and the line is a row."""
    found: dict[str, list[SheetColumn]] = {}
    named = declared.header_row != 0
    names = [strip_comment(source.decode(raw)) if named else str(place) for place, raw in enumerate(cells, start=1)]
    declaration = declared_columns(declared, names)
    for position, text in enumerate(names):
        role, column = _column(position, text, declaration.get(position))
        # A column `battery [V]` is a voltage over time and no name of a pack; `beendet um` may be declared as `ended`.
        fits = column.rank == _DECLARED or column.unit is None or column.unit in FACTORS.get(role or "", {})
        if role is not None and fits:
            found.setdefault(role, []).append(column)
    columns, rivals = {}, {}
    for role, candidates in found.items():
        columns[role] = min(candidates, key=lambda column: column.rank)
        equal = [column.name for column in candidates if column.rank == columns[role].rank]
        if len(equal) > 1 and (role in (*FACTORS, "ended") or columns[role].rank == _DECLARED):
            rivals[role] = equal[1]
    used = {column.position for column in columns.values()}
    ignored = tuple(text for position, text in enumerate(names) if text and position not in used)
    line, shown = (number, tuple(cells)) if named else (number - 1, (b"",) * len(cells))
    return SheetHeader(delimiter, line, shown, tuple(names), flag_names(names), columns, ignored, rivals)


def _column(position: int, text: str, declaration: ColumnDeclaration | None) -> tuple[str | None, SheetColumn]:
    """Return the role of a header cell, None where it has none, and its column; what is declared stands first."""
    cell = parse_header(text)
    base, unit = cell.base, cell.unit
    if cell.suffix_base is not None and squash(cell.suffix_base) in _ROLE_OF and squash(base) not in _ROLE_OF:
        base, unit = cell.suffix_base, cell.suffix_unit
    role, rank = _ROLE_OF.get(squash(base)), _LESS_TELLING.get(squash(base), 0)
    unit = header_unit = unit or _UNIT_OF_NAME.get(squash(base))
    if declaration is not None:
        role, rank = declaration.channel or role, _DECLARED if declaration.channel else rank
        unit = (normal_unit(declaration.unit) if declaration.unit else None) or unit
    return role if role in ROLES else None, SheetColumn(position, text, unit, header_unit, rank)
