"""AMTI NetForce text exports: rows of `Fx, Fy, Fz, Mx, My, Mz` for each plate, without names or time.

Above them stand four lines in the language of the program, with a decimal comma where that language has one, or nothing
at all: then `--instrument amti` declares what the file is, and `--rate` its sampling rate. The plate's z axis points
down.
"""

from __future__ import annotations

import re

from ingest.formats.fixed_table import FixedHeader, plate_channel, positive, read_fixed, refuse_layout
from ingest.formats.format import Format, Head
from ingest.instruments import INSTRUMENTS
from ingest.model import FindingCollector, Reading
from ingest.tables.table import Preamble
from ingest.text import is_number, split_cells

INSTRUMENT = "amti"
_COMPONENTS = tuple((quantity, axis) for quantity in ("force", "moment") for axis in "xyz")
_HEADER_LINES = 8
_OFFSET = re.compile(r"\s*Z ?offset\s*:", re.IGNORECASE)
# Acquisition or sampling rate in the languages of the program: the stem of one of the words is enough.
_RATE = re.compile(
    r"[^:]*(?:akwizycj|acqui|adqui|aquisi|sampl|abtast|erfass|campion|muestreo)[^:]*:(.*)", re.IGNORECASE
)


def _first_row(head: Head) -> int | None:
    """Return which line is the first of six numbers for each plate, None where a line of as many cells stands above."""
    for index, line in enumerate(head.lines[:_HEADER_LINES]):
        cells = split_cells(line.encode("latin-1", errors="replace"), b",") or []
        if len(cells) >= len(_COMPONENTS) and all(is_number(cell, comma=False) for cell in cells):
            named = any(above.count(",") >= len(_COMPONENTS) - 1 for above in head.lines[:index])
            return index if len(cells) % len(_COMPONENTS) == 0 and not named else None
    return None


def _recognise(head: Head) -> str | None:
    """NetForce's header above rows of six, twelve or more numbers."""
    first = _first_row(head)
    if first is None:
        return None
    if head.declared.instrument == INSTRUMENT:
        return "declared, six columns for each plate"
    offset = any(map(_OFFSET.match, head.lines[:first]))
    return "Zoffset above six unnamed columns for each plate" if offset else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    first = _first_row(head)
    if first is None:
        return refuse_layout("NetForce", "six numbers for each plate, with commas between them", findings)
    line = head.text.head_lines()[first]
    width = len(split_cells(line.content, b",") or [])
    channels = [
        plate_channel(*component, plate)
        for plate in range(1, width // len(_COMPONENTS) + 1)
        for component in _COMPONENTS
    ]
    rate = next((positive(match[1]) for match in map(_RATE.match, head.lines[:first]) if match), None)
    names = [str(position + 1) for position in range(width)]
    header = FixedHeader(names, b",", line, channels=channels, preamble=Preamble(rate))
    return read_fixed(head, header, findings, INSTRUMENTS[INSTRUMENT])


FORMAT = Format("amti_text", 5, _recognise, _read, clues=(rb"z ?off", INSTRUMENT.encode()))
