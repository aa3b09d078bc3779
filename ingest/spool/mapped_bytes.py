"""The bytes of a large file in a mapped temporary file: read like `bytes`, and hardly any of them in memory at a time.

The file has no name, so that nothing of it is left however the process ends.
"""

from __future__ import annotations

import hashlib
import mmap
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, cast

from data_schema.errors import InputRefused

LARGE_BYTES = 1 << 27
"""A file larger than this is mapped; a smaller one is read into memory, which is quicker."""

BLOCK_BYTES = 1 << 20
"""A multiple of the size of a page."""


class MappedBytes(mmap.mmap):
    """Bytes that lie in a temporary file of `folder`; what `mmap` lacks of the methods of `bytes` works on a copy.

    Readers take it for `bytes`, so what makes one says `bytes` too; `mapped` tells them apart. `count` and `in` look
    for single bytes.
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
        longest = len(prefix) if isinstance(prefix, bytes) else max(map(len, prefix))
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
        let_go(data, start, end)
        start = end


def let_go(data: bytes, start: int, stop: int) -> None:
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
            target.write(block)
            block = source.read(BLOCK_BYTES)
        target.flush()
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
