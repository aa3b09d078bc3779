"""C3D files: force platforms and analog channels as one part, markers as another.

Channels that a platform is made of are stored as its forces and moments only. A marker that was not seen has a negative
residual; its place is NaN.

Platforms of types 1 to 4 go from analog channels to the ground reaction with z up. The channels give the reaction on
the subject in the platform's own axes, z down. The corners define where these lie in the room: x from corner 2 to
corner 1, y from corner 4 to corner 1. Moments are about the middle of the surface, so that `-moment_y / force_z` and
`moment_x / force_z` are where the force acts, seen from there.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ingest.channels.names import squash
from ingest.formats.format import Format, Head
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, FindingCollector, FloatArray, Reading
from ingest.signals import read_several
from ingest.tables.table import Preamble, Table, array_table

_UNITS = {f"{quantity}_{axis}": unit for quantity, unit in (("force", "N"), ("moment", "N*m")) for axis in "xyz"}


def _recognise(head: Head) -> str | None:
    """The second byte, 50 hex."""
    is_c3d = head.source is None and len(head.data) >= BLOCK and re.match(_BEGINS, head.data[:2])
    return "byte 2 is 50 hex, as of a C3D file" if is_c3d else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    tables = []
    try:
        with np.errstate(invalid="ignore", over="ignore"):  # values out of range are found with those of every format
            sections = read_sections(head.data)
            points, analogs = _values(head.data, sections)
            if analogs.shape[1]:
                tables.append(_analog_table(sections, analogs, findings))
            if points.shape[1]:
                tables.append(_marker_table(sections, points))
    except C3dDamagedError as damage:
        findings.add(FILE, "c3d_damaged", f"The C3D file cannot be read: {damage}; copy it again from its source.")
        return Reading()
    return read_several(tables, head.declared, findings)


def _values(data: bytes, sections: C3dSections) -> tuple[FloatArray, FloatArray]:
    """Return points, shape (3, n_points, n_frames), and analog values, shape (n_samples, n_analogs)."""
    rows = sections.values(data)
    points = rows[:, : 4 * sections.n_points].reshape(sections.n_frames, sections.n_points, 4)
    places = points[:, :, :3] * (1.0 if sections.scale < 0 else sections.scale)
    places[points[:, :, 3] < 0] = np.nan
    raw = rows[:, 4 * sections.n_points :].reshape(-1, sections.n_analogs) if sections.n_analogs else np.empty((0, 0))
    return places.transpose(2, 1, 0), _scaled(raw, sections)


def _scaled(raw: FloatArray, sections: C3dSections) -> FloatArray:
    """Return analog values in the units of the file: raw less its offset, times both scales."""
    count = raw.shape[1]
    offsets, scales = (sections.numbers(f"ANALOG:{name}")[:count] for name in ("OFFSET", "SCALE"))
    if min(offsets.size, scales.size) < count:
        raise C3dDamagedError(f"it has {count} analog channels and scales of {min(offsets.size, scales.size)}")
    if "UNSIGNED" in sections.texts("ANALOG:FORMAT"):
        offsets = offsets % 65536
        raw = raw % 65536 if sections.scale > 0 else raw
    general = sections.first("ANALOG:GEN_SCALE")
    return (raw - offsets) * (scales * (1.0 if general is None else general))


def _analog_table(sections: C3dSections, analogs: FloatArray, findings: FindingCollector) -> tuple[Table, Instrument]:
    labels = _padded(sections.texts("ANALOG:LABELS"), analogs.shape[1], "channel")
    units = _padded(sections.texts("ANALOG:UNITS"), analogs.shape[1], "")
    plates = _plates(sections, analogs, units, findings)
    names: list[str] = []
    column_units: list[str | None] = []
    columns: list[FloatArray] = []
    for number, found in enumerate(plates, start=1):
        suffix = "" if number == 1 else f"_{number}"
        for quantity, unit, values in (("force", "N", found.force_n), ("moment", "N*m", found.moment_nm)):
            for at, axis in enumerate("xyz"):
                names.append(f"{quantity}_{axis}{suffix}")
                column_units.append(unit if found.has_units else None)
                columns.append(np.ascontiguousarray(values[:, at]))
    used = {channel for found in plates for channel in found.channels}
    for channel in range(analogs.shape[1]):
        if channel not in used:
            # The word before it keeps a raw channel `Fz1` from being taken for the force of a platform.
            names.append(f"analog {labels[channel]}")
            column_units.append(units[channel] or None)
            columns.append(np.ascontiguousarray(analogs[:, channel]))
    preamble = Preamble((sections.point_rate_hz * sections.ratio) or None, None, "ANALOG:RATE")
    table = array_table(names, column_units, columns, preamble)
    return (table, Instrument("force" if plates else "analog", "the C3D standard", _UNITS, evidence="C3D"))


def _plates(sections: C3dSections, analogs: FloatArray, units: list[str], findings: FindingCollector) -> list[Plate]:
    plates = []
    for number in range(min(16, int(sections.first("FORCE_PLATFORM:USED") or 0))):
        found = plate(sections, number, analogs, units)
        if found is None:
            message = (
                f"Force platform {number + 1} is of a type other than 1 to 4, or its channels or calibration are not "
                "in the file: its raw channels are kept as they are."
            )
            findings.add(NOTE, "plate_not_known", message, column=f"platform {number + 1}")
        else:
            plates.append(found)
    return plates


def _marker_table(sections: C3dSections, points: FloatArray) -> tuple[Table, Instrument]:
    labels = _padded(sections.texts("POINT:LABELS"), points.shape[1], "point")
    metres = length_factor(sections)
    columns = [points[axis, number] * (metres or 1.0) for number in range(len(labels)) for axis in range(3)]
    names = [f"{label} {axis}" for label in labels for axis in "xyz"]
    units = ["m" if metres else None] * len(names)
    table = array_table(names, units, columns, Preamble(sections.point_rate_hz or None, None, "POINT:RATE"))
    return (table, Instrument("markers", evidence="the C3D standard"))


def _padded(texts: tuple[str, ...], count: int, word: str) -> list[str]:
    """Return a text for each of `count` channels; those without one are numbered."""
    given = [*texts[:count], *[""] * (count - len(texts))]
    return [text or (f"{word} {number}" if word else "") for number, text in enumerate(given, start=1)]


CHANNELS_OF_TYPE = {1: 6, 2: 6, 3: 8, 4: 6}

_FORCES = {"n": 1.0, "nt": 1.0, "newton": 1.0, "newtons": 1.0, "kn": 1e3, "lbf": 4.4482216152605}
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
_LENGTHS |= dict.fromkeys(("mete", "meter", "meters", "metre", "metres"), 1.0)
_MOMENTS = {
    force + length: newtons * metres for force, newtons in _FORCES.items() for length, metres in _LENGTHS.items()
}
_ASSUMED_LENGTH = 1e-3
_DOWN_TO_UP = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Plate:
    """Reaction on the subject: `force_n` and `moment_nm` of shape (n_samples, 3), z up.

    `channels` are the analog channels it was made of; `assumed` names what the file does not contain.
    """

    channels: tuple[int, ...]
    force_n: FloatArray
    moment_nm: FloatArray
    has_units: bool


def length_factor(sections: C3dSections) -> float | None:
    """Return metres per unit of length of points, corners and origins; None where the file has none."""
    units_in_file = sections.texts("POINT:UNITS")
    return _LENGTHS.get(squash(units_in_file[0])) if units_in_file else None


def plate(sections: C3dSections, number: int, analogs: FloatArray, units: list[str]) -> Plate | None:
    """Return platform `number` (from 0), None for a type other than 1 to 4 or where a parameter of it is missing.

    `analogs` has shape (n_samples, n_analogs) in the units of the file, `units` one for each.
    """
    types = sections.numbers("FORCE_PLATFORM:TYPE")
    kind = int(types[number]) if number < types.size else 0
    channels = _channels(sections, number, CHANNELS_OF_TYPE.get(kind, 0), len(units))
    matrix = _matrix(sections, number) if kind == 4 else np.eye(6)
    if channels is None or matrix is None:
        return None
    length = length_factor(sections)
    metres = length or _ASSUMED_LENGTH
    units_in_file = [squash(units[channel]) for channel in channels]
    newtons = _FORCES.get(units_in_file[0])
    newton_metres = _MOMENTS.get(units_in_file[5]) if kind in (2, 4) else metres * (newtons or 1.0)
    per_force, per_moment = newtons or 1.0, newton_metres or metres * (newtons or 1.0)
    origin = _origin(sections, number) * metres
    raw = analogs[:, list(channels)]
    if kind == 1:
        place, free = _LENGTHS.get(units_in_file[3], metres), _MOMENTS.get(units_in_file[5], per_moment)
        values = _of_point(raw * np.array([per_force] * 3 + [place] * 2 + [free]))
        origin = origin * 0.0
    elif kind == 3:
        values = _of_four_sensors(raw * per_force, *origin[:2])
        origin = origin * np.array([0.0, 0.0, 1.0])
    else:
        values = (raw @ matrix.T if kind == 4 else raw) * np.array([per_force] * 3 + [per_moment] * 3)
    force, moment = values[:, :3], values[:, 3:]
    turn = _to_room(sections, number)
    moment = moment + np.cross(force, origin)
    return Plate(channels, force @ turn.T, moment @ turn.T, None not in (newtons, newton_metres, length))


def _table(sections: C3dSections, name: str, dimensions: int) -> FloatArray | None:
    """Return a parameter of numbers in its shape; None where it is absent or has other dimensions."""
    found = sections.parameters.get(f"FORCE_PLATFORM:{name}")
    if found is None or found.texts or len(found.shape) != dimensions:
        return None
    return found.numbers.reshape(found.shape, order="F")


def _channels(sections: C3dSections, number: int, count: int, n_analogs: int) -> tuple[int, ...] | None:
    found = _table(sections, "CHANNEL", 2)
    if found is None or not count or found.shape[0] < count or number >= found.shape[1]:
        return None
    channels = tuple(int(channel) - 1 for channel in found[:count, number])
    return channels if all(0 <= channel < n_analogs for channel in channels) else None


def _matrix(sections: C3dSections, number: int) -> FloatArray | None:
    """Return the calibration of a type 4 platform, shape (6, 6)."""
    found = _table(sections, "CAL_MATRIX", 3)
    if found is None or found.shape[:2] != (6, 6) or number >= found.shape[2]:
        return None
    by_row = "BYROW" in sections.texts("FORCE_PLATFORM:MATRIX_STORE")
    return found[:, :, number].T if by_row else found[:, :, number]


def _origin(sections: C3dSections, number: int) -> FloatArray:
    """Return the vector to the sensors' origin; it lies below the surface, some files write it the other way round."""
    origins = sections.numbers("FORCE_PLATFORM:ORIGIN")[3 * number : 3 * number + 3]
    origin = origins if origins.size == 3 else np.zeros(3)
    return -origin if origin[2] > 0 else origin


def _of_four_sensors(raw: FloatArray, across: float, along: float) -> FloatArray:
    """Return forces and moments, shape (n, 6), of Kistler's channels Fx12, Fx34, Fy14, Fy23, Fz1 to Fz4."""
    x12, x34, y14, y23, z1, z2, z3, z4 = raw.T
    return np.column_stack(
        [
            x12 + x34,
            y14 + y23,
            z1 + z2 + z3 + z4,
            along * (z1 + z2 - z3 - z4),
            across * (z2 + z3 - z1 - z4),
            along * (x34 - x12) + across * (y14 - y23),
        ]
    )


def _of_point(raw: FloatArray) -> FloatArray:
    """Return forces and moments, shape (n, 6), of Fx, Fy, Fz, the point where they act and the free moment."""
    fx, fy, fz, x, y, free = raw.T
    return np.column_stack([fx, fy, fz, y * fz, -x * fz, free + x * fy - y * fx])


def _to_room(sections: C3dSections, number: int) -> FloatArray:
    """Return the rotation, shape (3, 3), from the platform's axes to those of the room with z up.

    Where the platform lies in another plane of the room than x and y, the axes are exchanged in turn until z is
    across it; without corners the platform is turned over about its x axis.
    """
    corners = sections.numbers("FORCE_PLATFORM:CORNERS")[12 * number : 12 * number + 12]
    if corners.size < 12:
        return _DOWN_TO_UP
    first, second, _, fourth = corners.reshape(4, 3)
    normal = np.cross(first - second, first - fourth)
    size = float(np.linalg.norm(normal))
    if not np.isfinite(size) or size == 0:
        return _DOWN_TO_UP
    x = (first - second) / np.linalg.norm(first - second)
    z = normal / size
    turn = np.column_stack([x, np.cross(z, x), z])
    across = int(np.abs(z).argmax())
    return np.roll(turn, 2 - across, axis=0)


BLOCK = 512
_BEGINS = rb"[\x02-\x20]\x50"
INTEL, DEC, SGI = 84, 85, 86
_CHARACTERS = -1
_TYPES = (_CHARACTERS, 1, 2, 4)  # of numbers, their bytes
_READ_GROUPS = ("POINT:", "ANALOG:", "FORCE_PLATFORM:")
_OVERFLOW = 65535
_RATES_AGREE = 1e-4


class C3dDamagedError(ValueError):
    """The file contradicts itself or is cut; the message names the place."""


@dataclass(frozen=True, slots=True, eq=False)
class Parameter:
    """One parameter: numbers flat with the first index fastest, shape (prod(shape),), or texts, one a label."""

    numbers: FloatArray
    texts: tuple[str, ...]
    shape: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class C3dSections:
    """What stands before the data: `parameters` by `GROUP:NAME`; the data begin at byte `start`, integers of two bytes
    where `scale` (length units a step) is positive, else floats of four.
    """

    processor: int
    n_points: int
    n_analogs: int
    ratio: int
    n_frames: int
    point_rate_hz: float
    scale: float
    start: int
    parameters: Mapping[str, Parameter]

    def numbers(self, name: str) -> FloatArray:
        """Return the numbers of a parameter, its continuations included, shape (n,); empty where the file has none."""
        return np.concatenate([np.empty(0), *(found.numbers for found in self._continued(name))])

    def texts(self, name: str) -> tuple[str, ...]:
        """Return the texts of a parameter, its continuations included."""
        return tuple(text for found in self._continued(name) for text in found.texts)

    def _continued(self, name: str) -> list[Parameter]:
        """Return a parameter and what follows beyond 255 channels (`LABELS2`, `SCALE2`)."""
        names = [name, *(f"{name}{number}" for number in range(2, 300))]
        return [self.parameters[part] for part in names if part in self.parameters]

    def values(self, data: bytes) -> FloatArray:
        """Return the numbers of all frames as they stand, shape (n_frames, 4 n_points + ratio n_analogs)."""
        width = 4 * self.n_points + self.ratio * self.n_analogs
        size = 4 if self.scale < 0 else 2
        return _numbers(data, self.start, self.n_frames * width, size, self.processor).reshape(self.n_frames, width)

    def first(self, name: str) -> float | None:
        """Return the first number of a parameter, or None."""
        numbers = self.numbers(name)
        return float(numbers[0]) if numbers.size else None


def read_sections(data: bytes) -> C3dSections:
    """Read and check everything before the data. Raises `C3dDamagedError`."""
    start = (data[0] - 1) * BLOCK
    if start + 4 > len(data):
        raise C3dDamagedError(f"its parameter section should begin at byte {start} and it has {len(data)}")
    processor = data[start + 3]
    if processor not in (INTEL, DEC, SGI):
        raise C3dDamagedError(f"byte {start + 3} says processor {processor}, which is none of 84, 85 and 86")
    words = _numbers(data, 0, 12, 2, processor).astype(np.int64) & 0xFFFF
    n_points, per_frame, first, last, block, ratio = (int(words[at]) for at in (1, 2, 3, 4, 8, 9))
    scale, rate = (float(_numbers(data, at, 1, 4, processor)[0]) for at in (12, 20))
    begin = (block - 1) * BLOCK
    if not start < begin <= len(data):
        raise C3dDamagedError(f"its data should begin at byte {begin} and it has {len(data)}")
    parameters = _parameters(data, start + 4, begin, processor)
    sections = C3dSections(processor, n_points, 0, ratio, 0, rate, scale, begin, parameters)
    n_frames = _frames(sections, first, last)
    n_analogs = _analogs(sections, per_frame)
    _compare("points", n_points, "POINT:USED", sections.first("POINT:USED"))
    _compare("first block of data", block, "POINT:DATA_START", sections.first("POINT:DATA_START"))
    scale_parameter = sections.first("POINT:SCALE")
    if not math.isfinite(scale) or (
        scale_parameter is not None and not math.isclose(scale, scale_parameter, rel_tol=1e-5)
    ):
        raise C3dDamagedError(f"its header's scale is {scale:g} and POINT:SCALE {scale_parameter}")
    _check_length(data, begin, n_frames * (4 * n_points + per_frame) * (4 if scale < 0 else 2), n_frames)
    return dataclasses.replace(
        sections, n_analogs=n_analogs, ratio=max(1, ratio), n_frames=n_frames, point_rate_hz=_rate(sections, rate)
    )


def _numbers(data: bytes, start: int, count: int, size: int, processor: int) -> FloatArray:
    """Return numbers of `size` bytes, signed integers below 4 and floats of 4, as float64, shape (count,)."""
    order = ">" if processor == SGI else "<"
    if size != 4:
        return np.frombuffer(data, f"{order}i{size}", count, start).astype(np.float64)
    with np.errstate(invalid="ignore"):  # of a signalling NaN, which damage can write
        if processor == DEC:  # words are the other way round, and the exponent counts two more
            halves = np.frombuffer(data, "<u2", 2 * count, start).reshape(-1, 2)[:, ::-1]
            return np.ascontiguousarray(halves).view("<f4")[:, 0].astype(np.float64) / 4
        return np.frombuffer(data, f"{order}f4", count, start).astype(np.float64)


def _parameters(data: bytes, at: int, end: int, processor: int) -> dict[str, Parameter]:
    """Walk the records of groups and parameters, which end with a name of no length or a step of zero."""
    groups: dict[int, str] = {}
    found: list[tuple[int, str, Parameter]] = []
    while at + 2 <= end and data[at] != 0:
        name_end = at + 2 + abs(int.from_bytes(data[at : at + 1], signed=True))
        group = int.from_bytes(data[at + 1 : at + 2], signed=True)
        if name_end + 4 > end or group == 0:
            raise C3dDamagedError(f"its parameter section is damaged at byte {at}")
        name = data[at + 2 : name_end].decode("latin-1").strip().upper()
        step, other = (int(_numbers(data, name_end, 1, 2, order)[0]) for order in (processor, INTEL))
        if name_end + step > end >= name_end + other:  # some SGI writers leave the last step in Intel's order
            step = other
        content_end = name_end + 3
        if group < 0:
            groups[-group] = name
        else:
            parameter, content_end = _parameter(data, name_end + 2, end, processor)
            found.append((group, name, parameter))
        if step == 0:
            break
        if name_end + step < content_end or name_end + step > end:
            raise C3dDamagedError(f"its parameter section is damaged at byte {name_end}: {name!r} does not end there")
        at = name_end + step
    named = {f"{groups[group]}:{name}": parameter for group, name, parameter in found if group in groups}
    for name, parameter in named.items():
        if name.startswith(_READ_GROUPS) and not np.isfinite(parameter.numbers).all():
            raise C3dDamagedError(f"{name} is not finite")
    return named


def _parameter(data: bytes, at: int, end: int, processor: int) -> tuple[Parameter, int]:
    """Return the parameter whose type stands at `at`, and where its numbers or texts end."""
    size = int.from_bytes(data[at : at + 1], signed=True)
    dimensions = data[at + 1] if at + 1 < end else 0
    start = at + 2 + dimensions
    shape = tuple(data[at + 2 : start])
    count = math.prod(shape)
    if size not in _TYPES or dimensions > 7 or start + count * abs(size) > end:
        raise C3dDamagedError(f"its parameter section is damaged at byte {at}")
    if size == _CHARACTERS:
        width = shape[0] if shape else 1
        cells = [data[cell : cell + width] for cell in range(start, start + count, max(1, width))]
        texts = tuple(cell.decode("latin-1").strip(" \0") for cell in cells)
        return Parameter(np.empty(0), texts, shape), start + count
    return Parameter(_numbers(data, start, count, size, processor), (), shape), start + count * size


def _compare(what: str, in_header: int, name: str, parameter: float | None) -> None:
    if parameter is not None and int(parameter) & 0xFFFF != in_header:
        raise C3dDamagedError(f"its header says {in_header} for {what} and {name} says {int(parameter) & 0xFFFF}")


def _frames(sections: C3dSections, first: int, last: int) -> int:
    """Return the number of frames: a word of the header holds 65535 at most, longer trials have it in parameters."""
    in_header = last - first + 1
    if in_header < 0:
        raise C3dDamagedError(f"its first frame is {first} and its last one {last}")
    begin, end = (sections.numbers(f"TRIAL:ACTUAL_{which}_FIELD") for which in ("START", "END"))
    long = sections.first("POINT:LONG_FRAMES")
    parameter = int(long) if long is not None and math.isfinite(long) else None
    if begin.size == 2 and end.size == 2:
        low, high = (int(field[0]) % 65536 + 65536 * (int(field[1]) % 65536) for field in (begin, end))
        parameter = high - low + 1
    frames = in_header if parameter is None else parameter
    if frames != in_header and (last != _OVERFLOW or frames <= in_header):
        raise C3dDamagedError(f"its header says {in_header} frames and its parameters say {frames}")
    if last != _OVERFLOW:
        _compare("frames", in_header, "POINT:FRAMES", sections.first("POINT:FRAMES"))
    return frames


def _analogs(sections: C3dSections, per_frame: int) -> int:
    if not per_frame:
        return 0
    channels, rest = divmod(per_frame, max(1, sections.ratio))
    used = sections.first("ANALOG:USED")
    if rest or (used is not None and int(used) & 0xFFFF != channels):
        raise C3dDamagedError(
            f"its header says {per_frame} analog values a frame in {sections.ratio} samples, ANALOG:USED {used}"
        )
    return channels


def _rate(sections: C3dSections, in_header: float) -> float:
    """Return the rate of the frames, 0 where the file has none; header and parameters must agree where both have it."""
    point_hz, analog_hz = sections.first("POINT:RATE") or 0.0, sections.first("ANALOG:RATE") or 0.0
    rate = in_header or point_hz or (analog_hz / max(1, sections.ratio))
    for name, other in (("POINT:RATE", point_hz), ("ANALOG:RATE", analog_hz / max(1, sections.ratio))):
        if not (math.isfinite(rate) and rate >= 0 and math.isfinite(other)):
            raise C3dDamagedError(f"its rate is {rate:g} Hz and {name} {other:g} Hz")
        if rate and other and abs(other / rate - 1) > _RATES_AGREE:
            raise C3dDamagedError(f"its header gives {rate:g} frames a second and {name} {other:g}")
    return rate


def _check_length(data: bytes, begin: int, length: int, n_frames: int) -> None:
    """Compare the length of the file with its header; what is over may fill the last block and no more."""
    here = len(data) - begin
    if here < length:
        whole = here * n_frames // length
        raise C3dDamagedError(f"it was cut: its header says {n_frames} frames and it holds {whole}")
    if here - length >= BLOCK and any(data[begin + length + BLOCK :]):
        raise C3dDamagedError(f"its header says {length} bytes of data and {here} are there")


FORMAT = Format("c3d", 4, _recognise, _read, begins=_BEGINS)
