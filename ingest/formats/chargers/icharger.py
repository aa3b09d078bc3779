"""Junsi iCharger DUO and X logs from the memory card: one line a second, `$ch;mode;ms;...;checksum`.

Scales proved on public logs by comparing the integral of the current with the charge counter: current 10 mA (positive
while charging), voltages mV, charge mAh with sign, temperatures 0.1 degC, cells mV, 0 for none. Lines of type 128 hold
internal resistances.
"""

from __future__ import annotations

import dataclasses
import re

import numpy as np

from ingest.findings import FILE, NOTE, FindingCollector
from ingest.formats.chargers.charger_log import Field, LogLayout, Modes, Work, direction_by_modes, read_procedures
from ingest.formats.chargers.records import (
    Procedure,
    Procedures,
    Record,
    by_clock,
    head_records,
    read_records,
    reject_record,
    usual_fields,
)
from ingest.formats.format import LAYOUT, Clue, Format, Head, Recognition
from ingest.model import Reading

_FIELDS = (22, 20)  # DUO with 10 cells, X8 with 8
RESISTANCES = "128"
_INTEGER = re.compile(rb"-?\d{1,12}")
MODE = 1
_TIME = 2
_FIRST_CELL = 11
_SOON_MS = 10_000.0

MODES = Modes(frozenset({1, 8, 9}), frozenset({2, 12}), frozenset({7}))
"""1 charge, 2 discharge, 7 error, 8 and 9 trickle, 12 external discharge; others only watch or wait."""


def _work(procedure: Procedure, findings: FindingCollector) -> Work | None:
    modes = procedure.column(MODE)
    mode = direction_by_modes(modes, MODES, procedure.lines, procedure.channel, findings)
    active = np.isin(modes, list(MODES.charging | MODES.discharging))
    return None if mode is None else Work(mode, active, signed=True)


_LAYOUT = LogLayout(
    (
        Field(_TIME, "time", "ms"),
        Field(5, "current", "10 mA"),
        Field(6, "input_voltage", "mV"),
        Field(7, "battery_voltage", "mV"),
        Field(8, "charge", "mAh"),
        Field(9, "temperature_internal", "0.1 degC"),
        Field(10, "temperature_external", "0.1 degC"),
    ),
    _FIRST_CELL,
    10,
    _work,
)


def _recognise(head: Head) -> Recognition | None:
    """Records `$channel;mode;milliseconds;...` of 22 or 20 fields."""
    records = [record for record in head_records(head) if record[MODE] != RESISTANCES]
    width = usual_fields(records)
    timed = sum(record[_TIME].isdigit() for record in records)
    if width not in _FIELDS or 2 * timed <= len(records):
        return None
    return Recognition(LAYOUT, f"records of {width} fields with milliseconds in the third")


def _read(head: Head, findings: FindingCollector) -> Reading:
    procedures = Procedures(by_clock(_TIME, _SOON_MS))
    for line, record in read_records(head, findings):
        row = None if record is None else _row(record, findings)
        if row is None:
            procedures.rows_rejected += 1
        elif row[MODE] == int(RESISTANCES):
            message = "Lines of type 128 hold internal resistances: they stay in the raw copy only."
            findings.add(NOTE, "resistance_line", message, lines=[line])
        else:
            procedures.add(line, row, findings)
    found = [
        (procedure, dataclasses.replace(_LAYOUT, n_cells=len(procedure.rows[0]) - _FIRST_CELL))
        for procedure in procedures.found
    ]
    return read_procedures(found, procedures.rows_rejected, head.declared, findings)


def _row(record: Record, findings: FindingCollector) -> list[float] | None:
    """Return the numbers of a record, None, reported, where a field is no integer; other widths refuse the file."""
    if not all(map(_INTEGER.fullmatch, record.fields)):
        reject_record(record.line, b"$" + b";".join(record.fields), findings)
        return None
    row = [float(cell) for cell in record.fields]
    if len(row) + 1 not in _FIELDS and row[MODE] != int(RESISTANCES):
        message = (
            f"The line has {len(row) + 1} fields where iCharger DUO and X logs have 22 or 20: "
            "take the other model's lines out, or export from the charger's program as CSV with units."
        )
        findings.add(FILE, "icharger_layout_unknown", message, lines=[record.line])
        return None
    return row


FORMAT = Format("icharger_log", 4, _recognise, _read, clue=Clue(says=(b"$",)))
