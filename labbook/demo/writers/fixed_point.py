"""Columns of numbers as delimited text with a fixed number of decimals, as a logger's `printf` writes them."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Column = tuple[NDArray[np.float64] | NDArray[np.int64], int]
"""Values of one column, shape (n,), and its decimals; integers are written without a point."""


def delimited(header: str, columns: Sequence[Column], *, delimiter: str = ",", line_end: str = "\n") -> bytes:
    """Return `header` and the rows as ASCII; values must be finite and below 1e12."""
    import pyarrow as pa
    import pyarrow.csv

    table = pa.table({str(number): _column(values, decimals) for number, (values, decimals) in enumerate(columns)})
    stream = io.BytesIO()
    stream.write(header.encode("ascii") + b"\n")
    options = pa.csv.WriteOptions(include_header=False, delimiter=delimiter, quoting_style="none")
    pa.csv.write_csv(table, stream, options)
    text = stream.getvalue()
    return text if line_end == "\n" else text.replace(b"\n", line_end.encode("ascii"))


def _column(values: NDArray[np.float64] | NDArray[np.int64], decimals: int) -> object:
    import pyarrow as pa

    if np.issubdtype(values.dtype, np.integer):
        return pa.array(values)
    # A decimal is printed with all its places and never in scientific notation, unlike a double.
    decimal = pa.decimal128(12 + decimals, decimals)
    if values.size and values[0] == values[-1] and np.all(values == values[0]):
        return pa.repeat(pa.scalar(float(values[0])).cast(decimal), values.size)
    return pa.array(values).cast(decimal)
