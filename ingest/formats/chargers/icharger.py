"""Junsi iChargers: logs of DUO and X from the memory card, and what older models send on the serial port.

The log has a line a second, `$ch;mode;ms;...;checksum`. Scales proved on public logs by comparing the integral of the
current with the charge counter: current 10 mA (positive while charging), voltages mV, charge mAh with sign,
temperatures 0.1 degC, cells mV, 0 for none. Lines of type 128 hold internal resistances.

Older models send `$ch;mode;;Vin;Vbat;I;cells;T;T;mAh;sum` in the same scales, the charge since the stage began. There
is no clock: a line about every two seconds is no rate, so the rate is declared.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from data_schema.vocabulary import ChargeMode
from ingest.formats.chargers.charger_log import (
    COUNTER_ANEW,
    Field,
    LogLayout,
    Procedure,
    Sequel,
    Work,
    by_clock,
    charger_format,
)
from ingest.model import FILE, NOTE, FindingCollector

RESISTANCES = "128"
_INTEGER = re.compile(rb"-?\d{1,12}")
_MODE, _TIME = 1, 2
_SOON_MS = 10_000.0
_CHARGING, _DISCHARGING, _ERROR = (1, 8, 9), (2, 12), 7
"""1 charge, 8 and 9 trickle; 2 discharge, 12 external discharge; others only watch or wait."""


def _log_work(procedure: Procedure, findings: FindingCollector) -> Work | None:
    return _work(procedure, lambda _mode: True, findings)


def _serial_work(procedure: Procedure, findings: FindingCollector) -> Work | None:
    return _work(procedure, lambda mode: mode is ChargeMode.DISCHARGE and procedure.rows[-1][-1] < 0, findings)


def _work(procedure: Procedure, signed: Callable[[ChargeMode], bool], findings: FindingCollector) -> Work | None:
    """Return what a procedure did by its modes; None, noted, when it only watched or did both."""
    modes, channel = procedure.column(_MODE), procedure.channel
    failed = np.flatnonzero(modes == _ERROR)
    if failed.size:
        message = f"The charger stopped channel {channel} with an error: the charge may not be complete."
        lines = [procedure.lines[row] for row in failed[:21].tolist()]
        findings.add(NOTE, "charger_error", message, lines=lines)
    charging, discharging = (np.isin(modes, known) for known in (_CHARGING, _DISCHARGING))
    if charging.any() == discharging.any():
        what = "both charges and discharges" if charging.any() else "neither charges nor discharges"
        message = f"Channel {channel} {what}: kept as a signal, no recharge is counted."
        findings.add(NOTE, "no_recharge", message)
        return None
    mode = ChargeMode.CHARGE if charging.any() else ChargeMode.DISCHARGE
    return Work(mode, charging | discharging, signed(mode))


_DUO_CELLS = {22: 10, 20: 8}
"""Of the DUO and the X8."""


def _parse(_width: int, line: int, fields: list[bytes], findings: FindingCollector) -> list[float] | None:
    if not all(map(_INTEGER.fullmatch, fields)):
        return None
    row = [float(cell) for cell in fields]
    if row[_MODE] == int(RESISTANCES):
        message = "Lines of type 128 hold internal resistances: they stay in the raw copy only."
        findings.add(NOTE, "resistance_line", message, lines=[line])
        return []
    if len(row) + 1 not in _DUO_CELLS:
        message = (
            f"The line has {len(row) + 1} fields where iCharger DUO and X logs have 22 or 20: "
            "take the other model's lines out, or export from the charger's program as CSV with units."
        )
        findings.add(FILE, "icharger_layout_unknown", message, lines=[line])
        return []
    return row


def _parse_serial(width: int, _line: int, fields: list[bytes], _findings: FindingCollector) -> list[float] | None:
    used = [*fields[:_TIME], *fields[_TIME + 1 :]]
    if len(fields) + 1 != width or not all(map(_INTEGER.fullmatch, used)):
        return None
    row = [float(cell) for cell in used]
    return [*row[:_TIME], float("nan"), *row[_TIME:]]


def _sequel(procedure: Procedure, row: list[float]) -> Sequel:
    """Judge by direction and counter, which begins anew with every stage; a counter that only falls is out of order."""
    before = procedure.rows[-1]
    stages = [_CHARGING, _DISCHARGING]
    turned = any(before[_MODE] in stage and row[_MODE] in other for stage, other in (stages, stages[::-1]))
    if not turned and abs(row[-1]) >= abs(before[-1]):
        return Sequel.GOES_ON
    return Sequel.BEGINS if turned or abs(row[-1]) <= COUNTER_ANEW * abs(before[-1]) else Sequel.OUT_OF_ORDER


_DUO = LogLayout(
    (
        Field(_TIME, "time", "ms"),
        Field(5, "current", "10 mA"),
        Field(6, "input_voltage", "mV"),
        Field(7, "battery_voltage", "mV"),
        Field(8, "charge", "mAh"),
        Field(9, "temperature_internal", "0.1 degC"),
        Field(10, "temperature_external", "0.1 degC"),
    ),
    11,
    _DUO_CELLS,
    _log_work,
    fits=lambda record: record[_TIME].isdigit(),
    seen="milliseconds in the third",
    parse=_parse,
    judge=by_clock(_TIME, _SOON_MS),
    measured=lambda record: record[_MODE] != RESISTANCES,
)
_OLDER = LogLayout(
    (
        Field(5, "current", "10 mA"),
        Field(3, "input_voltage", "mV"),
        Field(4, "battery_voltage", "mV"),
        Field(-1, "charge", "mAh"),
        Field(-3, "temperature_internal", "0.1 degC"),
        Field(-2, "temperature_external", "0.1 degC"),
    ),
    6,
    {16: 6, 18: 8, 20: 10},
    _serial_work,
    fits=lambda record: not record[_TIME],
    seen="an empty third",
    parse=_parse_serial,
    judge=_sequel,
)
FORMAT = charger_format(
    "icharger_log",
    5,
    "Junsi iCharger DUO and X logs from the memory card: one line a second, `$ch;mode;ms;...;checksum`.",
    _DUO,
)
SERIAL = charger_format(
    "icharger_serial",
    3,
    "Older Junsi iCharger models (106B+, 208B and their kin) on the serial port: "
    "`$ch;mode;;Vin;Vbat;I;cells;T;T;mAh;sum`.",
    _OLDER,
)
