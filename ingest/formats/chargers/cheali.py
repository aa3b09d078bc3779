"""Logs of chargers with the cheali-charger firmware: `$1;state;s.t;Vout;I;mAh;...;checksum`.

Integers in mV, mA, mAh and 0.01 degC, all without sign, and a state that shows whether the program runs, not what it
does: the direction follows from the pack's voltage. Lines of channels 2 and 3 are the firmware's debug output.
"""

from __future__ import annotations

import dataclasses
import re

from ingest.findings import NOTE, FindingCollector
from ingest.formats.chargers.charger_log import (
    COUNTER_ANEW,
    Field,
    LogLayout,
    Work,
    direction_by_voltage,
    read_procedures,
)
from ingest.formats.chargers.records import (
    Procedure,
    Procedures,
    Sequel,
    by_clock,
    head_records,
    read_records,
    reject_record,
    usual_fields,
)
from ingest.formats.format import LAYOUT, Clue, Format, Head, Recognition
from ingest.model import Reading

# Clock, measurements, resistances of cells, pack and leads, checksum; newer firmware adds percent and remaining time.
_CELLS_OF_WIDTH = {26: 6, 28: 6, 30: 8, 32: 8}
_STATE, _TIME, _VOLTAGE, _CURRENT, _CHARGE, _FIRST_CELL = 1, 2, 3, 4, 5, 11
_RUNNING, _FAILED = 1, 2
_CLOCKED = by_clock(_TIME, 10.0)
_CLOCK = re.compile(rb"\d{1,9}\.\d")
_INTEGER = re.compile(rb"\d{1,9}")
_MEASURED = b"1"


def _work(procedure: Procedure, findings: FindingCollector) -> Work | None:
    states = procedure.column(_STATE)
    if (states == _FAILED).any():
        message = f"The charger stopped channel {procedure.channel} with an error: the charge may not be complete."
        findings.add(NOTE, "charger_error", message)
    active = (states == _RUNNING) & (procedure.column(_CURRENT) > 0)
    mode = direction_by_voltage(procedure.column(_VOLTAGE) / 1000.0, active, f"channel_{procedure.channel}", findings)
    return None if mode is None else Work(mode, active, signed=False)


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
    6,
    _work,
)


def _width(head: Head) -> int:
    """Return the number of fields of a measurement, checksum included; 0 where the records are not of this format."""
    measured = [record for record in head_records(head) if record[0] == _MEASURED.decode()]
    width = usual_fields(measured)
    timed = sum(len(record) == width and _CLOCK.fullmatch(record[_TIME].encode()) is not None for record in measured)
    return width if width in _CELLS_OF_WIDTH and 2 * timed > len(measured) else 0


def _recognise(head: Head) -> Recognition | None:
    """Records of integers with tenths of seconds in the third field."""
    width = _width(head)
    return Recognition(LAYOUT, f"records of {width} fields with tenths of seconds in the third") if width else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    width = _width(head)
    procedures = Procedures(_sequel)
    for line, record in read_records(head, findings):
        if record is None:
            procedures.rows_rejected += 1
        elif record.fields[0] in (b"2", b"3"):
            message = "Lines of channels 2 and 3 are debug output of the firmware: they stay in the raw copy only."
            findings.add(NOTE, "debug_line", message, lines=[line])
        elif len(record.fields) + 1 == width and _is_measurement(record.fields):
            procedures.add(line, [float(cell) for cell in record.fields], findings)
        else:
            reject_record(line, b"$" + b";".join(record.fields), findings)
            procedures.rows_rejected += 1
    message = "Power, energy and resistances, of which the unit is not known, stay in the raw copy only."
    findings.add(NOTE, "field_ignored", message)
    layout = dataclasses.replace(_LAYOUT, n_cells=_CELLS_OF_WIDTH.get(width, 0))
    found = [(procedure, layout) for procedure in procedures.found]
    return read_procedures(found, procedures.rows_rejected, head.declared, findings)


def _sequel(procedure: Procedure, row: list[float]) -> Sequel:
    """Judge by the clock, and by the counter, which begins anew between the stages of a cycle."""
    before = procedure.rows[-1][_CHARGE]
    anew = row[_CHARGE] < before - 1 and row[_CHARGE] <= COUNTER_ANEW * before
    clocked = _CLOCKED(procedure, row)
    return Sequel.BEGINS if clocked is Sequel.GOES_ON and anew else clocked


def _is_measurement(fields: list[bytes]) -> bool:
    clock = _CLOCK.fullmatch(fields[_TIME]) is not None
    return clock and all(map(_INTEGER.fullmatch, fields[:_TIME] + fields[_TIME + 1 :]))


FORMAT = Format("cheali_log", 3, _recognise, _read, clue=Clue(says=(b"$",)))
