"""Synthetic C3D files in Intel order, written in code: one frame a sample, one platform, one marker."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

Value = Sequence[str] | np.ndarray


def platform(kind: int, matrix: np.ndarray | None = None, up: str = "z") -> dict[str, Value]:
    """The parameters of one platform of 600 by 400 mm at the room's (1000, 500), by name."""
    corners = np.array([[1300.0, 700, 0], [1300, 300, 0], [700, 300, 0], [700, 700, 0]])[:, [0, 1, 2]]
    if up == "y":
        corners = corners[:, [1, 2, 0]]
    found: dict[str, Value] = {
        "FORCE_PLATFORM:USED": np.array([1]),
        "FORCE_PLATFORM:TYPE": np.array([kind]),
        "FORCE_PLATFORM:CORNERS": corners.T.reshape(3, 4, 1),
        "FORCE_PLATFORM:ORIGIN": np.array([[120.0], [200.0], [-20.0]] if kind == 3 else [[1.0], [2.0], [-20.0]]),
        "FORCE_PLATFORM:CHANNEL": np.arange(1, 9 if kind == 3 else 7).reshape(-1, 1),
        "FORCE_PLATFORM:CAL_MATRIX": (np.zeros((6, 6)) if matrix is None else matrix)[:, :, None],
    }
    return found


def c3d_bytes(
    analog: np.ndarray,
    plate: dict[str, Value],
    rate_hz: float = 200.0,
    units: Sequence[str] = ("N",) * 3 + ("Nmm",) * 3 + ("V",) * 2,
    integers: bool = False,
    offset: int = 0,
    unsigned: bool = False,
    length: str = "mm",
) -> bytes:
    """A file with `analog` of shape (n_frames, 8) in the units of the file, floats unless `integers`."""
    n = len(analog)
    scale = 0.1 if integers else -0.1
    if plate["FORCE_PLATFORM:TYPE"][0] == 3:
        units = ["N"] * 8
    wrapped = (offset + 32768) % 65536 - 32768
    parameters: dict[str, Value] = {
        "POINT:USED": np.array([1]), "POINT:FRAMES": np.array([n]), "POINT:DATA_START": np.array([9]),
        "POINT:SCALE": np.array([scale]), "POINT:RATE": np.array([rate_hz]),
        "POINT:LABELS": ["FOOT"], "POINT:UNITS": [length],
        "ANALOG:USED": np.array([8]), "ANALOG:RATE": np.array([rate_hz]), "ANALOG:GEN_SCALE": np.array([1.0]),
        "ANALOG:SCALE": np.ones(8), "ANALOG:OFFSET": np.full(8, wrapped), "ANALOG:UNITS": list(units),
        "ANALOG:FORMAT": ["UNSIGNED" if unsigned else "SIGNED"],
        "ANALOG:LABELS": ["FX", "FY", "FZ", "MX", "MY", "MZ", "C7", "C8"], **plate,
    }  # fmt: skip
    section = _section(parameters)
    assert len(section) <= 7 * 512
    header = struct.pack("<BB5Hf2Hf", 2, 0x50, 1, 8, 1, n, 10, scale, 9, 1, rate_hz).ljust(512, b"\0")
    if integers:
        raw = (np.rint(analog) + offset).astype(np.int64).astype(np.uint16)
        points = np.tile(np.array([10, 20, 30, 0], np.uint16), (n, 1))
        data = np.hstack([points, raw]).astype("<u2").tobytes()
    else:
        data = np.hstack([np.tile([1.0, 2.0, 3.0, 0.0], (n, 1)), analog + offset]).astype("<f4").tobytes()
    return header + section.ljust(7 * 512, b"\0") + data + bytes(-len(data) % 512)


def _section(parameters: dict[str, Value]) -> bytes:
    groups = list(dict.fromkeys(name.split(":")[0] for name in parameters))
    records = [_record(group, -number, b"\0") for number, group in enumerate(groups, start=1)]
    for name, value in parameters.items():
        group, own = name.split(":")
        records.append(_record(own, groups.index(group) + 1, _value(value) + b"\0"))
    return struct.pack("<4B", 1, 0x50, 7, 84) + b"".join(records) + b"\0\0"


def _record(name: str, group: int, content: bytes) -> bytes:
    return struct.pack("<bb", len(name), group) + name.encode() + struct.pack("<h", len(content) + 2) + content


def _value(value: Value) -> bytes:
    if not isinstance(value, np.ndarray):
        width = max(map(len, value))
        return struct.pack("<bBBB", -1, 2, width, len(value)) + "".join(text.ljust(width) for text in value).encode()
    kind, letter = (2, "<i2") if value.dtype.kind == "i" else (4, "<f4")
    head = struct.pack("<bB", kind, value.ndim) + bytes(value.shape)
    return head + value.astype(letter).tobytes(order="F")
