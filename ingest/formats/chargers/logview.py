"""Recordings of LogView in OpenFormat: records `$channel;phase;time;value;...;checksum` that name nothing.

What the values are stands in LogView's own file about the device, so that units and names are declared; the time may be
left out. Numbers have either decimal sign and never a thousands separator.

In LogView Studio's OpenFormat Zero `$N$;name` begins a recording, `$C$;Temp 1 [°C,T];Voltage[V]` names the columns
(unit and symbol in brackets), `$T$;position;ddHHmmss` says where among the data a time stands, `$I$;1000` how many
milliseconds lie between lines, `$F$;1;0.1` are factors, `$V$;HEX` says how numbers are written; data are `$5.1;2.3`.
Settings hold until changed.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from data_schema.vocabulary import FileRole
from ingest.declared import declared_columns, with_profile_for_names
from ingest.formats.chargers.charger_log import (
    Procedure,
    Sequel,
    head_records,
    part_charges,
    read_procedures,
    reject_record,
    usual_fields,
)
from ingest.formats.format import NAMES, Format, Head
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, ROW, Declarations, FindingCollector, Reading, SignalPart
from ingest.signals import read_signals
from ingest.tables.table import Column, LineRows, Preamble, array_table
from ingest.text import COMMA_NUMBER, NUMBER, numbered_lines, value_of

_BATTERY = {"battery_voltage", "current", "charge"}
"""A recording with one of these is a charger's or of a pack in use, not of a jump."""


def _recognise(head: Head) -> str | None:
    """Records `$channel;phase;time;...`."""
    records = head_records(head)
    return "records `$channel;phase;time;...`" if records else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    seen = head_records(head)
    widths = {channel.encode(): usual_fields([one for one in seen if one[0] == channel]) for channel, *_ in seen}

    def parse(_line: int, fields: list[bytes]) -> list[float] | None:
        row = [number for number in map(_parse_number, fields) if number is not None]
        fits = len(row) == len(fields) and len(fields) + 1 == widths.get(fields[0], len(fields) + 1)
        return row if fits else None

    unchecked = all(record[-1] == "0" for record in seen)
    procedures, rejected = read_procedures(head, parse, lambda *_: Sequel.GOES_ON, findings, zero_is_none=unchecked)
    return _joined([_signals(procedure, head.declared, findings) for procedure in procedures], rejected, findings)


def _parse_number(cell: bytes) -> float | None:
    """Return the number in a cell with either decimal sign, NaN for an empty one, None for anything else."""
    if not cell:
        return float("nan")
    if NUMBER.fullmatch(cell):
        return value_of(cell)
    return value_of(cell.replace(b",", b".")) if COMMA_NUMBER.fullmatch(cell) else None


def _signals(procedure: Procedure, declared: Declarations, findings: FindingCollector) -> Reading:
    width = len(procedure.rows[0])
    names = ["channel", "phase", "time", *(f"value_{number}" for number in range(1, width - 2))]
    used = [position for position in range(1, width) if not np.isnan(procedure.column(position)).all()]
    declarations = declared_columns(with_profile_for_names(declared, names, FindingCollector()), names)
    if not any(position >= 3 for position in declarations):
        message = (
            "The records name neither quantities nor units, which stand in LogView's file about the device: say what "
            'each value is, as `--column "value_1=CHANNEL:UNIT"`, or in a [profiles.NAME] table of labbook.toml.'
        )
        findings.add(FILE, "columns_unnamed", message)
    table = array_table(
        [names[position] for position in used],
        [None] * len(used),
        [procedure.column(position) for position in used],
        lines=procedure.lines,
        ordinals=procedure.ordinals,
    )
    return read_signals(table, declared, findings, Instrument(f"channel_{procedure.channel}", steady=True))


def _joined(readings: Sequence[Reading], rejected: int, findings: FindingCollector) -> Reading:
    """Return the readings of all recordings of a file as one, with their charges; `rejected` rows belong to none."""
    parts: list[SignalPart] = [part for reading in readings for part in reading.parts]
    names = {channel.name for part in parts for channel in part.channels}
    return Reading(
        tuple(parts),
        part_charges(parts, findings),
        sum(reading.rows_read for reading in readings) + rejected,
        sum(reading.rows_rejected for reading in readings) + rejected,
        FileRole.CHARGE if _BATTERY & names else FileRole.LOG,
    )


_HEADER = re.compile(r"\$([A-Z])(\d*)\$;?(.*)")
_NAMED = re.compile(r"(.*?)\s*\[([^\],]*)(?:,[^\]]*)?\]\s*")
_TIME_FORMAT = re.compile(r"(?:d{1,2}|H{1,2}|m{1,2}|s{1,2}|[fz]{1,3})+")
_SECONDS = {"d": 86_400.0, "H": 3600.0, "m": 60.0, "s": 1.0}
_NOT_READ = {"O": "offsets", "S": "sum offsets"}


def _recognise_zero(head: Head) -> str | None:
    """Header lines as `$N$;` and `$C$;`."""
    known = [line for line in head.lines[:20] if re.match(r"\$[NC]\d*\$;", line)]
    return f"a header {known[0][:12]!r}" if known else None


@dataclass(slots=True)
class _Recording(LineRows):
    """One recording: its columns and how its lines are written; and the rows, line by line."""

    columns: list[str] = field(default_factory=list)
    factors: list[float] = field(default_factory=list)
    time_position: int | None = None
    time_format: str = ""
    interval_ms: float | None = None
    hexadecimal: bool = False
    seconds: list[float] = field(default_factory=list)

    def next_recording(self) -> _Recording:
        """Return an empty recording; settings hold until they are changed."""
        return dataclasses.replace(self, rows=[], lines=[], ordinals=[], seconds=[])


def _read_zero(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    recordings: list[_Recording] = []
    rejected = 0
    lines = [line for line in numbered_lines(source.data, source.start) if line.content.strip()]
    for number, _, content, is_ended in lines:
        text = source.decode(content).strip("\0\x1a \t")
        header = _HEADER.fullmatch(text)
        if header is not None:
            if header[1] == "N" or not recordings:
                recordings.append(recordings[-1].next_recording() if recordings else _Recording())
            _take_header(recordings[-1], header, number, findings)
        elif text and recordings:
            if not is_ended:
                message = "The last line has no line end and may be cut: the row is left out."
                findings.add(ROW, "last_line_cut", message, lines=[number], value=text[:60])
                rejected += 1
            elif not _take_row(recordings[-1], text, number, rejected):
                reject_record(number, content, findings)
                rejected += 1
    readings = []
    for number, recording in enumerate((one for one in recordings if one.rows), start=1):
        instrument = Instrument("log" if number == 1 else f"log_{number}", steady=True)
        readings.append(_zero_signals(recording, head.declared, findings, instrument))
    return _joined(readings, rejected, findings)


def _take_header(recording: _Recording, header: re.Match[str], line: int, findings: FindingCollector) -> None:
    letter, channel, text = header[1], header[2], header[3]
    items = text.split(";")
    if channel not in ("", "1"):
        message = "The recording has several channels, which is not read: export each on its own."
        findings.add(FILE, "several_channels", message, lines=[line])
    elif letter in _NOT_READ:
        message = f"The recording has {_NOT_READ[letter]}, which are not read: export it without."
        findings.add(FILE, "header_not_read", message, lines=[line], value=text[:60])
    elif letter == "C":
        recording.columns = [_NAMED.sub(r"\1 [\2]", item).strip() for item in items]
    elif letter == "V":
        recording.hexadecimal = text.strip().upper() == "HEX"
    elif letter in "FI":
        numbers = [_parse_number(item.strip().encode()) for item in items]
        if any(number is None or not number > 0 for number in numbers):
            findings.add(FILE, "header_unreadable", "A header line holds no numbers above 0.", lines=[line], value=text)
        elif letter == "F":
            recording.factors = [number or 0.0 for number in numbers]
        else:
            recording.interval_ms = numbers[0]
    elif letter == "T":
        _take_time_header(recording, items, line, findings)
    elif letter not in "NL":
        message = "A header line is of no kind known here: it stays in the raw copy only."
        findings.add(NOTE, "header_ignored", message, lines=[line], value=header[0][:60])


def _take_time_header(recording: _Recording, items: Sequence[str], line: int, findings: FindingCollector) -> None:
    if len(items) == 2 and items[0].isdigit() and _TIME_FORMAT.fullmatch(items[1]):
        recording.time_position, recording.time_format = int(items[0]), items[1]
    else:
        message = "The time is written in a way that is not read: known are d, H, m, s and fractions f, as `ddHHmmss`."
        findings.add(FILE, "time_format_unknown", message, lines=[line], value=";".join(items))


def _take_row(recording: _Recording, text: str, line: int, rejected: int) -> bool:
    """Add the numbers of a line, or return False where it does not fit the columns."""
    cells = [cell.strip() for cell in text.removeprefix("$").split(";")]
    if not text.startswith("$") or len(cells) != len(recording.columns) + (recording.time_position is not None):
        return False
    if recording.time_position is not None:
        if recording.time_position >= len(cells):
            return False
        seconds = _clock_seconds(cells.pop(recording.time_position), recording.time_format)
        if seconds is None:
            return False
        recording.seconds.append(seconds)
    row = [_hexadecimal(cell) if recording.hexadecimal else _parse_number(cell.encode()) for cell in cells]
    numbers = [number for number in row if number is not None]
    if len(numbers) != len(row):
        del recording.seconds[len(recording.rows) :]
        return False
    recording.add(numbers, line, rejected)
    return True


def _hexadecimal(cell: str) -> float | None:
    return float(int(cell, 16)) if re.fullmatch(r"[0-9A-Fa-f]{1,12}", cell) else None


def _clock_seconds(cell: str, layout: str) -> float | None:
    """Return the digits of a stamp as seconds by a format as `ddHHmmss`, None where they do not fit it."""
    if len(cell) != len(layout) or not cell.isascii() or not cell.isdigit():
        return None
    seconds, start = 0.0, 0
    for run in re.finditer(r"(.)\1*", layout):
        digits = cell[start : start + len(run[0])]
        start += len(run[0])
        unit = _SECONDS.get(run[1], 10.0 ** -len(digits))
        seconds += unit * int(digits)
    return seconds


def _zero_signals(
    recording: _Recording, declared: Declarations, findings: FindingCollector, instrument: Instrument
) -> Reading:
    names: list[str] = list(recording.columns)
    columns: list[Column] = [recording.column(position) for position in range(len(names))]
    if recording.factors:
        if len(recording.factors) != len(columns):
            message = f"{len(recording.factors)} factors stand in the header for {len(columns)} columns."
            findings.add(FILE, "factors_mismatch", message)
            return Reading(rows_read=len(recording.rows))
        columns = [
            np.asarray(column * factor, dtype=np.float64)
            for column, factor in zip(columns, recording.factors, strict=True)
        ]
    if recording.time_position is not None:
        names.append("time [s]")
        columns.append(np.array(recording.seconds, dtype=np.float64))
    rate_hz = None if recording.interval_ms is None else 1000.0 / recording.interval_ms
    units = [None] * len(names)
    table = array_table(names, units, columns, Preamble(rate_hz), recording.lines, recording.ordinals)
    return read_signals(table, declared, findings, instrument)


FORMAT = Format("logview_openformat", 4, _recognise, _read, clues=(rb"\$",), score=NAMES)
ZERO = Format(
    "logview_zero",
    4,
    _recognise_zero,
    _read_zero,
    "Recordings of LogView Studio in OpenFormat Zero, whose headers name columns and units.",
    clues=(rb"\$",),
)
