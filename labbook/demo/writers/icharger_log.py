"""Junsi iCharger DUO log as it lies on the SD card: 22 fields a line, checksum by exclusive or.

Layout and scales were measured on public logs: `$channel;mode;t ms;type;flags;I 10 mA;Vin mV;Vpack mV;mAh;Tint
0.1 C;Text 0.1 C;ten cells mV;xor`, cells that are not connected 0. The checksum covers every byte from `$` to the
last `;`, both included.
"""

from __future__ import annotations

import functools
import operator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CHARGING = 1
"""Mode number of a charge."""
CELLS = 10
"""Cell columns of the DUO."""
_DATA_PACKET = 1


@dataclass(frozen=True, slots=True, eq=False)
class Recharge:
    """One recharge sampled in time: arrays of shape (n,), cells of shape (n, cells); charge counts up from 0."""

    time_s: FloatArray
    current_a: FloatArray
    input_v: FloatArray
    pack_v: FloatArray
    charge_mah: FloatArray
    internal_c: FloatArray
    external_c: FloatArray
    cell_v: FloatArray


def icharger_log(recharge: Recharge, *, channel: int = 1, mode: int = CHARGING) -> bytes:
    """Return the log of one charger channel, LF line ends."""
    cells = np.zeros((recharge.time_s.size, CELLS))
    cells[:, : recharge.cell_v.shape[1]] = recharge.cell_v
    columns = np.column_stack(
        [
            recharge.time_s * 1000,
            np.full(recharge.time_s.size, _DATA_PACKET),
            np.zeros(recharge.time_s.size),
            recharge.current_a * 100,
            recharge.input_v * 1000,
            recharge.pack_v * 1000,
            recharge.charge_mah,
            recharge.internal_c * 10,
            recharge.external_c * 10,
            cells * 1000,
        ]
    )
    counts = np.rint(columns).astype(np.int64)
    lines = [f"${channel};{mode};{';'.join(map(str, row))};".encode() for row in counts.tolist()]
    return b"".join(line + b"%d\n" % checksum(line) for line in lines)


def checksum(line: bytes) -> int:
    """Exclusive or of all bytes of a line, `$` to the last `;`, both included."""
    return functools.reduce(operator.xor, line, 0)
