"""VALD ForceDecks raw exports: a block of metadata, then `Time,Left,Right` of two plates in seconds and newtons.

The tare that stands in the metadata is already taken off: left and right add up to the weight of who stands on them.
"""

from __future__ import annotations

import re

from ingest.channels.names import squash
from ingest.formats.fixed_table import FixedHeader, positive, read_fixed, refuse_layout
from ingest.formats.format import Head, signed
from ingest.instruments import Instrument
from ingest.model import NOTE, FindingCollector, Reading
from ingest.tables.table import Preamble
from ingest.text import texts_of

_FORCEDECKS = Instrument("force", "VALD ForceDecks", {"force_z": "N"}, "s", evidence="ForceDecks")
_TITLE = re.compile(r"ForceDecks Raw Data Export\s*,\s*(\d+)")
_VERSIONS = ("1", "2")
_CHANNELS = {"time": "time", "left": "force_z", "zleft": "force_z", "right": "force_z_2", "zright": "force_z_2"}


def _read(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    lines = source.head_lines(60)
    cells = [texts_of(source, line, b",") or [""] for line in lines]
    named = next((index for index, row in enumerate(cells) if row[0] == "Time"), None)
    version = _TITLE.match(head.first_line())
    if named is None or named + 1 == len(lines) or version is None or version[1] not in _VERSIONS:
        return refuse_layout(
            "ForceDecks", f"version {' or '.join(_VERSIONS)} and rows below `Time,Left,Right`", findings
        )
    names = [name for name in cells[named] if name]
    channels = tuple(_CHANNELS.get(squash(name)) for name in names)
    if "force_z" not in channels or "force_z_2" not in channels:
        return refuse_layout("ForceDecks", "columns Left and Right", findings)
    entries = {row[0]: row[1] for row in cells[:named] if len(row) > 1}
    if any("tare" in key.lower() for key in entries):
        message = "The tare of the header is already taken off the forces: it is not subtracted again."
        findings.add(NOTE, "tare_applied", message)
    preamble = Preamble(positive(entries.get("Frequency")), entries.get("Recording Date") or None)
    header = FixedHeader(names, b",", lines[named + 1], channels=channels, preamble=preamble)
    return read_fixed(head, header, findings, _FORCEDECKS)


FORMAT = signed("forcedecks", 5, "ForceDecks Raw Data Export", _read)
