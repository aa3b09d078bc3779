"""Robot and string-potentiometer logs: any delimited text with a header, or with columns named by a declaration.

Units and time come from the header, a profile or the command line (formats: known channels by name, others under their
own). Tables one below the other, each under a header of its own, become parts of their own.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from ingest.formats.chargers.sheet import advice_on_sheet
from ingest.formats.format import ANY_TEXT, Format, Head, any_text
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, Declarations, FindingCollector, Reading
from ingest.signals import read_several, read_signals
from ingest.tables.layout import SecondHeader
from ingest.tables.rows import text_table
from ingest.text import TextSource, best_split

MOST_TABLES = 20
_LOG = Instrument()


def _read(head: Head, findings: FindingCollector) -> Reading:
    own = FindingCollector()
    reading = _read_tables(head.text, head.declared, own, _LOG)
    unread = own.count("no_data_rows") or own.count("rate_missing")
    advice = advice_on_sheet(head.text, head.declared) if unread else None
    if advice is None:
        findings.take_over(own)
        return reading
    findings.add(
        FILE, "charge_column_missing", f"The file looks like a sheet of recharges, or a log without time: {advice}"
    )
    return Reading()


def _read_tables(
    source: TextSource, declared: Declarations, findings: FindingCollector, instrument: Instrument
) -> Reading:
    """Read the table in a text, or each of several under its own header."""
    sections: list[TextSource] = []
    header_lines: list[int] = []
    while len(sections) < MOST_TABLES:
        found = FindingCollector()
        try:
            table = text_table(source, declared, found)
            reading = Reading() if table is None else read_signals(table, declared, found, instrument)
        except SecondHeader as another:
            section = dataclasses.replace(source, data=source.data[: another.offset])
            source = dataclasses.replace(source, start=another.offset, first_line=another.line)
            if best_split(section.head_lines(), section.sample_lines(0.5)) is not None:  # else it is a title
                sections.append(section)
                header_lines.append(another.header_line)
            continue
        if not sections:
            findings.take_over(found)
            return reading
        message = "Another header stands inside the data: what follows is read under it, as a part of its own."
        findings.add(NOTE, "second_header", message, lines=header_lines)
        return _read_sections([*sections, source], declared, findings, instrument)
    message = f"More than {MOST_TABLES} headers stand inside the data: export one table a file."
    findings.add(FILE, "too_many_tables", message)
    return Reading()


def _read_sections(
    sections: Sequence[TextSource], declared: Declarations, findings: FindingCollector, instrument: Instrument
) -> Reading:
    named = []
    for number, section in enumerate(sections, start=1):
        table = text_table(section, declared, findings)
        part = instrument.part if number == 1 else f"{instrument.part}_table_{number}"
        if table is not None:
            named.append((table, dataclasses.replace(instrument, part=part)))
    return read_several(named, declared, findings)


FORMAT = Format("delimited_log", 11, any_text, _read, score=ANY_TEXT)
