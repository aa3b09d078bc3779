"""Columns of numbers from numpy to Arrow and back, as they lie in memory.

Arrow's own conversions import pandas first, to ask whether the values are a series of it. That is a tenth of a second
of every command that takes a file in, and a Ctrl-C during that import is swallowed there and leaves half of pandas
behind, so that what converts next fails.
"""

from __future__ import annotations

import numpy as np
import pyarrow as pa


def to_arrow(values: np.ndarray) -> pa.Array:
    """Return the values, shape (n,), as an Arrow array of float64 without a copy where they lie one after another."""
    doubles = np.ascontiguousarray(values, dtype=np.float64)
    return pa.Array.from_buffers(pa.float64(), doubles.size, [None, pa.py_buffer(doubles)])


def to_numpy(column: pa.ChunkedArray) -> np.ndarray:
    """Return a column of float64 or int64, shape (n,); a number that is missing becomes NaN."""
    dtype = np.dtype(np.int64 if column.type == pa.int64() else np.float64)
    values = np.empty(len(column), dtype)
    at = 0
    for chunk in column.chunks:
        size = len(chunk)
        filled = chunk.fill_null(np.nan) if chunk.null_count else chunk
        start = filled.offset * dtype.itemsize
        values[at : at + size] = np.frombuffer(filled.buffers()[1], np.uint8)[
            start : start + size * dtype.itemsize
        ].view(dtype)
        at += size
    return values
