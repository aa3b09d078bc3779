"""Header and parameter section of a C3D file, checked against each other and against the length of the file.

C3D has no checksum; libraries that read it stop in silence where a file was cut, and some damage ends the whole
process there. What a file says twice
(frames, points, analog values, rates, scale, where the data begin) is therefore compared before its data are read.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ingest.model import FloatArray

BLOCK = 512
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
