"""Older Junsi iCharger models (106B+, 208B and their kin) on the serial port: `$ch;mode;;Vin;Vbat;I;cells;T;T;mAh;sum`.

Voltages in mV, current in 10 mA, temperatures in 0.1 degC, charge in mAh since the stage began. There is no clock: a
line about every two seconds is no rate, so the rate is declared. The number of cells follows from that of the fields.
"""

from __future__ import annotations

import re

import numpy as np

from data_schema.vocabulary import ChargeMode
from ingest.findings import FindingCollector
from ingest.formats.chargers.charger_log import (
    COUNTER_ANEW,
    Field,
    LogLayout,
    Work,
    direction_by_modes,
    read_procedures,
)
from ingest.formats.chargers.icharger import MODE, MODES
from ingest.formats.chargers.records import (
    Procedure,
    Procedures,
    Sequel,
    head_records,
    read_records,
    reject_record,
    usual_fields,
)
from ingest.formats.format import LAYOUT, Clue, Format, Head, Recognition
from ingest.model import Reading

_CELLS_OF_WIDTH = {16: 6, 18: 8, 20: 10}
_UNUSED = 2
_FIRST_CELL = 6
_INTEGER = re.compile(rb"-?\d{1,9}")


def _work(procedure: Procedure, findings: FindingCollector) -> Work | None:
    modes = procedure.column(MODE)
    mode = direction_by_modes(modes, MODES, procedure.lines, procedure.channel, findings)
    if mode is None:
        return None
    signed = mode is ChargeMode.DISCHARGE and procedure.rows[-1][-1] < 0
    return Work(mode, np.isin(modes, list(MODES.charging | MODES.discharging)), signed)


def _layout(n_cells: int) -> LogLayout:
    after = _FIRST_CELL + n_cells
    fields = (
        Field(5, "current", "10 mA"),
        Field(3, "input_voltage", "mV"),
        Field(4, "battery_voltage", "mV"),
        Field(after + 2, "charge", "mAh"),
        Field(after, "temperature_internal", "0.1 degC"),
        Field(after + 1, "temperature_external", "0.1 degC"),
    )
    return LogLayout(fields, _FIRST_CELL, n_cells, _work)


def _width(head: Head) -> int:
    """Return the number of fields of a record, checksum included; 0 where the records are not of this format."""
    records = head_records(head)
    width = usual_fields(records)
    untimed = sum(len(record) == width and not record[_UNUSED] for record in records)
    return width if width in _CELLS_OF_WIDTH and 2 * untimed > len(records) else 0


def _recognise(head: Head) -> Recognition | None:
    """Records of as many fields as older iChargers write, the third one empty."""
    width = _width(head)
    return Recognition(LAYOUT, f"records of {width} fields with an empty third") if width else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    width = _width(head)
    procedures = Procedures(_sequel)
    for line, record in read_records(head, findings):
        fields = [] if record is None else record.fields
        used = fields[:_UNUSED] + fields[_UNUSED + 1 :]
        if record is None:
            procedures.rows_rejected += 1
        elif len(fields) + 1 != width or not all(map(_INTEGER.fullmatch, used)):
            reject_record(line, b"$" + b";".join(fields), findings)
            procedures.rows_rejected += 1
        else:
            row = [float(cell) for cell in used]
            procedures.add(line, [*row[:_UNUSED], float("nan"), *row[_UNUSED:]], findings)
    layout = _layout(_CELLS_OF_WIDTH[width]) if width else _layout(0)
    found = [(procedure, layout) for procedure in procedures.found]
    return read_procedures(found, procedures.rows_rejected, head.declared, findings)


def _sequel(procedure: Procedure, row: list[float]) -> Sequel:
    """Judge by direction and counter, which begins anew with every stage; a counter that only falls is out of order."""
    before = procedure.rows[-1]
    stages = [MODES.charging, MODES.discharging]
    turned = any(before[MODE] in stage and row[MODE] in other for stage, other in (stages, stages[::-1]))
    if not turned and abs(row[-1]) >= abs(before[-1]):
        return Sequel.GOES_ON
    return Sequel.BEGINS if turned or abs(row[-1]) <= COUNTER_ANEW * abs(before[-1]) else Sequel.OUT_OF_ORDER


FORMAT = Format("icharger_serial", 2, _recognise, _read, clue=Clue(says=(b"$",)))
