"""Motion Analysis Cortex force files (.forces): four header lines, then seven columns for each plate, no time.

Each plate has its force in newtons, its point of application in millimetres and the free moment about the vertical in
newton millimetres. The frame is the laboratory's: the axis on which all points of application lie at zero is the
vertical one, and where the load lies must agree.
"""

from __future__ import annotations

import dataclasses
import re

import numpy as np

from ingest.channels.forces import LOADED_N
from ingest.formats.fixed_table import (
    MILLIMETRE_UNITS,
    FixedHeader,
    check_count,
    fixed_table,
    number,
    plate_channel,
    positive,
    refuse_layout,
)
from ingest.formats.format import Head, signed
from ingest.instruments import Instrument
from ingest.model import FILE, FindingCollector, Reading
from ingest.signals import read_signals
from ingest.tables.table import Block, CellKind, Preamble, Wanted

_CORTEX = Instrument("force", "Motion Analysis Cortex", MILLIMETRE_UNITS, evidence="Cortex")
_ENTRY = re.compile(r"\s*(\w+)\s*=\s*(\S.*?)\s*")
_COLUMN = re.compile(r"(F?[XYZ]|MZ)(\d+)")
_PER_PLATE = 7


def _read(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    lines = source.head_lines(20)
    texts = [source.decode(line.content) for line in lines]
    entries = {match[1]: match[2] for match in map(_ENTRY.fullmatch, texts) if match}
    plates, samples = number(entries.get("NumberOfForcePlates")), number(entries.get("NumberOfSamples"))
    rate = positive(entries.get("SampleRate"))
    named = next((index for index, text in enumerate(texts) if text.startswith("#Sample")), None)
    if plates is None or samples is None or not rate or named is None or named + 1 == len(lines):
        return refuse_layout("Cortex", "number of plates, rate, number of samples and a line `#Sample`", findings)
    names = texts[named].strip().split("\t")
    if len(names) != 1 + _PER_PLATE * plates or not all(map(_COLUMN.fullmatch, names[1:])):
        return refuse_layout("Cortex", f"seven columns for each of its {plates:g} plates", findings)
    header = FixedHeader(names, b"\t", lines[named + 1], preamble=Preamble(rate))
    table = fixed_table(source, header, head.declared, findings)
    if table is None:
        return Reading()
    block = table.read_rows([Wanted(position, name, CellKind.NUMBER) for position, name in enumerate(names)])
    frame = head.declared.axes or _frame(block, int(plates), findings)
    table = dataclasses.replace(table, channels=_channels(names, frame), read_rows=lambda _wanted: block)
    reading = read_signals(table, head.declared, findings, dataclasses.replace(_CORTEX, frame=frame))
    check_count(reading, samples, findings)
    return reading


def _channels(names: list[str], frame: str) -> tuple[str | None, ...]:
    # The free moment is about the vertical whatever the axes are called.
    vertical = "y" if frame == "y up" else "z"
    channels: list[str | None] = ["sequence"]
    for name in names[1:]:
        letters, plate = name.rstrip("0123456789"), int(name.lstrip("FMXYZ"))
        quantity = "free_moment" if letters == "MZ" else "force" if letters.startswith("F") else "cop"
        axis = vertical if letters == "MZ" else letters[-1].lower()
        channels.append(plate_channel(quantity, axis, plate))
    return tuple(channels)


def _frame(block: Block, plates: int, findings: FindingCollector) -> str:
    """Return which frame the file is in, by the points of application and by where the load lies."""
    if not block.n_rows:
        return "z up"
    columns = [block.numbers[position] for position in range(1, 1 + _PER_PLATE * plates)]
    values = np.stack(columns, axis=1).reshape(-1, plates, _PER_PLATE)
    load = np.ptp(values[:, :, :3], axis=0).max(axis=0)
    flat = [axis for axis in range(3) if not values[:, :, 3 + axis].any()]
    loaded = int(load.argmax())
    upright = [axis for axis in flat if axis != 0 and (axis == loaded or load[loaded] < LOADED_N)]
    if len(upright) == 1:
        return "y up" if upright == [1] else "z up"
    seen = "".join("xyz"[axis] for axis in flat) or "none"
    message = (
        f"Points of application are zero on axis {seen} and the largest force is on {'xyz'[loaded]}: "
        'which axis is vertical is not certain; say it with `axes = "y up"` (or "z up") in a profile.'
    )
    findings.add(FILE, "axes_unclear", message)
    return "z up"


FORMAT = signed("cortex_forces", 5, "[Force Data]", _read)
