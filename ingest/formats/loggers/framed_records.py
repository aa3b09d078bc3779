"""Binary records of one length behind two sync bytes: where they stand, also after bytes were lost.

Payloads hold the sync bytes by chance, so that a file split at every occurrence loses records. A record counts as whole
when the next one, or the end, follows where it must.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ingest.model import IntArray

SYNC = b"\xaa\xbb"
_SAMPLE_BYTES = 1 << 18
_RUN = 1 << 14

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
    """Return the whole records of `data[start:stop]`, `stride` bytes apart from sync to sync."""
    bytes_ = np.frombuffer(data, dtype=np.uint8)
    found: list[ByteArray] = []
    ordinals: list[IntArray] = []
    lost_at: list[int] = []
    found_records = lost = 0
    position = _next_record(data, start, stop, stride)
    if position != start:
        lost, lost_at = _records_in(position - start, stride), [start]
    while position < stop:
        run = _whole_records(bytes_, position, stop, stride)
        if run:
            block = bytes_[position : position + run * stride].reshape(run, stride)
            found.append(block[:, len(SYNC) : len(SYNC) + payload])
            ordinals.append(np.arange(found_records + lost, found_records + lost + run, dtype=np.int64))
            found_records += run
            position += run * stride
        if position < stop:
            following = _next_record(data, position + 1, stop, stride)
            lost += _records_in(following - position, stride)
            lost_at.append(position)
            position = following
    payloads = np.concatenate(found) if found else np.empty((0, payload), dtype=np.uint8)
    numbers = np.concatenate(ordinals) if ordinals else np.empty(0, dtype=np.int64)
    return FramedRecords(payloads, numbers, lost, stop - start - found_records * stride, tuple(lost_at))


def _records_in(n_bytes: int, stride: int) -> int:
    return max(1, round(n_bytes / stride))


def _whole_records(bytes_: ByteArray, start: int, stop: int, stride: int) -> int:
    """Return how many records from `start` on are each followed by the next one, or end exactly at `stop`.

    A record before one whose sync bytes alone are damaged is whole too.
    """
    whole = 0
    while True:
        first = start + whole * stride
        places = first + stride * np.arange(min(_RUN, (stop - first) // stride + 1))
        places = places[places + 1 < stop]
        synced = (bytes_[places] == SYNC[0]) & (bytes_[places + 1] == SYNC[1])
        run = len(synced) if synced.all() else int(np.argmin(synced))
        if run == _RUN:
            whole += run - 1  # the last of them is judged with what follows it
            continue
        whole += run
        break
    end = start + whole * stride
    if not whole or end == stop:
        return whole
    after = end + stride
    goes_on = after + 1 < stop and bytes_[after] == SYNC[0] and bytes_[after + 1] == SYNC[1]
    return whole if goes_on and end < stop else whole - 1


def _next_record(data: bytes, start: int, stop: int, stride: int) -> int:
    """Return the offset of the next sync bytes that others follow at the right distance, or the end; else `stop`."""
    position = data.find(SYNC, start, stop)
    while position >= 0:
        after = position + stride
        if after == stop or data[after : min(after + len(SYNC), stop)] == SYNC:
            return position
        position = data.find(SYNC, position + 1, stop)
    return stop
