"""Hand-kept sheets of recharges: one row a recharge with run, charge, duration, end voltage and pack, in any spelling.

labbook's own sheet is `run,mAh,minutes,end_voltage,pack[,ended][,mode]`. Recharges of sheets and of chargers' logs are
held against what is known of the packs: none takes much more than it holds.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter

from data_schema.vocabulary import ChargeMode, FileRole
from ingest.channels.names import is_unit, normal_unit, parse_header, refuse_other_unit, squash, strip_comment
from ingest.declared import declared_columns, flag_names, flag_of, note_absent, without
from ingest.formats.format import NAMES, Format, Head, spelt
from ingest.model import (
    FILE,
    NOTE,
    ROW,
    ChargeRow,
    ColumnDeclaration,
    ColumnUse,
    Declarations,
    FindingCollector,
    PackFacts,
    Reading,
    TableUse,
    TextShape,
)
from ingest.tables.sheet import RowFault, checked, head_rows, is_ended, text_rows
from ingest.text import (
    BETWEEN_CELLS,
    HEAD_LINES,
    CellFault,
    TextSource,
    decimal_sign_of,
    may_group,
    parse_cell,
    too_wide,
)
from ingest.timebase.clock import Unclear, date_order, day_of, iso_text, parse_stamp, to_utc

_SUMMARIES = frozenset({"total", "totals", "sum", "mean", "average", "summe", "mittel"})
_TAIL = re.compile(r"\D(\d*)$")
_LEFT_OUT = "the row is left out"

Texts = Mapping[str, str]
"""The cells of a row by what their columns hold."""


def _recognise(head: Head) -> str | None:
    """A header that names a charge, and a run or a pack, in known words or as declared."""
    if find_sheet_header(head.text, head.declared) is None:
        return None
    return "a header that names a charge, and a run or a pack"


def _read(head: Head, findings: FindingCollector) -> Reading:
    declared = head.declared
    header = find_sheet_header(head.text, declared)
    if header is None:
        message = 'No line names a column of charges: say which one holds them with `--column "NAME=charge:UNIT"`, or '
        message += "with `header_row` and `columns` in a [profiles.NAME] table of labbook.toml."
        findings.add(FILE, "charge_column_missing", message)
        return Reading()
    if too_wide(len(header.names), declared, findings):
        return Reading()
    note_absent(declared, header.names, findings)
    for name in header.ignored:
        message = "The column is no part of a recharge: it stays in the raw copy only."
        findings.add(NOTE, "column_ignored", message, column=name)
    _report_columns(header, declared, findings)
    rows = list(_rows(head.text, header, declared, findings))
    texts = [text for _, text in rows if text is not None]
    _ask_units(header, texts, findings)
    _refuse_capacity(header, texts, findings)
    decimal = declared.decimal_sign or _decimal_sign(texts, findings)
    findings.tables.append(_use(header, decimal or ".", declared))
    dates = _date_order(header, texts, declared, findings)
    advice = {role: _other_units(role, texts, decimal, header) for role in AMOUNTS if role in header.columns}
    charges: list[ChargeRow] = []
    for line, text in rows:
        if text is not None:
            ended = _ended(text) or None
            utc = None if ended is None else _instant(ended, dates, line, declared.time_zone, findings)
            when = utc, ended
            charge = _charge(len(charges) + 1, line, text, when, header, decimal, advice, findings)
            charges += [] if charge is None else [charge]
    _note_repeated_runs(charges, findings)
    # A charger shows all its numbers in one step: the finest one met, since 0.47 may have been 0.470.
    finest = min((charge.resolution_mah for charge in charges), default=0.0)
    charges = [dataclasses.replace(charge, resolution_mah=finest) for charge in charges]
    return Reading((), tuple(charges), len(rows), len(rows) - len(charges), FileRole.CHARGE)


def _report_columns(header: SheetHeader, declared: Declarations, findings: FindingCollector) -> None:
    """Refuse two columns that may both be what was measured, and units that contradict each other."""
    for role, rival in header.rivals.items():
        column = header.columns[role]
        unit = f":{column.unit or 'UNIT'}" if role in AMOUNTS else ""
        both = f"Columns {column.name!r} and {rival!r}"
        message = f"{both} are both declared as {role}: declare one of them."
        if not column.is_declared:
            message = f"{both} may both be the {role.replace('_', ' ')}: say which with "
            message += f'`--column "{header.flags[column.position]}={role}{unit}"`.'
        findings.add(FILE, "column_ambiguous", message, column=rival)
    for role, column in header.columns.items():
        if role in AMOUNTS:
            refuse_other_unit(column.name, column.header_unit, column.unit, declared, findings)
            if column.unit is not None and column.unit not in AMOUNTS[role].factors:
                message = (
                    f"Column {column.name!r} is declared as {role} and its unit is {column.unit}: say which it is in "
                    f'with `--column "{header.flags[column.position]}={role}:UNIT" --override-units` '
                    f"({' or '.join(AMOUNTS[role].factors)}), or declare another column."
                )
                findings.add(FILE, "unit_not_convertible", message, column=column.name, value=column.unit)


def _refuse_capacity(header: SheetHeader, texts: Sequence[Texts], findings: FindingCollector) -> None:
    """Refuse a lone column `capacity` that is the same in all rows: what packs can hold, not what was charged."""
    column = header.columns["charge"]
    if column.is_capacity and len(texts) > 1 and len({text["charge"] for text in texts}) == 1:
        message = (
            f"Column {column.name!r} is {texts[0]['charge']} in all rows, as a pack's capacity is: say what was "
            'charged with `--column "NAME=charge:UNIT"`, or that this is it with '
            f'`--column "{header.flags[column.position]}=charge"`.'
        )
        findings.add(FILE, "charge_unclear", message, column=column.name)


def _may_be_cut(role: str | None, cell: str, above: list[str]) -> bool:
    """Whether letters or digits may be missing at the end of a cell, given those above it in its column.

    A number is whole with as many digits after its last sign as all above; a whole number, and the name of a run, may
    always have gone on; a word not if it stands above, or is as long as any.
    """
    if role is None:
        return False
    if cell[:1] in "0123456789.,+-":
        tails = [_TAIL.search(text) for text in (cell, *above) if text]
        digits = {None if tail is None else len(tail[1]) for tail in tails}
        return len(tails) == 1 or None in digits or len(digits) > 1
    return role == "run" or not above or (cell not in above and len(cell) < max(map(len, above)))


def _is_last_row_cut(
    cells: list[str],
    fewest: int,
    above: list[str],
    line: int,
    header: SheetHeader,
    complete: bool | None,
    findings: FindingCollector,
) -> bool:
    """Report a last line without line end; whether its last cell may be cut, 79 for 799, or cells are missing.

    `fewest` is how many cells a whole row has at least, `above` are the last cells of such rows.
    """
    if len(cells) < fewest or (not cells[-1] and any(above)):
        message = f"The last line ends in the middle; {_LEFT_OUT}."
        findings.add(ROW, "last_line_cut", message, lines=[line], value=_shown(cells, header))
        return True
    role = next((role for role, column in header.columns.items() if column.position == len(cells) - 1), None)
    if _may_be_cut(role, cells[-1], above if len(cells) == fewest else []) and not complete:
        message = (
            f"The last line has no line end and its last cell {cells[-1]!r} may be cut, as when a copy stops: "
            f"{_LEFT_OUT}; end the file with a line end if it is whole, or say `--complete`."
        )
        findings.add(ROW, "last_cell_cut", message, lines=[line], value=cells[-1])
        return True
    message = "The last line has no line end: check that its last cell is complete."
    findings.add(NOTE, "no_final_newline", message, lines=[line])
    return False


def _shown(row: list[str] | RowFault, header: SheetHeader) -> str | None:
    return header.delimiter.decode().join(row) if isinstance(row, list) else None


def _rows(
    source: TextSource, header: SheetHeader, declared: Declarations, findings: FindingCollector
) -> Iterator[tuple[int, Texts | None]]:
    """Yield line number and texts of every row below the header; None for a row that is left out."""
    width = fewest = len(header.names)
    charge = header.columns["charge"].position
    below = [row for row in text_rows(source, header.delimiter, b" ") if row[0] > header.line]
    above: list[str] = []
    for place, (line, row) in enumerate(below, start=1):
        if isinstance(row, list):
            is_unended = place == len(below) and not is_ended(source)
            if is_unended and _is_last_row_cut(row, fewest, above, line, header, declared.complete, findings):
                yield line, None
                continue
            above += [row[-1]] if len(row) == fewest else []
            fewest = min(fewest, len(row))
        cells = checked(row, header.names)
        if isinstance(cells, RowFault):
            message = f"The row is left out: {cells.sentence}"
            findings.add(ROW, cells.rule, message, lines=[line], value=_shown(row, header))
            yield line, None
            continue
        while not cells[-1]:
            cells.pop()
        is_header = tuple(cells) == header.cells[: len(cells)]
        is_filled = any(cell and _NUMBER.fullmatch(cell) for cell in cells[charge : charge + 1])
        if not is_header and not is_filled and is_sheet_header(cells, header.delimiter, declared):
            message = "Another header stands among the rows, with other columns: keep one header a sheet."
            findings.add(FILE, "second_header", message, lines=[line], value=_shown(cells, header))
        elif not _is_no_row(cells, is_header, line, header, findings):
            cells += [""] * (width - len(cells))
            yield line, {role: cells[column.position] for role, column in header.columns.items()}


def _is_no_row(
    cells: Sequence[str], is_header: bool, line: int, header: SheetHeader, findings: FindingCollector
) -> bool:
    """Whether a line is a comment, the header again, a total, or the row of a run not recharged yet; noted."""
    charge = header.columns["charge"].position
    if cells[0].startswith("#"):
        rule, message = "comment_line", "Comment lines are skipped."
    elif is_header:
        rule, message = "header_repeated", "The header stands again; it is skipped."
    elif squash(cells[0]) in _SUMMARIES:
        rule, message = "summary_row", "A row of totals is skipped."
    elif not any(cells[charge : charge + 1]):
        rule, message = "row_not_filled", "A row without a charge is not filled in yet: it is skipped."
    else:
        return False
    findings.add(NOTE, rule, message, lines=[line], value=cells[0] if rule == "row_not_filled" else None)
    return True


def _other_units(role: str, texts: Sequence[Texts], decimal: str | None, header: SheetHeader) -> str:
    """Return the flags of the other units in which all cells of a column are possible."""
    column, cells = header.columns[role], _filled(role, texts)
    advice = ""
    for other in AMOUNTS[role].factors if column.unit is not None else ():
        possible = (isinstance(parse_quantity(role, cell, other, decimal or "."), Quantity) for cell in cells)
        if column.unit != other and all(possible):
            flag = f"{header.flags[column.position]}={role}:{other}"
            advice += f' If all are in {other}, say `--column "{flag}" --override-units`.'
    return advice


def _filled(role: str, texts: Sequence[Texts]) -> list[str]:
    return [text[role] for text in texts if text.get(role)]


def _ask_units(header: SheetHeader, texts: Sequence[Texts], findings: FindingCollector) -> None:
    """Refuse a sheet with a column that has no unit, neither in the header nor in most cells."""
    for role, amount in AMOUNTS.items():
        column = header.columns.get(role)
        if column is None or column.unit is not None:
            continue
        cells = _filled(role, texts)
        missing = {
            unit: sum(parse_quantity(role, cell, unit, ".") == UNIT_MISSING for cell in cells)
            for unit in (None, *amount.factors)
        }
        reading = [unit for unit, count in missing.items() if 2 * count <= len(cells)]
        if None not in reading:
            findings.add(
                FILE,
                "unit_missing",
                f"The unit of column {column.name!r} is stated nowhere: write it into the header, or say "
                f'`--column "{header.flags[column.position]}={role}:UNIT"` '
                f"(UNIT: one of {', '.join(unit for unit in reading if unit)}).",
                column=column.name,
            )


def _decimal_sign(texts: Sequence[Texts], findings: FindingCollector) -> str | None:
    """Return the sign that most numbers are written with; None where all with a comma may be thousands."""
    cells = [text[role].split(" ")[0] for text in texts for role in AMOUNTS if text.get(role)]
    sign, unclear = decimal_sign_of([cell.encode("latin-1", errors="replace") for cell in cells])
    if unclear is None and sign == b",":
        findings.add(NOTE, "decimal_comma", "Numbers are written with a decimal comma; read as such.")
    return None if unclear is not None else sign.decode()


def _use(header: SheetHeader, decimal: str, declared: Declarations) -> TableUse:
    roles = {column.position: (role, column) for role, column in header.columns.items()}
    declarations = declared_columns(declared, header.names)
    uses = []
    for position, name in enumerate(header.names):
        if position not in roles:
            uses.append(ColumnUse(position + 1, name, None, left_out="it is no part of a recharge"))
            continue
        role, column = roles[position]
        is_declared = position in declarations and declarations[position].unit
        unit_from = declared.source if is_declared else "header" if column.unit else None
        stored = AMOUNTS[role].unit if role in AMOUNTS else None
        uses.append(ColumnUse(position + 1, name, role, column.unit, stored, unit_from))
    line = header.line if any(header.cells) else None
    return TableUse(TextShape(header.delimiter.decode(), decimal, line, None, header.line + 1), tuple(uses))


def _ended(text: Texts) -> str:
    """Return when a recharge ended as written; a date of its own in `ended` counts, not that of the column of dates."""
    ended = text.get("ended", "")
    stamp = parse_stamp(ended)
    whole = stamp is not None and stamp.date is not None
    return ended if whole else f"{text.get('date', '')} {ended}".strip()


def _date_order(
    header: SheetHeader, texts: Sequence[Texts], declared: Declarations, findings: FindingCollector
) -> str | None:
    """Return the order of the dates at which recharges ended; None, noted, where it stays open."""
    stamps = [stamp for stamp in map(parse_stamp, map(_ended, texts)) if stamp is not None]
    order = date_order(stamps, declared.date_format)
    if isinstance(order, Unclear):
        message = f"When recharges ended is kept as text only: {order.message}"
        column = next(header.columns[role].name for role in ("date", "ended") if role in header.columns)
        findings.add(NOTE, order.rule, message, column=column)
        return None
    return order


def _charge(
    row_number: int,
    line: int,
    text: Texts,
    when: tuple[str | None, str | None],
    header: SheetHeader,
    decimal: str | None,
    advice: Texts,
    findings: FindingCollector,
) -> ChargeRow | None:
    """Return one recharge, or None when something in its row, all of it reported, cannot be read.

    `when` is the instant at which it ended and the text of that, `decimal` None where no number tells a decimal comma
    from one of thousands, `advice` what to do, by role, where a value is none that a recharge has.
    """
    read = {
        role: parse_quantity(role, text[role], header.columns[role].unit, decimal) for role in AMOUNTS if text.get(role)
    }
    amounts = {role: found for role, found in read.items() if isinstance(found, Quantity)}
    faults = [(role, found) for role, found in read.items() if isinstance(found, CellFault)]
    charge, mode = amounts.get("charge"), parse_mode(text.get("mode", ""))
    if isinstance(mode, CellFault):
        faults.append(("mode", mode))
    if charge is not None and charge.value < 0 and mode is not ChargeMode.DISCHARGE:
        faults.append(("charge", _NEGATIVE))
    for role, fault in faults:
        message = fault.message + (advice[role] if fault in (OUT_OF_RANGE, BELOW_ONE) else "")
        findings.add(ROW, fault.rule, message, column=header.columns[role].name, lines=[line], value=text[role])
    if faults or charge is None or isinstance(mode, CellFault):
        return None
    return ChargeRow(
        row_number,
        text.get("run") or None,
        text.get("pack") or None,
        abs(charge.value),
        charge.resolution,
        amounts["duration"].value if "duration" in amounts else None,
        amounts["end_voltage"].value if "end_voltage" in amounts else None,
        mode or ChargeMode.CHARGE,
        *when,
        line,
    )


def _instant(ended: str, dates: str | None, line: int, zone: str | None, findings: FindingCollector) -> str | None:
    """Return the instant at which a recharge ended, None, noted, where the text has none; `dates` is their order."""
    stamp = parse_stamp(ended)
    if dates is not None and stamp is not None and stamp.date is not None and day_of(stamp, dates) is None:
        *parts, sign = stamp.date
        message = f"There is no day {sign.join(parts)}, read as {dates}: {ended!r} is kept as text only."
        findings.add(NOTE, "instant_unknown", message, lines=[line], value=ended)
        return None
    return to_utc(iso_text(ended, dates or "y-m-d"), zone, findings)


def _note_repeated_runs(charges: Sequence[ChargeRow], findings: FindingCollector) -> None:
    seen: set[str] = set()
    for charge in charges:
        if charge.stated_run is not None and charge.stated_run in seen:
            message = (
                "A run stands in more than one row: all are read, and one charge of a run counts, and what is added to "
                "it where its pack was charged in parts (`labbook assign FILE#ROW RUN --add`)."
            )
            lines = () if charge.line is None else [charge.line]
            findings.add(NOTE, "run_repeated", message, lines=lines, value=charge.stated_run)
        seen.add(charge.stated_run or "")


@dataclass(frozen=True, slots=True)
class Amount:
    """A quantity of a recharge: the unit it is stored in, what 1 is there of each unit that sheets use, and how much of
    it a robot's pack can have.
    """

    unit: str
    factors: Mapping[str, float]
    low: float
    high: float


AMOUNTS = {
    "charge": Amount("mAh", {"mAh": 1.0, "Ah": 1e3}, 0.0, 1e5),
    "duration": Amount("s", {"s": 1.0, "min": 60.0, "h": 3600.0}, 1.0, 172_800.0),
    "end_voltage": Amount("V", {"V": 1.0, "mV": 1e-3}, 0.5, 100.0),
}

# No other blank: a damaged digit may be one.
_QUANTITY = re.compile("([+-]?[\\d.,' ]*\\d[.,]?)[ \t\u00a0\u202f]*([A-Za-zµ*.]*)")
_SHOWN = 60
"""Characters of a cell that a finding shows."""
_CLOCK = re.compile(r"(?:(\d+):)?(\d+):(\d\d)")
_WORDS = {
    ChargeMode.CHARGE: "charge charging chg c balance balancecharge storage",
    ChargeMode.DISCHARGE: "discharge discharging dchg dsc d",
}
_MODES = {word: mode for mode, words in _WORDS.items() for word in words.split()}

_NEGATIVE = CellFault(
    "charge_sign",
    "A negative charge in a row that is no discharge: write 'discharge' as its mode; the row is left out.",
)
_UNCLEAR = CellFault(
    "decimal_sign_unclear",
    "A number may be a decimal or a thousand: say which with `--decimal ,` or `--decimal .`, or write it otherwise; "
    "the row is left out.",
)
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


def parse_quantity(role: str, text: str, unit: str | None, decimal: str | None) -> Quantity | CellFault:
    """Read a cell of the column `role` (a key of `AMOUNTS`), which is not blank; `unit` is the header's.

    `decimal` is None where a comma may be that of decimals or of thousands.
    """
    if role == "duration" and (clock := _CLOCK.fullmatch(text)):
        return _from_clock(clock, unit)
    match = _QUANTITY.fullmatch(text)
    if match is None:
        return CellFault("not_a_number", f"{text[:_SHOWN]!r} is no number; the row is left out.")
    number = match[1].strip().encode("ascii", errors="replace")
    if decimal is None and b"," in number and may_group(number):
        return _UNCLEAR
    own = normal_unit(match[2]) if match[2] else None
    if own is not None and unit is not None and own != unit:
        return _other_unit(text[:_SHOWN], match[2], unit)
    factor = AMOUNTS[role].factors.get(own or unit or "")
    if factor is None:
        return UNIT_MISSING
    parsed = parse_cell(number, (decimal or ".").encode())
    if isinstance(parsed, CellFault):
        return parsed
    decimals = len(number) - 1 - max(number.find(b"."), number.find(b",")) if b"." in number or b"," in number else 0
    if role == "charge" and factor == 1.0 and decimals == 3:
        return BELOW_ONE if abs(parsed) < 1.0 else THOUSAND
    return _possible(role, parsed * factor, factor * 10.0**-decimals)


def _possible(role: str, value: float, resolution: float) -> Quantity | CellFault:
    is_possible = AMOUNTS[role].low <= abs(value) <= AMOUNTS[role].high
    return Quantity(value, resolution) if is_possible else OUT_OF_RANGE


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
    return _possible("duration", float(seconds), 1.0)


def parse_mode(text: str) -> ChargeMode | CellFault | None:
    """Read what the charger was doing; None for a blank cell."""
    mode = _MODES.get(squash(text))
    if mode is None and squash(text):
        return CellFault(
            "mode_unknown", f"{text!r} is no mode of a charger: write 'charge' or 'discharge'; the row is left out."
        )
    return mode


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
_LESS_TELLING = dict.fromkeys(("mah", "ah", "charge", "voltage", "volts", "v", "datetime", "dateandtime", "when"), 1)
_LESS_TELLING["capacity"] = 2
_DECLARED = -1

# Names that are units themselves, and the end voltage of labbook's own sheet, which is in volts by definition.
_NAMES_OF_UNITS = {
    "mAh": "mah mahin chargedmah mahcharged mahadded",
    "Ah": "ah",
    "min": "minutes min mins",
    "s": "seconds",
    "h": "hours",
    "V": "volts v endvoltage",
}
_UNIT_OF_NAME = {name: unit for unit, names in _NAMES_OF_UNITS.items() for name in names.split()}
_TITLE_LINES = 30
_IN_UNIT = re.compile(r"(?:^|[\s_(\[/])(m?Ah|[mk]?Wh|k?J|joules?)[)\]]?$")
"""The unit at the end of a heading of charges or energies."""
_NUMBER = re.compile(r"[\d\s.,;:|+-]*")
"""A row of such cells is no header, unless columns are declared by their places."""


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

    Where there is none, `cells` is empty. `flags` are how flags name the columns, `rivals` the names of further columns
    by role that have as good a claim.
    """

    delimiter: bytes
    line: int
    cells: tuple[str, ...]
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
    for headers in _headers(source, declared):
        fitting = [header for header in headers if _is_sheet(header, declared)]
        if fitting:
            return max(fitting, key=lambda header: len(header.columns))
    return None


def advice_on_sheet(source: TextSource, declared: Declarations) -> str | None:
    """Return advice on a header that is nearly one of a sheet; None where there is none such.

    It names charges, and all else in unknown words; or a run or a pack, and energies for charges.
    """
    for found in _headers(source, declared):
        for header in found if len(found) == 1 and not _is_sheet(found[0], declared) else ():
            named = {at: unit[1] for at, text in enumerate(header.names) if (unit := _IN_UNIT.search(text)) is not None}
            charged = [at for at, unit in named.items() if unit in AMOUNTS["charge"].factors]
            others = [at for at, text in enumerate(header.names) if text and at not in charged]
            if charged and others:
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


def is_sheet_header(cells: Sequence[str], delimiter: bytes, declared: Declarations) -> bool:
    """Whether a line is the header of a sheet: by its names, whatever is declared of columns by their place."""
    places = [name for name in (*declared.columns, *declared.profile_columns) if name.isdigit()]
    by_name = without(declared, places)
    return declared.header_row != 0 and _is_sheet(_header(0, cells, delimiter, by_name), by_name)


def _is_sheet(header: SheetHeader, declared: Declarations) -> bool:
    return "charge" in header.columns and (
        declared.format == "charger_sheet" or bool(header.columns.keys() & {"run", "pack"})
    )


def _headers(source: TextSource, declared: Declarations) -> Iterator[list[SheetHeader]]:
    """Yield what each of the first lines, or the one declared, is as a header, under the delimiters that part it."""
    only = (declared.first_row or 1) if declared.header_row == 0 else declared.header_row
    by_name = only is None and not declared.columns and not declared.profile_columns
    delimiters = BETWEEN_CELLS if declared.delimiter is None else (declared.delimiter.encode("latin-1"),)
    rows = head_rows(source, _TITLE_LINES if only is None else HEAD_LINES, delimiters, b" ")
    for number, under in groupby(rows, key=itemgetter(0)):
        yield [
            _header(number, cells, delimiter, declared)
            for _, delimiter, cells in under
            if isinstance(cells, list) and len(cells) > 1 and number == (only or number)
            if not by_name or not all(map(_NUMBER.fullmatch, cells))
        ]


def _header(number: int, cells: Sequence[str], delimiter: bytes, declared: Declarations) -> SheetHeader:
    """Return the header in a line; without one the columns are called by their numbers, and the line is a row."""
    found: dict[str, list[SheetColumn]] = {}
    named = declared.header_row != 0
    names = [strip_comment(cell) if named else str(place) for place, cell in enumerate(cells, start=1)]
    declaration = declared_columns(declared, names)
    for position, text in enumerate(names):
        role, column = _column(position, text, declaration.get(position))
        # A column `battery [V]` is a voltage over time and no name of a pack; `beendet um` may be declared as `ended`.
        fits = (
            column.rank == _DECLARED
            or column.unit is None
            or (role in AMOUNTS and column.unit in AMOUNTS[role].factors)
        )
        if role is not None and fits:
            found.setdefault(role, []).append(column)
    columns, rivals = {}, {}
    for role, candidates in found.items():
        columns[role] = min(candidates, key=lambda column: column.rank)
        equal = [column.name for column in candidates if column.rank == columns[role].rank]
        if len(equal) > 1 and (role in (*AMOUNTS, "ended") or columns[role].rank == _DECLARED):
            rivals[role] = equal[1]
    used = {column.position for column in columns.values()}
    ignored = tuple(text for position, text in enumerate(names) if text and position not in used)
    line, shown = (number, tuple(cells)) if named else (number - 1, ())
    return SheetHeader(delimiter, line, shown, tuple(names), flag_names(names), columns, ignored, rivals)


def _column(position: int, text: str, declaration: ColumnDeclaration | None) -> tuple[str | None, SheetColumn]:
    """Return the role of a header cell, None where it has none, and its column; what is declared stands first."""
    base, unit = parse_header(text).named(lambda name: squash(name) in _ROLE_OF)
    role, rank = _ROLE_OF.get(squash(base)), _LESS_TELLING.get(squash(base), 0)
    unit = header_unit = unit or _UNIT_OF_NAME.get(squash(base))
    if declaration is not None:
        role, rank = declaration.channel or role, _DECLARED if declaration.channel else rank
        unit = (normal_unit(declaration.unit) if declaration.unit else None) or unit
    return role if role in ROLES else None, SheetColumn(position, text, unit, header_unit, rank)


MOST_OF_CAPACITY = 1.3
"""More than this share of a pack's capacity is a typing error: no pack takes it."""
_IMPLAUSIBLE = "charge_implausible"
_MAH_PER_AH = 1e3


def check_packs(reading: Reading, packs: Sequence[PackFacts], findings: FindingCollector) -> Reading:
    """Return a reading without the recharges that their pack cannot take, each of them reported.

    A recharge without a pack of the book is compared with the largest. A column in mAh, by its heading, of nothing but
    numbers below a thousandth of that is refused: they may be Ah.
    """
    largest = max(packs, key=lambda pack: pack.capacity_mah)
    by_name = {pack.name: pack for pack in packs}
    of_charge = [by_name.get(charge.stated_pack or "", largest) for charge in reading.charges]
    column = next((use for table in findings.tables for use in table.columns if use.holds == "charge"), None)
    flag = "" if column is None else flag_of(findings.tables, column.name)
    remedy = _unit_remedy(column, flag) if column is not None and column.unit == "Ah" else ""  # in mAh it is less
    kept: list[ChargeRow] = []
    for charge, pack in zip(reading.charges, of_charge, strict=True):
        most_mah = MOST_OF_CAPACITY * pack.capacity_mah
        if charge.charge_mah <= most_mah:
            kept.append(dataclasses.replace(charge, row_number=len(kept) + 1))
            continue
        message = (
            f"{charge.charge_mah:g} mAh is more than pack {pack.name} can take ({most_mah:g} mAh): correct the number, "
            f"{remedy}or, if it is right, the pack's capacity, with `labbook correct "
            f"battery:{pack.name} capacity_mah=... --why ...` and in labbook.toml."
        )
        lines = [] if charge.line is None else [charge.line]
        value = f"{charge.charge_mah:g} mAh"
        findings.add(FILE if reading.parts else ROW, _IMPLAUSIBLE, message, lines=lines, value=value)
    _refuse_ah(reading, of_charge, column, flag, findings)
    left_out = len(reading.charges) - len(kept)
    return dataclasses.replace(reading, charges=tuple(kept), rows_rejected=reading.rows_rejected + left_out)


def _refuse_ah(
    reading: Reading, packs: Sequence[PackFacts], column: ColumnUse | None, flag: str, findings: FindingCollector
) -> None:
    if column is None or column.unit != "mAh" or column.unit_from != "header":
        return
    most = [MOST_OF_CAPACITY * pack.capacity_mah for pack in packs]
    charges = [charge.charge_mah for charge in reading.charges]
    if any(charges) and all(mah * _MAH_PER_AH <= top for mah, top in zip(charges, most, strict=True)):
        message = (
            f"All charges are {max(charges):g} mAh or less, as if in Ah: correct {_unit_remedy(column, flag)}or, if "
            f'they are mAh, say so: `--column "{flag}=charge:mAh"`.'
        )
        lines = [charge.line for charge in reading.charges if charge.line is not None]
        findings.add(FILE, _IMPLAUSIBLE, message, lines=lines, value=f"{max(charges):g} mAh")


def _unit_remedy(column: ColumnUse | None, flag: str) -> str:
    """Say how the other unit is declared, of a column whose heading has one."""
    if column is None or column.unit is None:
        return ""
    other = "mAh" if column.unit == "Ah" else "Ah"
    return f'the heading {column.name!r} if these are {other} (`--column "{flag}=charge:{other}" --override-units`), '


FORMAT = Format(
    "charger_sheet", 6, _recognise, _read, clues=tuple(map(spelt, ("charge", "capacity", "ah"))), score=NAMES
)
