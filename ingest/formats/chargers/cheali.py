"""Logs of chargers with the cheali-charger firmware: `$1;state;s.t;Vout;I;mAh;...;checksum`.

Integers in mV, mA, mAh and 0.01 degC, all without sign, and a state that shows whether the program runs, not what it
does: the direction follows from the pack's voltage. Lines of channels 2 and 3 are the firmware's debug output.
"""

from __future__ import annotations

import re

from ingest.formats.chargers.charger_log import (
    COUNTER_ANEW,
    Field,
    LogLayout,
    Procedure,
    Sequel,
    Work,
    by_clock,
    charger_format,
    direction_by_voltage,
)
from ingest.model import NOTE, FindingCollector

_STATE, _TIME, _VOLTAGE, _CURRENT, _CHARGE, _FIRST_CELL = 1, 2, 3, 4, 5, 11
_RUNNING, _FAILED = 1, 2
_CLOCKED = by_clock(_TIME, 10.0)
_CLOCK = re.compile(rb"\d{1,9}\.\d")
_INTEGER = re.compile(rb"\d{1,9}")
_MEASURED = "1"


def _work(procedure: Procedure, findings: FindingCollector) -> Work | None:
    if "field_ignored" not in findings:
        message = "Power, energy and resistances, of which the unit is not known, stay in the raw copy only."
        findings.add(NOTE, "field_ignored", message)
    states = procedure.column(_STATE)
    if (states == _FAILED).any():
        message = f"The charger stopped channel {procedure.channel} with an error: the charge may not be complete."
        findings.add(NOTE, "charger_error", message)
    active = (states == _RUNNING) & (procedure.column(_CURRENT) > 0)
    mode = direction_by_voltage(procedure.column(_VOLTAGE) / 1000.0, active, f"channel_{procedure.channel}", findings)
    return None if mode is None else Work(mode, active, signed=False)


def _parse(width: int, line: int, fields: list[bytes], findings: FindingCollector) -> list[float] | None:
    if fields[0] in (b"2", b"3"):
        message = "Lines of channels 2 and 3 are debug output of the firmware: they stay in the raw copy only."
        findings.add(NOTE, "debug_line", message, lines=[line])
        return []
    integers = [*fields[:_TIME], *fields[_TIME + 1 :]]
    whole = _CLOCK.fullmatch(fields[_TIME]) and all(map(_INTEGER.fullmatch, integers))
    return [float(cell) for cell in fields] if len(fields) + 1 == width and whole else None


def _sequel(procedure: Procedure, row: list[float]) -> Sequel:
    """Judge by the clock, and by the counter, which begins anew between the stages of a cycle."""
    before = procedure.rows[-1][_CHARGE]
    anew = row[_CHARGE] < before - 1 and row[_CHARGE] <= COUNTER_ANEW * before
    clocked = _CLOCKED(procedure, row)
    return Sequel.BEGINS if clocked is Sequel.GOES_ON and anew else clocked


_LAYOUT = LogLayout(
    (
        Field(_TIME, "time", "s"),
        Field(_CURRENT, "current", "mA"),
        Field(10, "input_voltage", "mV"),
        Field(_VOLTAGE, "battery_voltage", "mV"),
        Field(_CHARGE, "charge", "mAh"),
        Field(9, "temperature_internal", "0.01 degC"),
        Field(8, "temperature_external", "0.01 degC"),
    ),
    _FIRST_CELL,
    # Clock, measurements, resistances of cells, pack and leads, checksum; newer firmware adds percent and time left.
    {26: 6, 28: 6, 30: 8, 32: 8},
    _work,
    fits=lambda record: _CLOCK.fullmatch(record[_TIME].encode()) is not None,
    seen="tenths of seconds in the third",
    parse=_parse,
    judge=_sequel,
    measured=lambda record: record[0] == _MEASURED,
)
FORMAT = charger_format(
    "cheali_log",
    4,
    "Logs of chargers with the cheali-charger firmware: `$1;state;s.t;Vout;I;mAh;...;checksum`.",
    _LAYOUT,
)
