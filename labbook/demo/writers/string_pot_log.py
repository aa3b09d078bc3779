"""Log of the string potentiometer and the robot as CSV: 300 Hz, units in the header, a fixed number of decimals."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from labbook.demo.writers.fixed_point import delimited

DEFAULT_DECIMALS = 6


def string_pot_log(
    time_ms: NDArray[np.int64],
    channels: Mapping[str, NDArray[np.float64]],
    decimals: Mapping[str, int] = MappingProxyType({}),
) -> bytes:
    """Return the log; `time_ms` and every channel have shape (n,), a channel's key is its header cell.

    The unit stands in the key where there is one, as in `body_height [m]`; `decimals` names the channels that are
    not written with six. Time is whole milliseconds since boot.
    """
    header = ",".join(["time [ms]", *channels])
    columns = [(values, decimals.get(name, DEFAULT_DECIMALS)) for name, values in channels.items()]
    return delimited(header, [(time_ms, 0), *columns])
