"""Columns of large tables in mapped temporary files, and work on columns block by block wherever they lie.

A block of a column in a file is dropped from memory before the next.
"""

from __future__ import annotations

import mmap
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ingest.spool.mapped_bytes import drop_pages

Array = NDArray[np.generic]
Scalar = TypeVar("Scalar", bound=np.generic)

BLOCK_ROWS = 1 << 17
"""Rows of a block: 1 MiB of float64, a multiple of the size of a page."""

CACHED_ROWS = 1 << 15
"""Rows of a block in memory: what is computed of 256 KiB stays in the processor's cache."""


class _ColumnMap(mmap.mmap):
    """The file of one column in `folder`."""

    folder: Path


class ColumnFile(Generic[Scalar]):
    """A column that is being written to a temporary file without a name."""

    def __init__(self, folder: Path, dtype: np.dtype[Scalar]) -> None:
        self._folder, self._dtype = folder, dtype
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - closed by `finish`

    def append(self, values: NDArray[Scalar]) -> None:
        """Add rows, shape (n,)."""
        self._file.write(np.ascontiguousarray(values, dtype=self._dtype).data)

    def finish(self) -> NDArray[Scalar]:
        """Return the column, shape (n_rows,), mapped; no row can be added after."""
        with self._file as written:
            written.flush()
            if written.tell() == 0:
                return np.empty(0, dtype=self._dtype)
            mapped = _ColumnMap(written.fileno(), 0)
        mapped.folder = self._folder
        return np.frombuffer(mapped, dtype=self._dtype)


def folder_of(values: Array) -> Path | None:
    """Return the folder in which a column is mapped, None for one in memory."""
    mapped = _map_of(values)
    return None if mapped is None else mapped.folder


def let_go(*columns: Array) -> None:
    """Drop mapped columns from memory; they are read from their files again when needed."""
    for values in columns:
        mapped = _map_of(values)
        if mapped is not None:
            drop_pages(mapped, 0, len(mapped))


def row_blocks(values: Array) -> Iterator[slice]:
    """Yield slices of the rows in blocks; those of a mapped column are dropped from memory after use."""
    size = CACHED_ROWS if _map_of(values) is None else BLOCK_ROWS
    for start in range(0, max(1, len(values)), size):
        yield slice(start, min(start + size, len(values)))
        let_go(values)


def by_blocks(values: NDArray[Scalar], function: Callable[[NDArray[Scalar]], NDArray[Scalar]]) -> NDArray[Scalar]:
    """Return `function(values)`, shape (n,), for one that works value by value; mapped where `values` are."""
    folder = folder_of(values)
    if folder is None:
        return function(values)
    written = ColumnFile(folder, values.dtype)
    for rows in row_blocks(values):
        written.append(function(values[rows]))
    return written.finish()


def take(values: NDArray[Scalar], rows: NDArray[np.int64] | slice) -> NDArray[Scalar]:
    """Return `values[rows]`, mapped where `values` are and `rows`, ascending, is no slice."""
    folder = folder_of(values)
    if folder is None or isinstance(rows, slice):
        return values[rows]
    written = ColumnFile(folder, values.dtype)
    for start in range(0, len(rows), BLOCK_ROWS):
        written.append(values[rows[start : start + BLOCK_ROWS]])
        let_go(values)
    return written.finish()


def _map_of(values: Array) -> _ColumnMap | None:
    base: object = values
    while isinstance(base, np.ndarray):
        base = base.base
    owner = base.obj if isinstance(base, memoryview) else base
    return owner if isinstance(owner, _ColumnMap) else None
