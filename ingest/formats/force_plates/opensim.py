"""OpenSim storage files (.mot, .sto) with ground reactions: `endheader`, then tab-separated columns.

Seconds, newtons, metres and newton metres, y up, forces on the body: OpenSim's conventions, which the file does not
repeat. Plates are distinguished by what stands around `ground_force` in the names; `v` is the force, `p` the point of
application, `torque` (or `moment`) the free moment there.
"""

from __future__ import annotations

import re

from ingest.formats.fixed_table import (
    FixedHeader,
    next_filled,
    number,
    number_among,
    plate_channel,
    read_fixed,
    refuse_layout,
)
from ingest.formats.format import Format, Head
from ingest.instruments import PLATE_UNITS, Instrument
from ingest.model import FindingCollector, Reading

_GROUND_FORCES = Instrument("force", "OpenSim", PLATE_UNITS, "s", "y up", evidence="OpenSim")
_MOTION = Instrument("log", "OpenSim", time_unit="s")
_ROWS = re.compile(r"\s*(?:nRows|datarows)\s*[= \t]\s*(\d+)\s*")
_VERSION = re.compile(r"\s*version\s*=\s*(\S+)\s*")
_VERSIONS = ("1", "2", "3")
_COLUMN = re.compile(r"(.*?)(?:ground|grf)_?(force|torque|moment)(_?\d*)_?([vpm]?)([xyz])", re.IGNORECASE)


def _recognise(head: Head) -> str | None:
    """`nRows` and `endheader`."""
    ends = any(line.strip() == "endheader" for line in head.lines)
    counts = any(_ROWS.fullmatch(line) for line in head.lines)
    return "nRows and endheader, as OpenSim writes" if ends and counts else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    lines = source.head_lines()
    texts = [source.decode(line.content) for line in lines]
    end = next((index for index, text in enumerate(texts) if text.strip() == "endheader"), None)
    names_line = None if end is None else next_filled(source, lines[end])
    first = None if names_line is None else next_filled(source, names_line)
    version = next((match[1] for match in map(_VERSION.fullmatch, texts[:end]) if match), _VERSIONS[0])
    if names_line is None or first is None or version not in _VERSIONS:
        return refuse_layout("OpenSim", f"a version of {', '.join(_VERSIONS)} and rows below `endheader`", findings)
    samples = next((number(match[1]) for match in map(_ROWS.fullmatch, texts[:end]) if match), None)
    names = [name.strip() for name in source.decode(names_line.content).rstrip().split("\t")]
    channels = _channels(names)
    instrument = _GROUND_FORCES if any(channels) else _MOTION
    header = FixedHeader(names, b"\t", first, channels=channels)
    return read_fixed(head, header, findings, instrument, samples)


def _channels(names: list[str]) -> list[str | None]:
    plates: list[str] = []
    channels: list[str | None] = []
    for name in names:
        column = _COLUMN.fullmatch(name)
        if column is None:
            channels.append(None)
            continue
        plate = number_among(plates, (column[1] + column[3]).strip("_").lower())
        force = column[2].lower() == "force"
        quantity = "free_moment" if not force else "cop" if column[4].lower() == "p" else "force"
        channels.append(plate_channel(quantity, column[5].lower(), plate))
    return channels


FORMAT = Format("opensim", 5, _recognise, _read, clues=(b"endheader",))
