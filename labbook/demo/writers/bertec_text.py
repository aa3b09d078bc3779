"""Force-plate text with the columns of Bertec Acquire 4: one plate, 1 kHz, milliseconds, N, N*m, m.

Columns, the drifting clock and the axes (z down, so a pressing foot gives +Fz) follow a public table of such
exports; separators and line ends of the program itself are not public, so comma and CRLF are assumed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from labbook.demo.writers.fixed_point import delimited

FloatArray = NDArray[np.float64]

COLUMNS = ("Seq", "Timestamp", "Sync", "Aux", "Fx", "Fy", "Fz", "Mx", "My", "Mz", "COPx", "COPy")


def bertec_text(time_ms: FloatArray, force_n: FloatArray, moment_nm: FloatArray, cop_m: FloatArray) -> bytes:
    """Return the export: `time_ms` of shape (n,), force and moment (n, 3), centre of pressure (n, 2)."""
    n = time_ms.size
    zeros = np.zeros(n, dtype=np.int64)
    return delimited(
        ",".join(COLUMNS),
        [
            (np.arange(n, dtype=np.int64), 0),
            (time_ms, 5),
            (zeros, 0),
            (zeros, 0),
            *((force_n[:, axis], 4) for axis in range(3)),
            *((moment_nm[:, axis], 5) for axis in range(3)),
            *((cop_m[:, axis], 6) for axis in range(2)),
        ],
        line_end="\r\n",
    )
