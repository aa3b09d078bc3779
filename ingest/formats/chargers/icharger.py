"""Junsi iCharger DUO and X logs from the memory card: one line a second, `$ch;mode;ms;...;checksum`.

Scales proved on public logs by comparing the integral of the current with the charge counter: current 10 mA (positive
while charging), voltages mV, charge mAh with sign, temperatures 0.1 degC, cells mV, 0 for none. The checksum is the
exclusive or of all bytes from `$` to the last `;`, both included. Lines of type 128 hold internal resistances.
"""

from __future__ import annotations

import functools
import operator
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from data_schema.vocabulary import CHANNELS, ChargeMode, FileRole
from ingest.findings import FILE, NOTE, ROW, FindingCollector
from ingest.formats.format import LAYOUT, Format, Recognition
from ingest.formats.head import Head
from ingest.model import ChannelData, ChargeRow, FloatArray, Reading, SignalPart
from ingest.text.logical_lines import numbered_lines
from ingest.timebase.stamps import GAP_RULES, Timebase, from_stamps, rows_after_gaps

_FIELDS = (22, 20)  # DUO with 10 cells, X8 with 8
_RESISTANCES = 128
_RECORD = re.compile(rb"\$\d{1,2}(?:;-?\d{1,12})+")

# Position in the line, channel, unit in the file, factor to the stored unit.
_QUANTITIES = (
    (5, "current", "10 mA", 0.01),
    (6, "input_voltage", "mV", 0.001),
    (7, "battery_voltage", "mV", 0.001),
    (8, "charge", "mAh", 1.0),
    (9, "temperature_internal", "0.1 degC", 0.1),
    (10, "temperature_external", "0.1 degC", 0.1),
)
_FIRST_CELL = 11

_CHARGING = frozenset({1, 8, 9})
_DISCHARGING = frozenset({2, 12})
_ERROR = 7

COUNTER_AGREES = 0.01
"""Of the charge counter, between it and the integral of the current."""

RESOLUTION_MAH = 1.0
CELL_SUM_AGREES = 0.02


@dataclass(slots=True)
class _Procedure:
    """The lines of one channel from one start of the charger: integers as written, where they stand, and their numbers
    with the lines rejected before them counted.
    """

    channel: int
    rows: list[list[int]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    ordinals: list[int] = field(default_factory=list)


def _recognise(head: Head) -> Recognition | None:
    if head.source is None:
        return None
    lines = (line.replace("\0", "").strip() for line in head.lines)
    first = next((line for line in lines if line and not line.startswith("@Model")), "")
    return Recognition(LAYOUT, f"records as {first[:12]!r}") if re.match(r"\$\d{1,2};", first) else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    procedures, rows_read, rejected = _procedures(head, findings)
    parts: list[SignalPart] = []
    charges: list[ChargeRow] = []
    segments: dict[int, int] = {}
    for procedure in procedures:
        number = segments[procedure.channel] = segments.get(procedure.channel, 0) + 1
        name = f"channel_{procedure.channel}" + (f"_segment_{number}" if number > 1 else "")
        values = np.array(procedure.rows, dtype=np.float64)
        axis = from_stamps(values[:, 2] / 1000.0, np.array(procedure.ordinals, dtype=np.int64))
        for kind, rule, message in GAP_RULES:
            after = rows_after_gaps(axis, kind)
            if after.size:
                lines = [procedure.lines[row] for row in after.tolist()]
                findings.add(NOTE, rule, message, lines=lines)
        channels = _channels(values, findings)
        parts.append(
            SignalPart(name, axis.time_s, axis.rate_hz, None, f"{procedure.rows[0][2]} ms", channels, axis.gaps)
        )
        charge = _charge(len(charges) + 1, procedure, values, axis, findings)
        if charge is not None:
            charges.append(charge)
    return Reading(tuple(parts), tuple(charges), rows_read, rejected, FileRole.CHARGE)


def _procedures(head: Head, findings: FindingCollector) -> tuple[list[_Procedure], int, int]:
    """Return the good lines by channel and start of the charger, the number of data lines and of those rejected."""
    found: list[_Procedure] = []
    open_by_channel: dict[int, _Procedure] = {}
    rows_read = rejected = 0
    data, start = (head.data, 0) if head.source is None else (head.source.data, head.source.start)
    for number, content in numbered_lines(data, start):
        record = content.strip(b"\0\x1a \t")
        if not record:
            continue
        if record.startswith(b"@"):
            text = record.decode("latin-1")
            findings.add(NOTE, "instrument", f"Written by {text[1:]}.", lines=[number], value=text)
            continue
        values = _values(record, number, findings)
        if values is not None and values[1] == _RESISTANCES:
            message = "Lines of type 128 hold internal resistances: they stay in the raw copy only."
            findings.add(NOTE, "resistance_line", message, lines=[number])
            continue
        rows_read += 1
        if values is None:
            rejected += 1
            continue
        procedure = open_by_channel.get(values[0])
        if procedure is not None and values[2] == procedure.rows[-1][2]:
            message = "The time stamp repeats the one before it; the row is left out."
            findings.add(ROW, "time_duplicate", message, column="time", lines=[number])
            rejected += 1
            continue
        if procedure is None or values[2] < procedure.rows[-1][2] or len(values) != len(procedure.rows[0]):
            if procedure is not None:
                message = "The charger started again: what follows is kept as a procedure of its own."
                findings.add(NOTE, "time_restarted", message, column="time", lines=[number])
            procedure = open_by_channel[values[0]] = _Procedure(values[0])
            found.append(procedure)
        procedure.rows.append(values)
        procedure.lines.append(number)
        procedure.ordinals.append(len(procedure.rows) + rejected)
    return found, rows_read, rejected


def _values(record: bytes, number: int, findings: FindingCollector) -> list[int] | None:
    """Return the integers of a record, or None, reported, when its form or its checksum is wrong."""
    shown = record[:60].decode("latin-1")
    if not _RECORD.fullmatch(record):
        message = "The line is no record `$channel;mode;...` of integers; it is left out."
        findings.add(ROW, "record_malformed", message, lines=[number], value=shown)
        return None
    body, _, checksum = record.rpartition(b";")
    if functools.reduce(operator.xor, body, ord(";")) != int(checksum):
        message = "The checksum of the line is wrong: bytes were lost or changed; it is left out."
        findings.add(ROW, "checksum_wrong", message, lines=[number], value=shown)
        return None
    values = [int(field) for field in record[1:].split(b";")][:-1]
    if len(values) + 1 not in _FIELDS and values[1] != _RESISTANCES:
        message = (
            f"The line has {len(values) + 1} fields where iCharger DUO and X logs have 22 or 20: "
            "older models order them otherwise; export from the charger's program as CSV with units."
        )
        findings.add(FILE, "icharger_layout_unknown", message, lines=[number], value=shown)
        return None
    return values


def _channels(values: FloatArray, findings: FindingCollector) -> tuple[ChannelData, ...]:
    """Return the channels of a procedure; cells that are not connected throughout are no channels."""
    channels = [
        ChannelData(
            name, CHANNELS[name].unit, f"field {position}", unit, scale, 0.0, 1, (), values[:, position] * scale
        )
        for position, name, unit, scale in _QUANTITIES
    ]
    cells = values[:, _FIRST_CELL:]
    connected = np.flatnonzero((cells != 0).any(axis=0))
    for cell in connected.tolist():
        name = f"cell_{cell + 1}_voltage"
        position = _FIRST_CELL + cell
        channels.append(
            ChannelData(name, "V", f"field {position}", "mV", 0.001, 0.0, 1, (), values[:, position] * 0.001)
        )
        if (cells[:, cell] == 0).any():
            findings.add(NOTE, "cell_zero", f"Cell {cell + 1} reads 0 V at times: a loose balance lead?", column=name)
    packs = values[:, 7]
    apart = np.abs(cells.sum(axis=1) - packs) > CELL_SUM_AGREES * np.abs(packs)
    if connected.size and np.count_nonzero(apart) > 0.01 * len(apart):
        message = "The cells do not add up to the pack within 2 %: a cell is not connected, or the leads have losses."
        findings.add(NOTE, "cell_sum", message, count=int(np.count_nonzero(apart)))
    return tuple(channels)


def _charge(
    row_number: int, procedure: _Procedure, values: FloatArray, axis: Timebase, findings: FindingCollector
) -> ChargeRow | None:
    """Return what the procedure put into or took out of the pack; None when it only watched."""
    modes = {int(mode) for mode in values[:, 1]}
    if _ERROR in modes:
        message = f"The charger stopped channel {procedure.channel} with an error: the charge may not be complete."
        findings.add(NOTE, "charger_error", message, lines=_where(procedure, values[:, 1] == _ERROR))
    charging, discharging = bool(modes & _CHARGING), bool(modes & _DISCHARGING)
    counter = float(values[-1, 8])
    if charging == discharging:
        what = "both charges and discharges" if charging else "neither charges nor discharges"
        message = f"Channel {procedure.channel} {what}: kept as a signal, no recharge is counted."
        findings.add(NOTE, "no_recharge", message)
        return None
    sign = 1 if charging else -1
    if counter * sign < 0:
        mode = "charge" if charging else "discharge"
        message = f"The counter ends at {counter:g} mAh in mode {mode}: the sign contradicts the mode."
        findings.add(FILE, "charge_sign", message, lines=procedure.lines[-1:], value=f"{counter:g}")
    _check_counter(procedure, values, axis, sign, findings)
    active = np.flatnonzero(np.isin(values[:, 1], list(_CHARGING | _DISCHARGING)))
    return ChargeRow(
        row_number,
        None,
        None,
        abs(counter),
        RESOLUTION_MAH,
        float(axis.time_s[active[-1]] - axis.time_s[active[0]]),
        float(values[active[-1], 7]) * 0.001,
        ChargeMode.CHARGE if charging else ChargeMode.DISCHARGE,
        None,
        None,
    )


def _check_counter(
    procedure: _Procedure, values: FloatArray, axis: Timebase, sign: int, findings: FindingCollector
) -> None:
    """Compare the counter with the current integrated over the intervals without a hole in the log."""
    counted = np.diff(values[:, 8])
    if (counted * sign < 0).any():
        message = "The charge counter runs backwards."
        findings.add(NOTE, "counter_backwards", message, lines=_where(procedure, np.append(False, counted * sign < 0)))
    hours = np.diff(axis.time_s) / 3600.0
    current_ma = values[:, 5] * 10.0
    integral = (current_ma[1:] + current_ma[:-1]) / 2 * hours
    whole = np.diff(axis.time_s) <= 3 / (axis.rate_hz or 1.0)
    by_counter, by_current = float(counted[whole].sum()), float(integral[whole].sum())
    if abs(by_counter - by_current) > max(COUNTER_AGREES * abs(by_counter), 2 * RESOLUTION_MAH):
        message = (
            f"The counter rises by {by_counter:.6g} mAh and the current integrates to {by_current:.6g} mAh, "
            "more than 1 % apart: the scale of one of them is not what it should be."
        )
        findings.add(FILE, "charge_contradicts_current", message, lines=procedure.lines[:1])


def _where(procedure: _Procedure, rows: Sequence[bool] | np.ndarray) -> list[int]:
    return [procedure.lines[row] for row in np.flatnonzero(rows)[:21].tolist()]


FORMAT = Format("icharger_log", 2, _recognise, _read)
