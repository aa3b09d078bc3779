"""Synthetic Minitaur logs for tests, packed in code after public descriptions: no robot wrote these bytes."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

SYNC = b"\xaa\xbb"
OLD_NAMES = ["t", "r", "p", "y", *(f"q{n}" for n in range(8)), *(f"u{n}" for n in range(8)), "xd", "mo"]
OLD_FORMAT = "I" + "f" * 20 + "B"
NEW_HEADER = b"/1/<I30h32B/t1I,pos8h,torq8h,eul3h,angVel3h,acc3h,Vbat1h,Ibat1h,behavId1h,behavMo1h,xdot1h,UP32B\n"


def times_ms(n: int, rate_hz: float = 100.0, start_ms: int = 36_548) -> list[int]:
    """Whole milliseconds since the robot was switched on."""
    return [(start_ms + int(k * 1000.0 / rate_hz)) % 2**32 for k in range(n)]


def old_header(names: Sequence[str] = OLD_NAMES, layout: str = OLD_FORMAT) -> bytes:
    return (",".join(names) + "\n" + layout + "\n").encode()


def old_records(stamps: Sequence[int]) -> list[bytes]:
    """Records of the old layout; every 50th holds the sync bytes in its payload."""
    noise = np.random.default_rng(5)
    records = []
    for number, stamp in enumerate(stamps):
        values = noise.normal(0.0, 1.0, 20)
        payload = bytearray(struct.pack("<" + OLD_FORMAT, stamp, *values, number // 100 % 3))
        if number % 50 == 7:
            payload[20:22] = SYNC
        records.append(SYNC + bytes(payload))
    return records


def old_log(n: int = 400, rate_hz: float = 100.0) -> bytes:
    return old_header() + b"".join(old_records(times_ms(n, rate_hz)))


def new_records(stamps: Sequence[int], trailing: int = 0) -> list[bytes]:
    """Records of the new layout, with bytes behind each that the header does not mention."""
    records = []
    for number, stamp in enumerate(stamps):
        angles, gyro, acceleration = (10, 20, 30), (1, 2, 3), (0, 0, 981)
        shorts = [1571, *range(7), *[-250] * 8, *angles, *gyro, *acceleration, 15_800, -125, 2, number % 4]
        shorts += [500 + number % 9]
        user = struct.pack("<8f", 400.0, 12.5, number / 100.0, *[0.0] * 5)
        records.append(SYNC + struct.pack("<I30h", stamp, *shorts) + user + bytes(trailing))
    return records


def new_log(n: int = 400, rate_hz: float = 90.0, trailing: int = 0) -> bytes:
    return NEW_HEADER + b"".join(new_records(times_ms(n, rate_hz), trailing))
