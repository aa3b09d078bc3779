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
    """Return a column of numbers, shape (n,): whole ones of 64 bits as such, else as float64, NaN where one is missing.

    Raises `pyarrow.ArrowException` for a column of anything else.
    """
    whole = column.type == pa.int64() and not column.null_count
    if not whole and column.type != pa.float64():
        column = column.cast(pa.float64())
    values = np.empty(len(column), np.int64 if whole else np.float64)
    at = 0
    for chunk in column.chunks:
        filled = chunk.fill_null(np.nan) if chunk.null_count else chunk
        if len(chunk):
            values[at : at + len(chunk)] = np.frombuffer(
                filled.buffers()[1], values.dtype, len(chunk), filled.offset * values.itemsize
            )
        at += len(chunk)
    return values
