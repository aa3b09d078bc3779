"""Vicon Nexus CSV exports: sections (Devices, Joints, Trajectories, ...) one below the other, each a part.

A section has its title, its rate, the names of devices above their first column, the names of columns, units, then
rows numbered by camera frame and sub frame. Forces are reactions with z up; units stand in the file. Programs that
saved the file again may have padded every line with commas, or put tabs or semicolons for them.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ingest.channels.names import clean_name
from ingest.formats.fixed_table import FixedHeader, fixed_table, number_among, plate_channel, positive, refuse_layout
from ingest.formats.format import Format, Head
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, FindingCollector, Reading
from ingest.signals import combine, read_signals
from ingest.tables.table import Block, CellKind, Preamble, Table, Wanted
from ingest.text import Line, TextSource, split_cells, texts_of
from ingest.timebase.axis import RATE_NOTED

_TITLE = re.compile(r"(Devices|Joints|Trajectories|Model Outputs|Segments|Events)[,;\s]*")
_RATE = re.compile(r"\d+(?:\.\d+)?[,;\s]*")
_BLANK_LINES = re.compile(rb"(?<=\n)[,; \t]*\r?\n")
_COMPONENT = re.compile(r"([FMC])([xyz])")
_QUANTITIES = {"F": "force", "M": "moment", "C": "cop"}
_FILLING = ",; \t"
_HEADER_LINES = 5
_BETWEEN = (b",", b"\t", b";")
_COUNTERS = [b"Frame", b"Sub Frame"]


@dataclass(frozen=True, slots=True)
class _Span:
    """The camera frames of a section, and the rate of the camera by the section's own rate."""

    title: str
    first_frame: float
    last_frame: float
    camera_hz: float


def _recognise(head: Head) -> str | None:
    """The name of a section, and a rate below it."""
    filled = [line for line in head.lines[:10] if line.strip(_FILLING)]
    titled = len(filled) > 1 and _TITLE.fullmatch(filled[0]) and _RATE.fullmatch(filled[1])
    return f"section {filled[0].strip(_FILLING)!r} and its rate" if titled else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    readings = []
    titles: list[str] = []
    spans: list[_Span] = []
    for lines, stop in _sections(head.text):
        title = head.text.decode(lines[0].content).strip(_FILLING)
        if title == "Events":
            findings.add(NOTE, "section_skipped", "The events stay in the raw copy only.", value=title)
            continue
        table = _table(head, lines, stop, title, spans, findings)
        if table is None:
            return Reading()
        titles.append(clean_name(title))
        part = titles[-1] if titles.count(titles[-1]) == 1 else f"{titles[-1]}_{titles.count(titles[-1])}"
        readings.append(read_signals(table, head.declared, findings, Instrument(part, "Vicon Nexus", evidence="Nexus")))
    _compare(spans, findings)
    return combine(readings)


def _sections(source: TextSource) -> Iterator[tuple[list[Line], int]]:
    """Yield the sections, which blank lines part: header lines and first line of data, and where each ends."""
    starts = [source.start, *(match.end() for match in _BLANK_LINES.finditer(source.data, source.start))]
    stops = [*(match.start() for match in _BLANK_LINES.finditer(source.data, source.start)), len(source.data)]
    line = 1
    for start, stop, following in zip(starts, stops, [*starts[1:], len(source.data)], strict=True):
        if stop > start:
            yield source.section(stop).lines_at(start, line, _HEADER_LINES + 1), stop
        line += source.data.count(b"\n", start, following)


def _table(
    head: Head, lines: list[Line], stop: int, title: str, spans: list[_Span], findings: FindingCollector
) -> Table | None:
    """Return the table of a section, its rows numbered by sample; None where it is not laid out as they are."""
    source = head.text
    if len(lines) <= _HEADER_LINES:
        refuse_layout("Vicon Nexus", f"five header lines and rows in section {title!r}", findings)
        return None
    named = lines[3]
    sign = next((each for each in _BETWEEN if (split_cells(named.content, each) or [])[:2] == _COUNTERS), None)
    if sign is None:
        refuse_layout("Vicon Nexus", f"columns Frame and Sub Frame in line {named.number}", findings)
        return None
    cells = [texts_of(source, line, sign) for line in lines[:_HEADER_LINES]]
    names = _without_blank_end(cells[3])
    rate = positive(next(iter(cells[1]), None))
    if not rate:
        refuse_layout("Vicon Nexus", f"a rate in line {lines[1].number}", findings)
        return None
    groups, units = (row + [""] * len(names) for row in (cells[2], cells[4]))
    devices = _filled(groups[: len(names)])
    header = FixedHeader(
        [f"{device} {name}".strip() for device, name in zip(devices, names, strict=True)],
        sign,
        lines[_HEADER_LINES],
        units=tuple(unit or None for unit in units[: len(names)]),
        channels=_channels(devices, names),
        preamble=Preamble(rate),
    )
    table = fixed_table(source.section(stop), header, head.declared, findings)
    return None if table is None else _numbered(table, title, rate, spans, findings)


def _without_blank_end(cells: Sequence[str]) -> list[str]:
    last = max((position for position, cell in enumerate(cells) if cell), default=-1)
    return list(cells[: last + 1])


def _filled(groups: Sequence[str]) -> list[str]:
    """Return the device of every column: the name stands above its first one only."""
    filled: list[str] = []
    for position, name in enumerate(groups):
        filled.append(name if name or position <= 2 else filled[-1])
    return filled


def _channels(devices: Sequence[str], names: Sequence[str]) -> tuple[str | None, ...]:
    """Return the channel of each column; `PLATE - Force`, `PLATE - Moment` and `PLATE - CoP` are one plate."""
    plates: list[str] = []
    channels: list[str | None] = ["sequence", "sub_frame"]
    for device, name in zip(devices[2:], names[2:], strict=True):
        component = _COMPONENT.fullmatch(name)
        if component is None:
            channels.append(None)
            continue
        plate = number_among(plates, device.rpartition(" - ")[0] or device)
        channels.append(plate_channel(_QUANTITIES[component[1]], component[2], plate))
    return tuple(channels)


def _numbered(table: Table, title: str, rate_hz: float, spans: list[_Span], findings: FindingCollector) -> Table:
    """Return the table with frames and sub frames counted as samples; its span is added to `spans` when it is read."""

    def read_rows(wanted: Sequence[Wanted]) -> Block:
        others = [column for column in wanted if column.position > 1]
        counters = [Wanted(position, table.names[position], CellKind.NUMBER) for position in (0, 1)]
        block = table.read_rows([*counters, *others])
        frames, sub_frames = (np.asarray(block.numbers[position], dtype=np.float64) for position in (0, 1))
        if not block.n_rows:
            return block
        per_frame = float(np.fmax.reduce(sub_frames)) + 1  # NaN, and disordered, where none is a number
        samples = (frames - frames[0]) * per_frame + sub_frames
        if not (np.diff(samples) >= 1).all():
            message = f"Frames and sub frames of {title} do not count up: export the trial again."
            findings.add(FILE, "frames_disordered", message, column=title)
        if sub_frames[-1] + 1 != per_frame:
            message = f"The last frame of {title} has {sub_frames[-1] + 1:g} of {per_frame:g} samples: "
            findings.add(FILE, "frame_incomplete", message + "the file was cut short; copy it again.", column=title)
        spans.append(_Span(title, float(frames[0]), float(frames[-1]), rate_hz / per_frame))
        return dataclasses.replace(block, numbers={**block.numbers, 0: samples})

    return dataclasses.replace(table, read_rows=read_rows)


def _compare(spans: Sequence[_Span], findings: FindingCollector) -> None:
    """Refuse sections of one trial that end in different frames or have different rates of the camera."""
    for span in spans[1:]:
        first = spans[0]
        if (span.first_frame, span.last_frame) != (first.first_frame, first.last_frame):
            message = (
                f"{first.title} has frames {first.first_frame:g} to {first.last_frame:g} and {span.title} "
                f"{span.first_frame:g} to {span.last_frame:g}: the file was cut short or edited; export it again."
            )
            findings.add(FILE, "frames_contradict", message)
        if abs(span.camera_hz / first.camera_hz - 1) > RATE_NOTED:
            message = (
                f"{first.title} gives {first.camera_hz:.6g} camera frames a second and {span.title} "
                f"{span.camera_hz:.6g}: the file was edited; export it again."
            )
            findings.add(FILE, "rate_contradicts", message)


_SECTIONS = (b"devices", b"joints", b"trajectories", b"model outputs", b"segments", b"events")
FORMAT = Format("vicon_csv", 5, _recognise, _read, clues=_SECTIONS)
