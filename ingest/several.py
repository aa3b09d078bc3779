"""Several tables in one file: each becomes a part of its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.vocabulary import FileRole
from ingest.channels.declared import without
from ingest.findings import FindingCollector
from ingest.instruments import Instrument, instrument_named
from ingest.model import Declarations, Reading
from ingest.signals import read_signals
from ingest.tables.header_cells import parse_header
from ingest.tables.table import Table


@dataclass(frozen=True, slots=True, eq=False)
class NamedTable:
    """A table and how it is read; the instrument's `part` is the name of what comes of it, unique in the file."""

    table: Table
    instrument: Instrument


def read_several(tables: Sequence[NamedTable], declared: Declarations, findings: FindingCollector) -> Reading:
    """Read each table into parts; what is declared of a column concerns the tables that have it."""
    present = [{*named.table.names, *(parse_header(name).base for name in named.table.names)} for named in tables]
    anywhere = set().union(*present)
    readings = []
    for named, names in zip(tables, present, strict=True):
        instrument = named.instrument
        if declared.instrument is not None:
            instrument = dataclasses.replace(instrument_named(declared.instrument), part=instrument.part)
        own = dataclasses.replace(without(declared, anywhere - names), instrument=None)
        readings.append(read_signals(named.table, own, findings, instrument))
    return combine(readings)


def combine(readings: Sequence[Reading]) -> Reading:
    """Return the readings of a file's tables as one: their parts and charges in order, their rows added."""
    roles = {reading.role for reading in readings}
    charges = [charge for reading in readings for charge in reading.charges]
    return Reading(
        tuple(part for reading in readings for part in reading.parts),
        tuple(dataclasses.replace(charge, row_number=number) for number, charge in enumerate(charges, start=1)),
        sum(reading.rows_read for reading in readings),
        sum(reading.rows_rejected for reading in readings),
        next((role for role in (FileRole.FORCE, FileRole.CHARGE, FileRole.LOG) if role in roles), None),
    )
