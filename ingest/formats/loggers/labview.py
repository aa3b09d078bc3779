"""LabVIEW measurement files (.lvm): a header of the file, one of its segment, names, and rows of values.

Each header ends in `***End_of_Header***`. Units, start and what stands in the first column are those of the segment.
Files of several segments, and those with a column of stamps for each channel or with none, are refused.
Source: NI, "Specification for the LabVIEW Measurement File (.lvm)".
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from ingest.formats.fixed_table import FixedHeader, check_count, next_filled, positive, read_fixed, refuse_layout
from ingest.formats.format import Head, signed
from ingest.instruments import Instrument
from ingest.model import Declarations, FindingCollector, Reading
from ingest.tables.table import read_preamble
from ingest.text import Line, TextSource, split_cells, texts_of

_END = b"***End_of_Header***"
_PROGRAM = "LabVIEW"


def _read(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    lines = source.head_lines()
    ends = [number for number, line in enumerate(lines) if line.content.startswith(_END)]
    if len(ends) < 2:
        return refuse_layout(_PROGRAM, "two lines `***End_of_Header***`", findings)
    delimiter = _delimiter(lines)
    facts = _facts(source, lines[: ends[1]], delimiter)
    if facts.get("X_Columns", ["One"])[0] != "One":
        return refuse_layout(_PROGRAM, "one column of X values (X_Columns One)", findings)
    if bytes(source.data[lines[ends[1]].start :]).count(_END) > 1:
        return refuse_layout(_PROGRAM, "one segment under one header", findings)
    names_line = next_filled(source, lines[ends[1]])
    first = None if names_line is None else next_filled(source, names_line)
    if names_line is None or first is None:
        return refuse_layout(_PROGRAM, "a line of names and rows below its header", findings)
    cells = split_cells(first.content, delimiter) or []
    names = texts_of(source, names_line, delimiter)
    while names[len(cells) :] or names[-1:] == [""]:
        names.pop()  # `Comment` is named also where rows have no cell for it
    if len(names) < 2:
        return refuse_layout(_PROGRAM, "a name for each column", findings)
    timed = facts.get("X_Dimension", [""])[0] == "Time"
    units = [*(["s"] if timed else [None]), *facts.get("Y_Unit_Label", [])]
    units += [None] * len(names)
    started = " ".join(facts.get(key, [""])[0] for key in ("Date", "Time"))
    header = FixedHeader(
        names,
        delimiter,
        first,
        [unit or None for unit in units[: len(names)]],
        ["time" if timed else None, *[None] * (len(names) - 1)],
        read_preamble([f"Start {started}"]),
    )
    head = dataclasses.replace(head, declared=_declared(head.declared, facts))
    reading = read_fixed(head, header, findings, Instrument())
    samples = positive(facts.get("Samples", [""])[0])  # of the first of several blocks where more rows follow
    check_count(reading, None if samples is None or reading.rows_read > samples else samples, findings)
    return reading


def _delimiter(lines: Sequence[Line]) -> bytes:
    """Return what stands between cells, as it stands between the key `Separator` and its value."""
    key = b"Separator"
    found = next((line.content[len(key) :][:1] for line in lines if line.content.startswith(key)), b"")
    return found or b"\t"


def _facts(source: TextSource, lines: Sequence[Line], delimiter: bytes) -> Mapping[str, list[str]]:
    """Return the values of the header by key; what the segment says counts before what the file says."""
    found = {}
    for line in lines:
        key, *values = texts_of(source, line, delimiter) or [""]
        if values:
            found[key] = values
    return found


def _declared(declared: Declarations, facts: Mapping[str, list[str]]) -> Declarations:
    sign = facts.get("Decimal_Separator", [""])[0]
    if declared.decimal_sign is not None or sign not in (".", ","):
        return declared
    return dataclasses.replace(declared, decimal_sign=sign)


FORMAT = signed("labview", 2, "LabVIEW Measurement", _read)
