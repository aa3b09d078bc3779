"""Large data outside memory: bytes and columns in temporary files without a name, mapped and read in blocks.

The bytes of a large file are read like `bytes`, and hardly any of them are in memory at a time; a block of a column in
a file is dropped from memory before the next. The files have no name, so that nothing of them is left however the
process ends.

Between numpy and Arrow columns go as they lie in memory: Arrow's own conversions import pandas first, to ask whether
the values are a series of it. That is a tenth of a second of every command that takes a file in, and a Ctrl-C during
that import is swallowed there and leaves half of pandas behind, so that what converts next fails.
"""

from __future__ import annotations

import hashlib
import mmap
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Generic, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import InputRefused

if TYPE_CHECKING:
    import pyarrow as pa

LARGE_BYTES = 1 << 27
"""A file larger than this is mapped; a smaller one is read into memory, which is quicker."""

BLOCK_BYTES = 1 << 20
"""A multiple of the size of a page."""


class MappedBytes(mmap.mmap):
    """Bytes that lie in a temporary file of `folder`; what `mmap` lacks of the methods of `bytes` works on a copy.

    Readers take it for `bytes`, so functions that make one are typed `bytes` too; `mapped` distinguishes them. `count`
    and `in` look for single bytes.
    """

    folder: Path
    descriptor: int = -1
    """Of the file, so that less of it can be mapped too."""

    def __del__(self) -> None:
        if self.descriptor >= 0:
            os.close(self.descriptor)

    def count(self, part: bytes, start: int = 0, stop: int | None = None) -> int:
        """Count a byte in `self[start:stop]`."""
        end = len(self) if stop is None else stop
        return sum(block.count(part) for block in blocks(cast(bytes, self), start, end))

    def isascii(self) -> bool:
        """Whether no byte is above 127."""
        return all(block.isascii() for block in blocks(cast(bytes, self), 0, len(self)))

    def startswith(self, prefix: bytes | tuple[bytes, ...]) -> bool:
        """Whether the bytes begin with `prefix`, or with one of several."""
        longest = len(prefix) if isinstance(prefix, bytes) else max(map(len, prefix), default=0)
        return self[:longest].startswith(prefix)

    def __contains__(self, part: object) -> bool:
        return isinstance(part, bytes) and any(part in block for block in blocks(cast(bytes, self), 0, len(self)))

    def __getattr__(self, name: str) -> Any:
        return getattr(bytes(self), name)


def drop_pages(pages: mmap.mmap, start: int, stop: int) -> None:
    """Take the whole pages of a mapping out of the process's memory, where the system can."""
    first = start - start % mmap.PAGESIZE
    if stop > first and hasattr(mmap, "MADV_DONTNEED"):
        pages.madvise(mmap.MADV_DONTNEED, first, min(stop, len(pages)) - first)


def blocks(data: bytes, start: int, stop: int) -> Iterator[bytes]:
    """Yield `data[start:stop]` in blocks; of mapped bytes no more than one is in memory."""
    while start < stop:
        end = min(stop, start - start % BLOCK_BYTES + BLOCK_BYTES)
        yield data[start:end]
        release_bytes(data, start, end)
        start = end


def release_bytes(data: bytes, start: int, stop: int) -> None:
    """Drop `data[start:stop]` from memory where it is mapped."""
    found = mapped(data)
    if found is not None:
        drop_pages(found, start, stop)


def mapped(data: object) -> MappedBytes | None:
    """Return the bytes if they are those of a large file, which lie in a mapped file."""
    return data if isinstance(data, MappedBytes) else None


def read_and_hash(path: Path, folder: Path, largest_bytes: int) -> tuple[bytes, str]:
    """Return the bytes of a file and their SHA-256, read once; those of a large file are mapped in `folder`.

    Raises `OSError` where the file cannot be read or the copy not be written, `InputRefused` where it has more than
    `largest_bytes`.
    """
    with path.open("rb") as source:
        if os.fstat(source.fileno()).st_size > largest_bytes:
            raise _too_large(largest_bytes)
        first = source.read(min(LARGE_BYTES, largest_bytes) + 1)
        if len(first) > largest_bytes:
            raise _too_large(largest_bytes)
        if len(first) <= LARGE_BYTES:
            return first, hashlib.sha256(first).hexdigest()
        return map_and_hash(first, source, folder, largest_bytes)


def map_and_hash(first: bytes, source: IO[bytes], folder: Path, largest_bytes: int = sys.maxsize) -> tuple[bytes, str]:
    """Copy `first` and the rest of `source` into a temporary file of `folder`; return it mapped, and its SHA-256."""
    folder.mkdir(parents=True, exist_ok=True)
    digest = hashlib.sha256()
    n_bytes = 0
    with tempfile.TemporaryFile(dir=folder) as target:
        block = first or source.read(BLOCK_BYTES)
        while block:
            n_bytes += len(block)
            if n_bytes > largest_bytes:
                raise _too_large(largest_bytes)
            digest.update(block)
            if block.strip(b"\0"):
                target.write(block)
            else:  # of a file that was allocated beforehand, and takes no room
                target.seek(n_bytes)
            block = source.read(BLOCK_BYTES)
        target.truncate(n_bytes)
        return _map(target.fileno(), folder, n_bytes), digest.hexdigest()


def beginning(data: bytes, stop: int) -> bytes:
    """Return `data[:stop]`, mapped where `data` is."""
    found = mapped(data)
    return data[:stop] if found is None or stop == 0 else _map(found.descriptor, found.folder, stop)


def _map(descriptor: int, folder: Path, n_bytes: int) -> bytes:
    data = MappedBytes(descriptor, n_bytes, access=mmap.ACCESS_READ)
    data.folder, data.descriptor = folder, os.dup(descriptor)
    return cast(bytes, data)


def _too_large(largest_bytes: int) -> InputRefused:
    return InputRefused(
        f"The file has more than {largest_bytes} bytes (limit largest_file_bytes): split it, or raise that key of "
        "[files.limits] in labbook.toml."
    )


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
    """A column that is being put together, in a temporary file without a name, or without a `folder` in memory."""

    def __init__(self, folder: Path | None, dtype: np.dtype[Scalar]) -> None:
        self._folder, self._dtype = folder, dtype
        self._blocks: list[NDArray[Scalar]] = []
        self._file = None if folder is None else tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - closed by `finish`

    def append(self, values: NDArray[Scalar]) -> None:
        """Add rows, shape (n,)."""
        if self._file is None:
            self._blocks.append(values)
        else:
            self._file.write(np.ascontiguousarray(values, dtype=self._dtype).data)

    def finish(self) -> NDArray[Scalar]:
        """Return the column, shape (n_rows,), mapped where it is in a file; no row can be added after."""
        if self._file is None or self._folder is None:
            return self._blocks[0] if len(self._blocks) == 1 else np.concatenate(self._blocks)
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


def release(*columns: Array) -> None:
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
        release(values)


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
        release(values)
    return written.finish()


def _map_of(values: Array) -> _ColumnMap | None:
    base: object = values
    while isinstance(base, np.ndarray):
        base = base.base
    owner = base.obj if isinstance(base, memoryview) else base
    return owner if isinstance(owner, _ColumnMap) else None


def to_arrow(values: np.ndarray) -> pa.Array:
    """Return the values, shape (n,), as an Arrow array of float64 without a copy where they lie one after another."""
    import pyarrow as pa

    doubles = np.ascontiguousarray(values, dtype=np.float64)
    return pa.Array.from_buffers(pa.float64(), doubles.size, [None, pa.py_buffer(doubles)])


def to_numpy(column: pa.ChunkedArray) -> np.ndarray:
    """Return a column of numbers, shape (n,): whole ones of 64 bits as such, else as float64, NaN where one is missing.

    Raises `pyarrow.ArrowException` for a column of anything else.
    """
    import pyarrow as pa

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
