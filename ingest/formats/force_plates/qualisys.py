"""Qualisys QTM force exports (`*_f_N.tsv`), one plate a file: `KEY<TAB>value` lines, then 9 or 11 columns.

Columns are sample and time (in the longer form), then force in newtons, moment in newton metres and centre of pressure
in millimetres. The corners of the plate show whether its own frame points up or down.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping

import numpy as np

from ingest.formats.fixed_table import FixedHeader, number, positive, read_fixed, refuse_layout
from ingest.formats.format import Format, Head
from ingest.instruments import PLATE_UNITS, Instrument
from ingest.model import FILE, NOTE, FindingCollector, Reading
from ingest.tables.table import Preamble

_UNITS = {kind: "mm" if unit == "m" else unit for kind, unit in PLATE_UNITS.items()}
_QUALISYS = Instrument("force", "Qualisys QTM", _UNITS, "s", evidence="QTM")
_ENTRY = re.compile(r"([A-Z][A-Z_]+)\t(.*)")
_COMPONENTS = tuple(f"{quantity}_{axis}" for quantity in ("force", "moment", "cop") for axis in "xyz")
_COUNTERS = ("sequence", "time")
_DATE = re.compile(r"(\d{4}-\d\d-\d\d)[, T]+(\d\d:\d\d:\d\d(?:\.\d+)?)")
_CORNER = "FORCE_PLATE_CORNER_{}_{}"


def _recognise(head: Head) -> str | None:
    """`NO_OF_SAMPLES` and a force plate in the header."""
    force = any("FORCE_PLATE" in line or "Force data" in line for line in head.lines[:30])
    named = head.first_line().startswith("NO_OF_SAMPLES\t") and force
    return "NO_OF_SAMPLES and a force plate" if named else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    lines = [line for line in source.head_lines(80) if line.content.strip()]
    texts = [source.decode(line.content) for line in lines]
    # A row of names begins in capitals too, and has more cells than an entry.
    matched = [_ENTRY.fullmatch(text) if text.count("\t") < len(_COMPONENTS) - 1 else None for text in texts]
    start = next((index for index, match in enumerate(matched) if match is None), len(lines))
    entries = {match[1]: match[2].strip() for match in matched[:start] if match}
    names = [cell.strip() for cell in texts[start].split("\t")] if start < len(lines) else []
    if names and number(names[0]) is None:
        start += 1
    rate, samples = positive(entries.get("FREQUENCY")), number(entries.get("NO_OF_SAMPLES"))
    width = len(texts[start].rstrip("\t").split("\t")) if start < len(lines) else 0
    channels = _COMPONENTS if width == len(_COMPONENTS) else (*_COUNTERS, *_COMPONENTS)
    if not rate or samples is None or width != len(channels):
        return refuse_layout("Qualisys", "frequency, number of samples and rows of 9 or 11 columns", findings)
    if len(names) < width or number(names[0]) is not None:
        names = list(channels)
    if entries.get("FORCE_PLATE_NAME"):
        findings.add(NOTE, "instrument", f"Written of the plate {entries['FORCE_PLATE_NAME']}.")
    header = FixedHeader(
        names[:width],
        b"\t",
        lines[start],
        channels=channels,
        preamble=Preamble(rate, _start(entries.get("TIME_STAMP"))),
    )
    frame = head.declared.axes or _frame(entries, findings)
    instrument = dataclasses.replace(_QUALISYS, frame=frame, action=frame == "z down")
    return read_fixed(head, header, findings, instrument, samples)


def _start(stamp: str | None) -> str | None:
    date = _DATE.match(stamp or "")
    return f"{date[1]} {date[2]}" if date else None


def _frame(entries: Mapping[str, str], findings: FindingCollector) -> str:
    """Return the frame of the data: the laboratory's, or the plate's own, whose third axis follows from the corners."""
    corners = {
        corner: [number(entries.get(_CORNER.format(corner, axis))) for axis in "XYZ"]
        for corner in ("POSX_POSY", "NEGX_POSY", "POSX_NEGY")
    }
    if all(value is not None for corner in corners.values() for value in corner):
        place = {corner: np.array(values, dtype=np.float64) for corner, values in corners.items()}
        normal = np.cross(place["POSX_POSY"] - place["NEGX_POSY"], place["POSX_POSY"] - place["POSX_NEGY"])
        vertical = int(np.abs(normal).argmax())
        local = "local" in entries.get("DESCRIPTION", "local")
        if normal[vertical] and vertical:
            if local:
                return "z up" if normal[vertical] > 0 else "z down"
            return "z up" if vertical == 2 else "y up"
    message = (
        "The corners of the plate do not tell which axis is vertical: "
        'say it with `axes = "z up"` (or "z down", "y up") in a profile.'
    )
    findings.add(FILE, "axes_unclear", message)
    return "z up"


FORMAT = Format("qualisys_tsv", 5, _recognise, _read, clues=(b"no_of_samples",))
