"""Logs of Ghost Robotics' Minitaur on an OpenLog: a header that describes binary records, then AA BB and a record each.

Old layout: a line of names, a line of a Python `struct` format without byte order, always little-endian and packed.
New layout (version 1): `/1/<format/name+count+type,...`, in the scales of the maker's SDK. `t` counts milliseconds
since the robot was switched on; there is no sequence number, so that losses show in `t` only.
"""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ingest.formats.format import Format, Head
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, ROW, Declarations, FindingCollector, FloatArray, IntArray, Reading
from ingest.signals import combine, read_signals
from ingest.tables.table import Table, array_table

_TYPES = {
    "b": "i1", "B": "u1", "?": "u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "l": "<i4", "L": "<u4",
    "q": "<i8", "Q": "<u8", "f": "<f4", "d": "<f8",
}  # fmt: skip
MOST_RECORD_BYTES = 4096
_LONGEST_HEADER = 8192

_OLD_HEADER = re.compile(rb"([A-Za-z_][\w,]{0,2000})\r?\n([<>=@!]?[A-Za-z?\d]{1,500})\r?\n\Z")
_NEW_HEADER = re.compile(rb"/(\d{1,4})/(<[^/\n]{0,500})/([^\n]{0,4000}?)/?\r?\n\Z")
_LATER_HEADER = re.compile(rb"(?:/\d{1,4}/<[ -~]{3,4000}|t,[\w,]{1,2000}\r?\n[A-Za-z?\d]{1,500})\r?\Z")
_GROUP = re.compile(r"(\d{0,4})([A-Za-z?])")
_NEW_FIELD = re.compile(r"(\w*?[A-Za-z_])(\d{1,4})([A-Za-z?])")

_SCALES = {
    "pos": (0.001, "rad"), "torq": (0.001, "N*m"), "eul": (0.001, "rad"), "angVel": (0.001, "rad/s"),
    "Vbat": (0.001, "V"), "xdot": (0.001, "m/s"), "acc": (0.01, None), "Ibat": (0.01, "A"), "t": (1.0, "ms"),
}  # fmt: skip
"""Factor and unit of the maker's SDK; other quantities are counts of nothing known."""

_OLD_UNITS = {"t": "ms", **{f"q{joint}": "rad" for joint in range(8)}}
_STATES = ("mo", "behavMo")
_USER_BYTES = re.compile(r"UP\d*")
_USER_COLUMN = re.compile(r"UP\.(u8|i16|u16|i32|f32)\.(\d{1,4})")
_USER_TYPES = {"u8": "u1", "i16": "<i2", "u16": "<u2", "i32": "<i4", "f32": "<f4"}


@dataclass(frozen=True, slots=True)
class _Header:
    """A header and the records behind it, `data[start:]`, each a `record` without its sync bytes.

    `scales` are factor and unit by name; the bytes of `user` names, which follow each other, are the robot's program's.
    """

    begin: int
    start: int
    record: np.dtype[np.void]
    scales: Mapping[str, tuple[float, str | None]]
    user: tuple[str, ...]


class _HeaderFault(Exception):
    """Why a header cannot be used, in a sentence."""


def _recognise(head: Head) -> str | None:
    """A header of keys and a struct, and records that begin with AA BB."""
    return None if _header_at(head.data, 0) is None else "a header that describes the binary records behind it"


def _header_at(data: bytes, begin: int) -> re.Match[bytes] | None:
    """Return the header that begins there: a line of the new layout, or two of the old one and a record near them."""
    window = data[begin : begin + _LONGEST_HEADER]
    if window.startswith(b"/"):
        return _NEW_HEADER.fullmatch(window[: window.find(b"\n") + 1])
    stop = window.find(b"\n", window.find(b"\n") + 1) + 1
    found = _OLD_HEADER.fullmatch(window[:stop])
    near = window[stop : stop + len(SYNC) + MOST_RECORD_BYTES]
    # Two lines of words may begin any text; sync bytes elsewhere than next to them only where no text is.
    return found if near.startswith(SYNC) or (SYNC in near and b"\0" in near) else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    try:
        headers = _headers(head.data)
    except _HeaderFault as fault:
        findings.add(FILE, "record_layout_unreadable", str(fault))
        return Reading()
    if len(headers) > 1:
        message = "A header stands again: logging was started anew, and what follows is kept as a part of its own."
        findings.add(NOTE, "header_repeated", message, count=len(headers) - 1)
    readings = []
    for number, header in enumerate(headers, start=1):
        stop = headers[number].begin if number < len(headers) else len(head.data)
        records = _records(head.data, header, stop, findings)
        if records is None:
            continue
        table = _table(header, records, head.declared, findings)
        instrument = Instrument("log" if number == 1 else f"log_{number}")
        readings.append(read_signals(table, head.declared, findings, instrument))
    return combine(readings)


def _headers(data: bytes) -> list[_Header]:
    """Return all headers of a file: a card that was written on again holds several."""
    headers = [_parse(data, 0)]
    position = data.find(b"\n" + SYNC, headers[0].start)
    while position >= 0:
        begin = _begin_of_header(data, position, headers)
        if begin is not None:
            headers.append(_parse(data, begin))
        position = data.find(b"\n" + SYNC, position + 1)
    return headers


def _begin_of_header(data: bytes, end: int, known: Sequence[_Header]) -> int | None:
    """Return where a header that ends in the line end at `end` begins, None where none does."""
    first = data[: known[0].start]
    if data[end + 1 - len(first) : end + 1] == first:
        return end + 1 - len(first)
    window = data[max(known[-1].start, end - _LONGEST_HEADER) : end]
    text = _LATER_HEADER.search(window)
    return None if text is None else end - len(window) + text.start()


def _parse(data: bytes, begin: int) -> _Header:
    found = _header_at(data, begin)
    if found is None:
        raise _HeaderFault("The header of the log is cut: copy the file again from the memory card.")
    texts = [group.decode("latin-1") for group in found.groups()]
    if len(texts) == 2:
        names, letters = texts[0].split(","), _letters(texts[1])
        scales = {name: (1.0, _OLD_UNITS.get(name)) for name in names}
    else:
        version, layout, fields = texts
        if version != "1":
            raise _HeaderFault(f"The log is of version {version} and only version 1 is known: export it as text.")
        names, types = _new_names(fields)
        letters = _letters(layout)
        if types != letters:
            raise _HeaderFault("The two descriptions of a record in the header contradict each other.")
        scales = {name: _SCALES.get(re.sub(r"\d+\Z", "", name), (1.0, None)) for name in names}
    if len(names) != len(letters):
        raise _HeaderFault(f"The header names {len(names)} columns and describes {len(letters)} values of a record.")
    if len(set(names)) != len(names):
        raise _HeaderFault("The header names two columns alike.")
    record = np.dtype([(name, _TYPES[letter]) for name, letter in zip(names, letters, strict=True)])
    user = (name for name, letter in zip(names, letters, strict=True) if letter == "B" and _USER_BYTES.fullmatch(name))
    return _Header(begin, begin + len(found[0]), record, scales, tuple(user))


def _letters(layout: str) -> str:
    """Return the type letters of a `struct` format, one a value. Raises `_HeaderFault` for what is no such record."""
    if layout[0] in ">=@!":
        raise _HeaderFault(f"The records are said to have byte order {layout[0]!r}: only little-endian logs are known.")
    groups = layout.removeprefix("<")
    if "".join(count + letter for count, letter in _GROUP.findall(groups)) != groups:
        raise _HeaderFault(f"{layout[:60]!r} describes no record of numbers.")
    expanded = []
    for count, letter in _GROUP.findall(groups):
        if letter not in _TYPES:
            allowed = " ".join(_TYPES)
            raise _HeaderFault(f"A record holds type {letter!r}, which is no number: known are {allowed}.")
        expanded.append(letter * int(count or 1))
    letters = "".join(expanded)
    n_bytes = sum(np.dtype(_TYPES[letter]).itemsize for letter in letters)
    if not 0 < n_bytes <= MOST_RECORD_BYTES:
        raise _HeaderFault(f"A record is said to have {n_bytes} bytes: 1 to {MOST_RECORD_BYTES} are allowed.")
    return letters


def _new_names(fields: str) -> tuple[list[str], str]:
    """Return a name for every value, and the type letters, of `name+count+type,...`."""
    names: list[str] = []
    letters = ""
    for field in fields.split(","):
        match = _NEW_FIELD.fullmatch(field)
        if match is None:
            raise _HeaderFault(f"{field[:40]!r} in the header is no name with count and type.")
        count = int(match[2])
        names += [match[1]] if count == 1 else [f"{match[1]}{index}" for index in range(count)]
        letters += match[3] * count
    return names, letters


def _records(data: bytes, header: _Header, stop: int, findings: FindingCollector) -> FramedRecords | None:
    """Return the records behind a header; what is lost or stands between them is reported."""
    least = header.record.itemsize + len(SYNC)
    stride = spacing(data, header.start, stop, least)
    if stride is None:
        stride = least
        if stop - header.start >= 2 * least:
            message = f"The header describes records of {least} bytes and no two AA BB stand that far apart: "
            message += "no record can be read; copy the file again from the memory card."
            findings.add(FILE, "records_not_found", message)
            return None
    elif stride != least:
        message = (
            f"The header describes records of {least} bytes and they stand {stride} apart: the {stride - least} bytes "
            "behind each stay in the raw copy only."
        )
        findings.add(NOTE, "stride_differs", message, value=str(stride))
    records = find_records(data, header.start, stop, header.record.itemsize, stride)
    if records.records_lost:
        message = (
            f"Bytes are missing or foreign: {records.bytes_lost} bytes belong to no whole record of {stride}; "
            "the records that they cut are left out."
        )
        findings.add(ROW, "record_cut", message, count=records.records_lost, value=f"at byte {records.lost_at[0]}")
    return records


def _table(header: _Header, records: FramedRecords, declared: Declarations, findings: FindingCollector) -> Table:
    values = records.payloads.view(header.record)[:, 0]
    scales = {name: scale for name, scale in header.scales.items() if name not in header.user}
    columns = {name: values[name].astype(np.float64) * factor for name, (factor, _) in scales.items()}
    if header.user:
        columns |= _user_columns(header, records, declared, findings)
    if any(factor != 1.0 for factor, _ in scales.values()):
        message = "Scales and units are those of the maker's SDK, version 1; the file does not state them."
        findings.add(NOTE, "unit_assumed", message)
    if "Ibat" in columns:
        message = "Whether the battery's current is positive while it is drawn is stated nowhere: its sign is kept."
        findings.add(NOTE, "current_sign_unknown", message, column="Ibat")
    units = [scales[name][1] if name in scales else None for name in columns]
    table = array_table(
        [*columns], units, [*columns.values()], ordinals=records.ordinals, rows_rejected=records.records_lost
    )
    states = tuple("controller_state" if name in _STATES else None for name in columns)
    return dataclasses.replace(table, channels=states)


def _user_columns(
    header: _Header, records: FramedRecords, declared: Declarations, findings: FindingCollector
) -> dict[str, FloatArray]:
    """Return the columns that declarations see in the user bytes: `UP.f32.3` is the fourth float of 4 bytes in them."""
    start = header.record.fields[header.user[0]][1] if header.record.fields else 0
    own = records.payloads[:, start : start + len(header.user)]
    of_profiles = (name for profile in declared.profiles for name in profile.columns)
    found: dict[str, FloatArray] = {}
    for name in (*declared.columns, *declared.profile_columns, *of_profiles):
        if (match := _USER_COLUMN.fullmatch(name)) is not None:
            dtype = np.dtype(_USER_TYPES[match[1]])
            first = int(match[2]) * dtype.itemsize
            if first + dtype.itemsize <= len(header.user):
                raw = np.ascontiguousarray(own[:, first : first + dtype.itemsize])
                found[name] = raw.view(dtype)[:, 0].astype(np.float64)
    if not found:
        message = (
            f"The {len(header.user)} user bytes of a record have the layout that the robot's program gave them: they "
            'stay in the raw copy only; to name them, `--column "UP.f32.0=CHANNEL:UNIT"` (u8, i16, u16, i32, f32 and '
            "its number)."
        )
        findings.add(NOTE, "user_bytes", message)
    return found


SYNC = b"\xaa\xbb"
_SAMPLE_BYTES = 1 << 18

ByteArray = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class FramedRecords:
    """`payloads`, shape (n, payload bytes), without sync bytes; `ordinals` number the records, those lost counted.

    `lost_at` are the offsets at which records are missing or cut, `bytes_lost` all bytes that belong to no record.
    """

    payloads: ByteArray
    ordinals: IntArray
    records_lost: int
    bytes_lost: int
    lost_at: tuple[int, ...]


def spacing(data: bytes, start: int, stop: int, least: int) -> int | None:
    """Return the usual distance, `least` bytes or more, between sync bytes; None where there are no two."""
    bytes_ = np.frombuffer(data, dtype=np.uint8)[start : min(stop, start + _SAMPLE_BYTES)]
    places = np.flatnonzero((bytes_[:-1] == SYNC[0]) & (bytes_[1:] == SYNC[1]))
    distances: Counter[int] = Counter()
    for further in range(1, 5):
        distances.update((places[further:] - places[:-further]).tolist())
    possible = [(-count, distance) for distance, count in distances.items() if distance >= least]
    return min(possible)[1] if possible else None


def find_records(data: bytes, start: int, stop: int, payload: int, stride: int) -> FramedRecords:
    """Return the whole records of `data[start:stop]`, `stride` bytes apart from sync to sync.

    A record is whole where the next one follows it or the data end there; so is the one before a record of which the
    sync bytes alone are damaged.
    """
    bytes_ = np.frombuffer(data, dtype=np.uint8)
    synced = (bytes_[start : stop - 1] == SYNC[0]) & (bytes_[start + 1 : stop] == SYNC[1])
    places = (np.flatnonzero(synced) + start).tolist()
    known = {*places}
    found: list[int] = []
    ordinals: list[int] = []
    lost_at: list[int] = []
    lost, position = 0, start
    for place in [*places, stop]:
        after = place + stride
        goes_on = bool(found) and found[-1] + stride == place and after + stride in known
        if place < position or not (place == stop or after in known or after == stop or goes_on):
            continue
        if place > position:
            lost += max(1, round((place - position) / stride))
            lost_at.append(position)
        if place < stop:
            found.append(place)
            ordinals.append(len(ordinals) + lost)
        position = after
    within = np.arange(len(SYNC), len(SYNC) + payload)
    payloads = bytes_[np.array(found, dtype=np.int64)[:, np.newaxis] + within]
    numbers = np.array(ordinals, dtype=np.int64)
    return FramedRecords(payloads, numbers, lost, stop - start - len(found) * stride, tuple(lost_at))


FORMAT = Format("minitaur_log", 4, _recognise, _read, clues=(SYNC, b"/<"))
