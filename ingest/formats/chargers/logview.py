"""Recordings of LogView in OpenFormat: records `$channel;phase;time;value;...;checksum` that name nothing.

What the values are stands in LogView's own file about the device, so that units and names are declared; the time may be
left out. Numbers have either decimal sign and never a thousands separator.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from data_schema.vocabulary import FileRole
from ingest.declared import declared_columns, with_profile_for_names
from ingest.findings import FILE, FindingCollector
from ingest.formats.chargers.charger_log import (
    Procedure,
    Sequel,
    head_records,
    part_charges,
    read_procedures,
    usual_fields,
)
from ingest.formats.format import NAMES, Format, Head
from ingest.instruments import Instrument
from ingest.model import Declarations, Reading, SignalPart
from ingest.signals import read_signals
from ingest.tables.table import array_table
from ingest.text.cells import COMMA_NUMBER, NUMBER, value_of

_BATTERY = {"battery_voltage", "current", "charge"}
"""A recording with one of these is a charger's or of a pack in use, not of a jump."""


def _recognise(head: Head) -> str | None:
    """Records `$channel;phase;time;...`."""
    records = head_records(head)
    return "records `$channel;phase;time;...`" if records else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    seen = head_records(head)
    widths = {channel.encode(): usual_fields([one for one in seen if one[0] == channel]) for channel, *_ in seen}

    def parse(_line: int, fields: list[bytes]) -> list[float] | None:
        row = [number for number in map(parse_number, fields) if number is not None]
        fits = len(row) == len(fields) and len(fields) + 1 == widths.get(fields[0], len(fields) + 1)
        return row if fits else None

    unchecked = all(record[-1] == "0" for record in seen)
    procedures, rejected = read_procedures(head, parse, lambda *_: Sequel.GOES_ON, findings, zero_is_none=unchecked)
    return joined([_signals(procedure, head.declared, findings) for procedure in procedures], rejected, findings)


def parse_number(cell: bytes) -> float | None:
    """Return the number in a cell with either decimal sign, NaN for an empty one, None for anything else."""
    if not cell:
        return float("nan")
    if NUMBER.fullmatch(cell):
        return value_of(cell)
    return value_of(cell.replace(b",", b".")) if COMMA_NUMBER.fullmatch(cell) else None


def _signals(procedure: Procedure, declared: Declarations, findings: FindingCollector) -> Reading:
    width = len(procedure.rows[0])
    names = ["channel", "phase", "time", *(f"value_{number}" for number in range(1, width - 2))]
    used = [position for position in range(1, width) if not np.isnan(procedure.column(position)).all()]
    declarations = declared_columns(with_profile_for_names(declared, names, FindingCollector()), names)
    if not any(position >= 3 for position in declarations):
        message = (
            "The records name neither quantities nor units, which stand in LogView's file about the device: say what "
            'each value is, as `--column "value_1=CHANNEL:UNIT"`, or in a [profiles.NAME] table of labbook.toml.'
        )
        findings.add(FILE, "columns_unnamed", message)
    table = array_table(
        [names[position] for position in used],
        [None] * len(used),
        [procedure.column(position) for position in used],
        lines=procedure.lines,
        ordinals=procedure.ordinals,
    )
    return read_signals(table, declared, findings, Instrument(f"channel_{procedure.channel}", steady=True))


def joined(readings: Sequence[Reading], rejected: int, findings: FindingCollector) -> Reading:
    """Return the readings of all recordings of a file as one, with their charges; `rejected` rows belong to none."""
    parts: list[SignalPart] = [part for reading in readings for part in reading.parts]
    names = {channel.name for part in parts for channel in part.channels}
    return Reading(
        tuple(parts),
        part_charges(parts, findings),
        sum(reading.rows_read for reading in readings) + rejected,
        sum(reading.rows_rejected for reading in readings) + rejected,
        FileRole.CHARGE if _BATTERY & names else FileRole.LOG,
    )


FORMAT = Format("logview_openformat", 4, _recognise, _read, clues=(b"$",), score=NAMES)
