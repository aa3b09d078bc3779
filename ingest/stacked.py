"""Tables one below the other in one text: each has a header of its own and becomes a part of its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from ingest.findings import FILE, NOTE, FindingCollector
from ingest.instruments import Instrument
from ingest.model import Declarations, Reading
from ingest.signals import read_signals
from ingest.tables.header_cells import parse_header
from ingest.tables.second_header import SecondHeader
from ingest.tables.text_table import text_table
from ingest.text.source import TextSource

MOST_TABLES = 20


@dataclass(frozen=True, slots=True)
class _Section:
    """One table's text, the names in its header, and the line of that header, None of the first."""

    source: TextSource
    names: frozenset[str]
    header_line: int | None


def read_stacked(
    source: TextSource, declared: Declarations, findings: FindingCollector, instrument: Instrument
) -> Reading:
    """Read the table in a text, or each of several under its own header."""
    sections: list[_Section] = []
    header_line: int | None = None
    while len(sections) < MOST_TABLES:
        found = FindingCollector()
        try:
            reading, names = _read(source, declared, found, instrument)
        except SecondHeader as next_header:
            whole = dataclasses.replace(source, data=source.data[: next_header.offset])
            sections.append(_Section(whole, _header_names(whole, declared), header_line))
            source = dataclasses.replace(source, start=next_header.offset, first_line=next_header.line)
            header_line = next_header.header_line
            continue
        if not sections:
            findings.take_over(found)
            return reading
        return _read_sections([*sections, _Section(source, names, header_line)], declared, findings, instrument)
    message = f"More than {MOST_TABLES} headers stand inside the data: export one table a file."
    findings.add(FILE, "too_many_tables", message)
    return Reading()


def _read(
    source: TextSource, declared: Declarations, findings: FindingCollector, instrument: Instrument
) -> tuple[Reading, frozenset[str]]:
    table = text_table(source, declared, findings)
    if table is None:
        return Reading(), frozenset()
    return read_signals(table, declared, findings, instrument), _names(table.names)


def _header_names(source: TextSource, declared: Declarations) -> frozenset[str]:
    table = text_table(source, declared, FindingCollector())
    return frozenset() if table is None else _names(table.names)


def _names(names: Sequence[str]) -> frozenset[str]:
    return frozenset(names) | {parse_header(name).base for name in names}


def _read_sections(
    sections: Sequence[_Section], declared: Declarations, findings: FindingCollector, instrument: Instrument
) -> Reading:
    """Read every section under its own header; what is declared of a column concerns the tables that have it."""
    readings = []
    lines = [section.header_line for section in sections if section.header_line is not None]
    message = "Another header stands inside the data: what follows is read under it, as a part of its own."
    findings.add(NOTE, "second_header", message, lines=lines)
    anywhere = frozenset[str]().union(*(section.names for section in sections))
    for number, section in enumerate(sections, start=1):
        elsewhere = anywhere - section.names
        columns = {name: said for name, said in declared.columns.items() if name not in elsewhere}
        own = dataclasses.replace(declared, columns=columns)
        part = instrument.part if number == 1 else f"{instrument.part}_table_{number}"
        readings.append(_read(section.source, own, findings, dataclasses.replace(instrument, part=part))[0])
    return Reading(
        tuple(part for reading in readings for part in reading.parts),
        (),
        sum(reading.rows_read for reading in readings),
        sum(reading.rows_rejected for reading in readings),
        next((reading.role for reading in readings if reading.role is not None), None),
    )
