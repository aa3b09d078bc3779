"""Kistler BioWare text exports: metadata by column, names that repeat for every plate, a row of units.

Plates are distinguished by the line `Device:`, positive vertical force is the foot pressing. `Normalized force (N)` and
`Normalized length (m)` are settings that stand in exports of newtons, too.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from ingest.channels.forces import find_load
from ingest.channels.names import channel_kind, parse_header, squash
from ingest.declared import declared_columns
from ingest.formats.fixed_table import (
    FixedHeader,
    number,
    number_among,
    plate_channel,
    positive,
    read_fixed,
    refuse_layout,
)
from ingest.formats.format import NAMES, Format, Head, signed, spelt
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, Declarations, FindingCollector, Reading, SignalPart
from ingest.signals import read_signals
from ingest.tables.rows import text_table
from ingest.tables.table import Preamble
from ingest.text import texts_of

_BIOWARE = Instrument("force", "Kistler BioWare", time_unit="s", evidence="BioWare")
_VERSION = re.compile(r"BioWare\b(?:.*?Version\s+(\d+)\.)?")
_VERSIONS = ("5",)
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_DATE = re.compile(r"([A-Z][a-z]{2})[a-z]* (\d{1,2}), (\d{4})\s+(\d\d:\d\d:\d\d)")
_FIRST_YEAR = 2000
_COMPONENT = re.compile(r"(?:fp(\d))?([fmat][xyz])")
_QUANTITIES = {"f": "force", "m": "moment", "a": "cop", "t": "free_moment"}
_LEAST_BODY_WEIGHTS, _MOST_BODY_WEIGHTS = 0.5, 10.0
_STANDING = 0.05
"""Body weights by which the force of who stands differs from 1: a plate's noise in newtons is more."""

_EIGHT_CHANNELS = {"time", *(f"channel{channel}" for channel in range(8))}


def _read(head: Head, findings: FindingCollector) -> Reading:
    lines = head.text.head_lines(60)
    cells = [texts_of(head.text, line, b"\t") or [""] for line in lines]
    named = next((index for index, row in enumerate(cells) if row[0].startswith("abs time")), None)
    version = _VERSION.match(head.first_line())
    if version is None or (version[1] or _VERSIONS[0]) not in _VERSIONS or named is None or named + 2 >= len(lines):
        return refuse_layout(
            "BioWare", f"version {', '.join(_VERSIONS)}, a row `abs time`, a row of units and data", findings
        )
    entries = {row[0].rstrip(":"): row for row in cells[:named]}
    names = cells[named] if cells[named][-1] else cells[named][:-1]
    rates = {positive(cell) for cell in entries.get("Rate (Hz)", [""])[1:] if cell}
    samples = {number(cell) for cell in entries.get("Samples (#)", [""])[1:] if cell}
    if len(rates) != 1 or None in rates or len(samples) != 1:
        return refuse_layout("BioWare", "one rate and one number of samples for all columns", findings)
    header = FixedHeader(
        names,
        b"\t",
        lines[named + 2],
        units=tuple(cell or None for cell in (cells[named + 1] + [""] * len(names))[: len(names)]),
        channels=_channels(names, entries.get("Device", [])),
        preamble=Preamble(rates.pop(), _start(entries, findings)),
    )
    reading = read_fixed(head, header, findings, _BIOWARE, samples.pop())
    _check_normalised(entries, reading, head.declared, findings)
    return reading


def _channels(names: Sequence[str], devices: Sequence[str]) -> tuple[str | None, ...]:
    """Return the channel of each column; its plate follows from its device, its prefix, or how often the name came."""
    aligned = len(devices) == len(names)
    plates: list[str] = []
    seen: Counter[str] = Counter()
    channels: list[str | None] = ["time"]
    for position, name in enumerate(names[1:], start=1):
        component = _COMPONENT.fullmatch(squash(parse_header(name).base)) if "|" not in name else None
        if component is None:
            channels.append(None)
            continue
        device = devices[position] if aligned else ""
        seen[component[2]] += 1
        plate = number_among(plates, device) if device else seen[component[2]]
        quantity, axis = _QUANTITIES[component[2][0]], component[2][1]
        channels.append(plate_channel(quantity, axis, int(component[1] or plate)))
    return tuple(channels)


def _check_normalised(
    entries: Mapping[str, Sequence[str]], reading: Reading, declared: Declarations, findings: FindingCollector
) -> None:
    """Refuse values that may be divided by the body's weight or size: a setting that stands in every export says so
    only where no unit stands above the values, or these cannot be newtons.
    """
    for key in ("Normalized force (N)", "Normalized length (m)"):
        divisor = next((cell for cell in entries.get(key, [""])[1:] if number(cell)), None)
        if divisor is None:
            continue
        if "unit_missing" in findings:
            why = "no unit stands above some columns: these may be divided by it: say their units"
        elif key.startswith("Normalized force") and any(_in_body_weights(part, declared) for part in reading.parts):
            why = 'the forces are multiples of a weight, no newtons (say `--column "Fz=force_z:N"` if they are)'
        else:
            continue
        message = f"`{key}` is {divisor}, and {why}, or export them without normalisation."
        findings.add(FILE, "values_normalised", message, value=divisor)


def _in_body_weights(part: SignalPart, declared: Declarations) -> bool:
    """Whether the forces of all plates together hop or stand as multiples of a body's weight do."""
    forces = [channel for channel in part.channels if channel_kind(channel.name) == "force_z"]
    columns = declared_columns(declared, [channel.source_name for channel in forces])
    if not forces or any(column.unit for column in columns.values()):
        return False
    total = np.sum([channel.values for channel in forces], axis=0)
    load = find_load(total)
    if load is not None and load.largest_n > _LEAST_BODY_WEIGHTS:
        return load.largest_n < _MOST_BODY_WEIGHTS
    low, middle, high = np.nanpercentile(total, (25, 50, 75))
    return bool(abs(middle - 1) < _STANDING and high - low < _STANDING)


def _start(entries: Mapping[str, Sequence[str]], findings: FindingCollector) -> str | None:
    """Return the date and time of the recording as ISO-8601; None where the computer's clock had been reset."""
    written = " ".join(entries.get("Date", [""])[1:]).strip()
    date = _DATE.fullmatch(written)
    if date is None or date[1].lower() not in _MONTHS:
        return None
    if int(date[3]) < _FIRST_YEAR:
        message = f"The clock was before the year {_FIRST_YEAR}: it had not been set."
        findings.add(NOTE, "clock_implausible", message, value=written)
        return None
    return f"{date[3]}-{_MONTHS.index(date[1].lower()) + 1:02}-{int(date[2]):02} {date[4]}"


def _recognise_channels(head: Head) -> str | None:
    """Eight columns `Channel 0` to `Channel 7`."""
    named = any(
        {squash(parse_header(cell).base) for cell in line.split("\t")} == _EIGHT_CHANNELS for line in head.lines[:40]
    )
    return "columns Channel 0 to Channel 7" if named else None


def _read_channels(head: Head, findings: FindingCollector) -> Reading:
    table = text_table(head.text, head.declared, findings)
    if table is None:
        return Reading()
    message = (
        "Eight raw channels, as the amplifier of a Kistler plate gives in volts: these are no forces, which need the "
        "plate's ranges and sensitivities; export forces from BioWare."
    )
    findings.add(NOTE, "raw_channels", message)
    return read_signals(table, head.declared, findings, Instrument())


FORMAT = signed("bioware", 6, "BioWare", _read)
_CLUES = (spelt("channel"), rb"c[chanel\W_]{0,200}[\[(]")
"""The name, also with a unit in brackets in the midst of it, which is none of it."""
CHANNELS_FORMAT = Format("kistler_channels", 5, _recognise_channels, _read_channels, clues=_CLUES, score=NAMES)
