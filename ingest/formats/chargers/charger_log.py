"""Procedures of a charger to signals and recharges: what the logs of all makers have in common.

What a charger put into a pack or took out of it is its counter, held against the current integrated over time.
"""

from __future__ import annotations

import dataclasses
import functools
import operator
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from data_schema.vocabulary import ChargeMode, FileRole
from ingest.channels.names import factor
from ingest.formats.format import LAYOUT, Format, Head
from ingest.instruments import Instrument
from ingest.model import (
    FILE,
    NOTE,
    ROW,
    BoolArray,
    ChargeRow,
    Declarations,
    FindingCollector,
    FloatArray,
    Reading,
    SignalPart,
)
from ingest.signals import read_signals
from ingest.tables.table import LineRows, array_table
from ingest.text import numbered_lines

_RECORD = re.compile(rb"\$\d{1,2}(?:;[^;\x00-\x1f]{0,24})+")
_HEAD_RECORD = re.compile(r"\$\d{1,2}(?:;[^;]*){3}")
_SHOWN = 60
_REPEATED = 20


def head_records(head: Head) -> list[list[str]]:
    """Return the fields, checksum included, of the records among the first lines; none where most lines are others."""
    lines = [line.replace("\0", "").strip() for line in head.lines]
    lines = [line for line in lines if line and not line.startswith("@")]
    records = [line[1:].split(";") for line in lines if _HEAD_RECORD.match(line)]
    return records if records and 2 * len(records) >= len(lines) else []


def usual_fields(records: Sequence[Sequence[str]]) -> int:
    """Return the most common number of fields, 0 of no records."""
    counts = Counter(map(len, records))
    return counts.most_common(1)[0][0] if counts else 0


def checksum_of(body: bytes) -> int:
    """Return the exclusive or of the bytes of a record up to the last `;`, which is included."""
    return functools.reduce(operator.xor, body, 0)


def _read_records(
    head: Head, findings: FindingCollector, zero_is_none: bool
) -> Iterator[tuple[int, list[bytes] | None]]:
    """Yield line number and fields, without `$` and checksum, of every line; None, reported, for one that is no record
    or has a wrong checksum.
    """
    data, start = (head.data, 0) if head.source is None else (head.source.data, head.source.start)
    for number, _, content, _ in numbered_lines(data, start):
        line = content.strip(b"\0\x1a \t")
        if not line:
            continue
        if line.startswith(b"@"):
            text = line.decode("latin-1")
            findings.add(NOTE, "instrument", f"Written by {text[1:]}.", lines=[number], value=text)
            continue
        body, _, checksum = line.rpartition(b";")
        if not _RECORD.fullmatch(line) or not checksum.isdigit():
            reject_record(number, line, findings)
            yield number, None
        elif checksum_of(body + b";") != int(checksum) and not (zero_is_none and int(checksum) == 0):
            message = "The checksum of the line is wrong: bytes were lost or changed; it is left out."
            findings.add(ROW, "checksum_wrong", message, lines=[number], value=line[:_SHOWN].decode("latin-1"))
            yield number, None
        else:
            yield number, body[1:].split(b";")


def reject_record(number: int, line: bytes, findings: FindingCollector) -> None:
    """Report a line that is no record of its format."""
    message = "The line is no record `$channel;state;...;checksum` of this format; it is left out."
    findings.add(ROW, "record_malformed", message, lines=[number], value=line[:_SHOWN].decode("latin-1"))


@dataclass(slots=True, kw_only=True)
class Procedure(LineRows):
    """The records of one output from one start of the charger."""

    channel: int


class Sequel(Enum):
    """What a record is to the procedure that is going on."""

    GOES_ON = "goes on"
    BEGINS = "begins another"
    OUT_OF_ORDER = "out of order"


Judge = Callable[[Procedure, list[float]], Sequel]


def by_clock(position: int, soon: float) -> Judge:
    """Return the judge of records with a clock at `position`: one that goes back to where the procedure began, `soon`
    in its unit after that at most, begins another; one that goes back elsewhere, or was there, is out of order.
    """

    def judge(procedure: Procedure, row: list[float]) -> Sequel:
        first, last = procedure.rows[0][position], procedure.rows[-1][position]
        if row[position] >= last:
            return Sequel.GOES_ON
        known = row in procedure.rows[-_REPEATED:]
        begins = row[position] <= first or (row[position] <= first + soon and not known)
        return Sequel.BEGINS if begins else Sequel.OUT_OF_ORDER

    return judge


Parse = Callable[[int, list[bytes]], list[float] | None]
"""Line and fields to the numbers of a record, the channel first: none of a line that is skipped, None for no record."""


def read_procedures(
    head: Head, parse: Parse, judge: Judge, findings: FindingCollector, zero_is_none: bool = False
) -> tuple[list[Procedure], int]:
    """Return the procedures of all outputs in the order in which they began, and how many lines were left out.

    `zero_is_none` takes a checksum of 0 as none.
    """
    procedures: list[Procedure] = []
    going_on: dict[int, Procedure] = {}
    rejected = 0
    for line, fields in _read_records(head, findings, zero_is_none):
        row = None if fields is None else parse(line, fields)
        if row is None:
            rejected += 1
            if fields is not None:
                reject_record(line, b"$" + b";".join(fields), findings)
        if not row:
            continue
        channel = int(row[0])
        procedure = going_on.get(channel)
        sequel = Sequel.BEGINS
        if procedure is not None and len(row) == len(procedure.rows[0]):
            sequel = judge(procedure, row)
        if sequel is Sequel.OUT_OF_ORDER:
            message = "The record lies before the one above it: a line repeated or out of order; it is left out."
            findings.add(ROW, "time_backwards", message, column="time", lines=[line])
            rejected += 1
            continue
        if procedure is None or sequel is Sequel.BEGINS:
            if procedure is not None:
                message = "The charger started again: what follows is kept as a procedure of its own."
                findings.add(NOTE, "time_restarted", message, column="time", lines=[line])
            procedure = going_on[channel] = Procedure(channel=channel)
            procedures.append(procedure)
        procedure.add(row, line, rejected)
    return procedures, rejected


CELL_SUM_AGREES = 0.02
CELLS_APART = 0.01
"""Of the records, in which the cells may differ from the pack without a note."""


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a record: its position, from the end where negative, its channel and the unit it is written in."""

    position: int
    name: str
    unit: str


@dataclass(frozen=True, slots=True)
class Work:
    """What a procedure did: its direction, in which records, shape (n,), and whether that decides the signs.

    `signed`: the file writes current and counter negative while discharging.
    """

    mode: ChargeMode
    active: BoolArray
    signed: bool


@dataclass(frozen=True, slots=True)
class LogLayout:
    """Where a maker's records hold what: `fields` include the clock, named time, where there is one; cells follow each
    other from `first_cell` on, as many as `cells` has for the number of fields, checksum included. `work` returns
    None, noted, for a procedure that is no recharge. A record `fits` for what is `seen` in it, in words; `measured` are
    the ones that are looked at. `parse` takes the usual number of fields before what a `Parse` takes.
    """

    fields: tuple[Field, ...]
    first_cell: int
    cells: Mapping[int, int]
    work: Callable[[Procedure, FindingCollector], Work | None]
    fits: Callable[[list[str]], bool]
    seen: str
    parse: Callable[[int, int, list[bytes], FindingCollector], list[float] | None]
    judge: Judge
    measured: Callable[[list[str]], bool] = lambda _record: True

    def width(self, head: Head) -> int:
        """Return the usual number of fields of a file's records; 0 where it is none, or half of these do not fit."""
        records = [record for record in head_records(head) if self.measured(record)]
        width = usual_fields(records)
        fitting = sum(len(record) == width and self.fits(record) for record in records)
        return width if width in self.cells and 2 * fitting > len(records) else 0

    def field(self, name: str) -> Field | None:
        """Return the field of a channel."""
        return next((each for each in self.fields if each.name == name), None)


def charger_format(name: str, version: int, what: str, layout: LogLayout) -> Format:
    """Return the format of a maker's records."""

    def recognise(head: Head) -> str | None:
        width = layout.width(head)
        return f"records of {width} fields with {layout.seen}" if width else None

    def read(head: Head, findings: FindingCollector) -> Reading:
        return _read(head, layout, findings)

    recognise.__doc__ = f"Records of {', '.join(map(str, layout.cells))} fields with {layout.seen}."
    return Format(name, version, recognise, read, what, clues=(rb"\$",), score=LAYOUT)


def _read(head: Head, layout: LogLayout, findings: FindingCollector) -> Reading:
    """Return one signal and at most one recharge of each procedure in a log."""
    width = layout.width(head)
    procedures, rows_rejected = read_procedures(
        head, lambda line, fields: layout.parse(width, line, fields, findings), layout.judge, findings
    )
    parts: list[SignalPart] = []
    charges: list[ChargeRow] = []
    rows_read = rows_rejected
    for procedure in procedures:
        work = layout.work(procedure, findings)
        reading = _signals(procedure, layout, work, head.declared, findings)
        rows_read += reading.rows_read
        rows_rejected += reading.rows_rejected
        parts.extend(reading.parts)
        seconds = _seconds(procedure, layout, reading, findings)
        if work is not None and seconds is not None:
            current, counter, voltage = (
                _stored(procedure, layout.field(name), unit, findings)
                for name, unit in (("current", "A"), ("charge", "mAh"), ("battery_voltage", "V"))
            )
            counted = CountedCharge(procedure.lines, seconds, current, counter, voltage, work)
            charges.append(charge_row(len(charges) + 1, counted, findings))
    return Reading(_numbered(parts), tuple(charges), rows_read, rows_rejected, FileRole.CHARGE)


def _signals(
    procedure: Procedure, layout: LogLayout, work: Work | None, declared: Declarations, findings: FindingCollector
) -> Reading:
    fields = [*layout.fields, *_connected_cells(procedure, layout, findings)]
    downwards = work is not None and not work.signed and work.mode is ChargeMode.DISCHARGE
    columns = []
    for each in fields:
        values = procedure.column(each.position)
        # Current and charge are stored negative while discharging, also of chargers that write no sign.
        columns.append(-np.abs(values) if downwards and each.name in ("current", "charge") else values)
    names, units = [each.name for each in fields], [each.unit for each in fields]
    table = array_table(names, units, columns, lines=procedure.lines, ordinals=procedure.ordinals)
    return read_signals(table, declared, findings, Instrument(f"channel_{procedure.channel}", steady=True))


def _connected_cells(procedure: Procedure, layout: LogLayout, findings: FindingCollector) -> list[Field]:
    """Return the cells that ever show a voltage; notes loose leads, and cells that do not add up to the pack."""
    connected: list[Field] = []
    total = np.zeros(len(procedure.rows))
    for cell in range(layout.cells[len(procedure.rows[0]) + 1]):
        position, name = layout.first_cell + cell, f"cell_{cell + 1}_voltage"
        millivolts = procedure.column(position)
        if not millivolts.any():
            continue
        connected.append(Field(position, name, "mV"))
        total += millivolts
        if not millivolts.all():
            findings.add(NOTE, "cell_zero", f"Cell {cell + 1} reads 0 V at times: a loose balance lead?", column=name)
    pack = 1000.0 * _stored(procedure, layout.field("battery_voltage"), "V", findings)
    apart = np.abs(total - pack) > CELL_SUM_AGREES * np.abs(pack)
    if connected and np.count_nonzero(apart) > CELLS_APART * len(apart):
        message = "The cells do not add up to the pack within 2 %: a cell is not connected, or the leads have losses."
        findings.add(NOTE, "cell_sum", message, count=int(np.count_nonzero(apart)))
    return connected


def _stored(procedure: Procedure, field: Field | None, unit: str, findings: FindingCollector) -> FloatArray:
    """Return a field that the layout has in another unit, shape (n,)."""
    if field is None:
        raise LookupError(unit)
    scale, _ = factor(field.name, field.unit, unit, findings)
    return procedure.column(field.position) * scale


def _seconds(
    procedure: Procedure, layout: LogLayout, reading: Reading, findings: FindingCollector
) -> FloatArray | None:
    """Return elapsed seconds of all records, shape (n,): by the clock, else counted at the rate that was declared."""
    clock = layout.field("time")
    if clock is not None:
        return _stored(procedure, clock, "s", findings)
    rate_hz = reading.parts[0].rate_hz if reading.parts else None
    return None if rate_hz is None else np.array(procedure.ordinals) / rate_hz


def part_charges(parts: Sequence[SignalPart], findings: FindingCollector) -> tuple[ChargeRow, ...]:
    """Return the charges of signals that have current, charge and battery_voltage under these names, and no states."""
    charges: list[ChargeRow] = []
    for part in parts:
        values = {channel.name: channel.values for channel in part.channels}
        if not {"current", "charge", "battery_voltage"} <= values.keys():
            continue
        counter, active = values["charge"], np.abs(values["current"]) > 0
        mode = direction_by_voltage(values["battery_voltage"], active, part.part, findings)
        if mode is not None:
            work = Work(mode, active, signed=mode is ChargeMode.DISCHARGE and bool(counter[-1] < 0))
            counted = CountedCharge((), part.time_s, values["current"], counter, values["battery_voltage"], work)
            charges.append(charge_row(len(charges) + 1, counted, findings))
    return tuple(charges)


def _numbered(parts: Sequence[SignalPart]) -> tuple[SignalPart, ...]:
    """Return the parts named by channel, further ones of a channel numbered through."""
    seen: Counter[str] = Counter()
    named = []
    for part in parts:
        base = part.part.partition("_segment_")[0]
        seen[base] += 1
        name = base if seen[base] == 1 else f"{base}_segment_{seen[base]}"
        named.append(dataclasses.replace(part, part=name))
    return tuple(named)


COUNTER_AGREES = 0.01
"""Of the charge counter, between it and the integral of the current."""

MOST_ROUNDING_MAH = 2.0
"""A difference that the counter's steps of 1 mAh explain."""

RESOLUTION_MAH = 1.0
COUNTER_ANEW = 0.1
"""Of what a counter showed: a counter that falls to less has begun anew."""

LEAST_RISE = 0.003
"""Of the pack's voltage, from which on it shows the direction of the current."""

LONGEST_INTERVAL = 3.0
"""Times the usual one; the current is not integrated over longer ones."""


@dataclass(frozen=True, slots=True, eq=False)
class CountedCharge:
    """One value a record, shape (n,), of a procedure of one direction: elapsed seconds, current and counter as written
    (A, mAh), voltage of the pack; `lines` may be empty.
    """

    lines: Sequence[int]
    seconds: FloatArray
    current_a: FloatArray
    counter_mah: FloatArray
    voltage_v: FloatArray
    work: Work


def charge_row(row_number: int, counted: CountedCharge, findings: FindingCollector) -> ChargeRow:
    """Return the charge of one procedure; a counter that contradicts mode or current refuses the file."""
    mode = counted.work.mode
    sign = -1 if counted.work.signed and mode is ChargeMode.DISCHARGE else 1
    counter = float(counted.counter_mah[-1])
    if counter * sign < 0:
        message = f"The counter ends at {counter:g} mAh in mode {mode}: the sign contradicts the mode."
        findings.add(FILE, "charge_sign", message, lines=counted.lines[-1:], value=f"{counter:g}")
    _check_counter(counted, sign, findings)
    active = np.flatnonzero(counted.work.active)
    return ChargeRow(
        row_number,
        None,
        None,
        abs(counter),
        RESOLUTION_MAH,
        float(counted.seconds[active[-1]] - counted.seconds[active[0]]),
        float(counted.voltage_v[active[-1]]),
        mode,
        None,
        None,
        counted.lines[0] if counted.lines else None,
    )


def _check_counter(counted: CountedCharge, sign: int, findings: FindingCollector) -> None:
    """Compare the counter with the current integrated over the intervals without a hole in the log."""
    rises = np.diff(counted.counter_mah)
    back = np.flatnonzero(rises * sign < 0)
    if back.size:
        lines = [counted.lines[row + 1] for row in back[:21].tolist()] if counted.lines else []
        findings.add(NOTE, "counter_backwards", "The charge counter runs backwards.", lines=lines)
    seconds = np.diff(counted.seconds)
    current = counted.current_a
    if not counted.work.signed and counted.work.mode is ChargeMode.DISCHARGE and float(current.sum()) < 0:
        current = -current  # such chargers count both directions upwards, and some give the current its sign
    integral = (current[1:] + current[:-1]) / 2 * 1000.0 * seconds / 3600.0
    forward = seconds > 0
    usual = float(np.median(seconds[forward])) if forward.any() else 0.0
    whole = forward & (seconds <= LONGEST_INTERVAL * usual)
    by_counter, by_current = float(rises[whole].sum()), float(integral[whole].sum())
    if abs(by_counter - by_current) > max(COUNTER_AGREES * abs(by_counter), MOST_ROUNDING_MAH):
        message = (
            f"The counter rises by {by_counter:.6g} mAh and the current integrates to {by_current:.6g} mAh, more than "
            "1 % apart: the scale of one of them is not what it should be, or, where `--rate` was declared, the rate."
        )
        findings.add(FILE, "charge_contradicts_current", message, lines=counted.lines[:1])


def direction_by_voltage(
    voltage_v: FloatArray, active: BoolArray, where: str, findings: FindingCollector
) -> ChargeMode | None:
    """Return what a procedure did by the pack's voltage, shape (n,), while current flowed, where the file has neither
    direction nor sign: a charge raises it, a discharge lowers it. None, noted, where it does not show.
    """
    working = voltage_v[active]
    tenth = max(1, len(working) // 10)
    first, last = (float(np.median(part)) if part.size else 0.0 for part in (working[:tenth], working[-tenth:]))
    if len(working) < 2 or abs(last - first) < LEAST_RISE * abs(first):
        message = (
            f"{where} has no direction, and its voltage under current does not show one ({first:.4g} to {last:.4g} V): "
            "kept as a signal, no recharge is counted."
        )
        findings.add(NOTE, "no_recharge", message)
        return None
    mode = ChargeMode.CHARGE if last > first else ChargeMode.DISCHARGE
    message = f"The file says no direction; the voltage goes from {first:.4g} to {last:.4g} V: read as a {mode}."
    findings.add(NOTE, "direction_by_voltage", message)
    return mode
