"""The store of files: byte-exact raw copies and the channels read from them, both named by SHA-256.

A file is written under a temporary name, synced, renamed, and its folder synced, before any row refers to it. A crash
can leave a file without a row, never a row without its file. Nothing here deletes or moves a user's file. Every command
opens a store and few read or write in one, so numpy and pyarrow are loaded by those that do.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from data_schema.disk import SPECIAL, is_special, make_folder, sync, sync_names
from data_schema.errors import BookDamaged

if TYPE_CHECKING:
    import numpy as np
    import pyarrow as pa

    from ingest.model import SignalPart

RAW_COMPRESSION_LEVEL = 1
"""Level 1 takes two thirds of the time of level 3, and its copies of logs are no larger (docs/performance.md)."""


_FIRST_BYTES, _MORE_BYTES = 1 << 12, 1 << 20
"""Logs of two runs differ within the first block; those that go on alike are read in larger ones."""

STORED = ("raw", "signals", "numbers")
"""The folders of a store: raw copies, samples, and the numbers of reports."""


_OWN = re.compile(
    r"(raw|signals)/([0-9a-f]{2})/(\2[0-9a-f]{62}\.(zst|parquet)|\.\2[0-9a-f]{62}\.(zst|parquet)\.[0-9a-f]{8})"
    r"|numbers/([0-9a-f]{64}\.json|\.[0-9a-f]{64}\.json(\.[0-9a-f]{8})?\.part)"
)


def is_store_name(path: str) -> bool:
    """Tell whether a path in a store is one that a store gives to its files, or to one that is being written."""
    return _OWN.fullmatch(path) is not None


def raw_path(sha256: str) -> str:
    """Return where a store keeps the bytes of a file."""
    return f"raw/{sha256[:2]}/{sha256}.zst"


@dataclass(frozen=True, slots=True)
class FileInStore:
    """A file of the store: its path there and, where this process wrote or verified it, the SHA-256 of its bytes.

    These are compressed: hashing them takes a tenth of the time that it takes to verify what they hold.
    """

    path: str
    file_sha256: str | None


@dataclass(frozen=True, slots=True)
class Store:
    """A folder with `raw/` and `signals/` in it; `of_links`: its files are links that labbook made to other files."""

    root: Path
    of_links: bool = False

    def put_raw(self, data: bytes, sha256: str) -> FileInStore:
        """Keep the bytes of a file. Keeping the same bytes again changes nothing."""
        import pyarrow as pa

        from ingest.spool import mapped

        path = raw_path(sha256)
        if self._is_there(path):
            self._sync_names(path)
            return FileInStore(path, None)
        if mapped(data) is not None:
            self._write(path, lambda handle: _compress_blocks(data, handle))
        else:
            compressed = pa.Codec("zstd", compression_level=RAW_COMPRESSION_LEVEL).compress(data)
            self._write(path, lambda handle: handle.write(memoryview(compressed)))
        return FileInStore(path, self.file_sha256(path))

    def read_and_hash(self, path: Path, largest_bytes: int) -> tuple[bytes, str]:
        """Return the bytes of any file and their SHA-256, read once; those of a large file are mapped, not in memory.

        Raises `OSError` where the file cannot be read, `InputRefused` where it has more than `largest_bytes`.
        """
        from ingest.spool import read_and_hash

        return read_and_hash(path, self.root, largest_bytes)

    def raw(self, store_path: str, sha256: str) -> bytes:
        """Return the stored bytes, mapped where they are many; raises `BookDamaged` when they are missing or differ
        from what was stored."""
        import pyarrow as pa

        from ingest.spool import LARGE_BYTES, map_and_hash

        try:
            with pa.input_stream(self._file(store_path), compression="zstd") as stream:
                first = stream.read(LARGE_BYTES + 1)
                if len(first) > LARGE_BYTES:
                    data, found = map_and_hash(first, stream, self.root)
                else:
                    data, found = first, hashlib.sha256(first).hexdigest()
        except (OSError, pa.ArrowInvalid) as error:
            raise BookDamaged(
                f"the raw copy {store_path} cannot be read ({error}): restore it from a backup, or ingest the original "
                "file again."
            ) from error
        if found != sha256:
            raise BookDamaged(
                f"the raw copy {store_path} was changed after it was kept: restore it from a backup, or ingest the "
                "original file again."
            )
        return data

    def is_beginning(self, store_path: str, data: bytes) -> bool | None:
        """Tell which of a stored copy and other bytes begins with the other, reading no further than they are alike.

        True where `data` begins with the copy, a tail of NULs aside, which programs that allocate a file beforehand
        fill later; False where the copy begins with `data`; None where neither does. Raises `BookDamaged` when the copy
        cannot be read.
        """
        import pyarrow as pa

        place, block = 0, _FIRST_BYTES
        try:
            with pa.input_stream(self._file(store_path), compression="zstd") as stream:
                while piece := stream.read(block):
                    beside = data[place : place + len(piece)]
                    if piece != beside:
                        return _only_nul_differs(piece, beside, stream, place)
                    place, block = place + len(piece), _MORE_BYTES
        except (OSError, pa.ArrowInvalid) as error:
            raise BookDamaged(
                f"the raw copy {store_path} cannot be read ({error}): restore it from a backup, or ingest the original "
                "file again."
            ) from error
        return True

    def restore_raw(self, data: bytes, sha256: str) -> bool:
        """Put back a raw copy that is missing or was changed; returns whether it had to be."""
        path = raw_path(sha256)
        try:
            self.raw(path, sha256)
        except BookDamaged:
            (self.root / path).unlink(missing_ok=True)
            self.put_raw(data, sha256)
            return True
        return False

    def put_signal(self, part: SignalPart, *, anew: bool = False) -> tuple[str, FileInStore]:
        """Keep the samples of one part; returns the SHA-256 of names, units and values, and the file.

        What is there already is left alone; with `anew` only where all of it can be read and has this hash.
        """
        from ingest.samples import signal_sha256, write_samples

        sha256 = signal_sha256(part)
        path = f"signals/{sha256[:2]}/{sha256}.parquet"
        if not (self.has_samples(path, sha256) if anew else self._is_there(path)):
            self._write(path, lambda handle: write_samples(part, handle))
            return sha256, FileInStore(path, self.file_sha256(path))
        sync(self.root / path)
        self._sync_names(path)
        return sha256, FileInStore(path, self.file_sha256(path) if anew else None)

    def file_sha256(self, path: str) -> str | None:
        """Return the SHA-256 of a file of the store as it lies there, None where it cannot be read."""
        try:
            with open(self._file(path), "rb") as stream:  # noqa: PTH123
                return hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError:
            return None

    def samples(self, store_path: str, channels: Sequence[str]) -> dict[str, np.ndarray]:
        """Read `time` and the named channels back; each an array of float64, shape (n_samples,)."""
        from ingest.samples import read_samples

        try:
            self._file(store_path)
        except OSError as error:
            raise BookDamaged(
                f"the samples {store_path} cannot be read ({error}): run `labbook rebuild` to read them "
                "anew from the raw copy."
            ) from error
        return read_samples(self.root / store_path, channels)

    def check_samples(self, store_path: str, sha256: str, of: str) -> None:
        """Read all stored samples of the file `of`; raises `BookDamaged` where their hash is another."""
        import pyarrow as pa

        from ingest.samples import stored_sha256

        remedy = "run `labbook rebuild` to read them anew from the raw copy."
        try:
            found = stored_sha256(Path(self._file(store_path)))
        except (OSError, ValueError, pa.ArrowException) as error:  # names of columns have no checksum
            raise BookDamaged(f"the samples {store_path} of {of} cannot be read ({error}): {remedy}") from error
        if found != sha256:
            raise BookDamaged(f"the samples {store_path} of {of} are not those that were kept: {remedy}")

    def is_as_verified(self, path: str, file_sha256: str | None) -> bool:
        """Tell whether a file of the store has the bytes that it had when what it holds was verified, if it was."""
        return file_sha256 is not None and self.file_sha256(path) == file_sha256

    def has_raw(self, sha256: str, file_sha256: str | None = None) -> bool:
        """Read the raw copy of these bytes; tells whether it has this hash, or its file that of a verified one."""
        if self.is_as_verified(raw_path(sha256), file_sha256):
            return True
        try:
            self.raw(raw_path(sha256), sha256)
        except BookDamaged:
            return False
        return True

    def has_samples(self, store_path: str, sha256: str, file_sha256: str | None = None) -> bool:
        """Read all stored samples; tells whether they have this hash, or their file that of a verified one."""
        if self.is_as_verified(store_path, file_sha256):
            return True
        try:
            self.check_samples(store_path, sha256, store_path)
        except BookDamaged:
            return False
        return True

    def _file(self, path: str) -> str:
        """Return where a file of the store lies; raises `OSError` where it is no file."""
        file = self.root / path
        if not self.of_links and is_special(file):
            raise OSError(errno.EINVAL, f"it {SPECIAL}", str(file))
        return str(file)

    def _is_there(self, path: str) -> bool:
        file = self.root / path
        return file.exists() and (self.of_links or not is_special(file))

    def _write(self, path: str, write: Callable[[pa.NativeFile], object]) -> None:
        import pyarrow as pa

        target = self.root / path
        make_folder(target.parent)
        temporary = target.with_name(f".{target.name}.{secrets.token_hex(4)}")
        try:
            with pa.OSFile(str(temporary), "wb") as handle:
                write(handle)
            descriptor = os.open(temporary, os.O_RDONLY)
            try:
                os.fchmod(descriptor, os.fstat(descriptor).st_mode & 0o444)
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
            temporary.rename(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        self._sync_names(path)

    def _sync_names(self, path: str) -> None:
        sync_names((self.root / path).parent, self.root)


def _only_nul_differs(piece: bytes, beside: bytes, stream: pa.NativeFile, place: int) -> bool | None:
    """Answer `Store.is_beginning` at the first piece of a copy, at `place`, that is not what the other bytes have."""
    if len(beside) < len(piece) and piece.startswith(beside):
        return False  # also where there is nothing left beside it
    written = piece.rstrip(b"\0")
    if place + len(written) == 0 or not beside.startswith(written):
        return None
    while more := stream.read(_MORE_BYTES):
        if more.strip(b"\0"):
            return None
    return True


def _compress_blocks(data: bytes, handle: pa.NativeFile) -> None:
    import pyarrow as pa

    from ingest.spool import blocks

    with pa.CompressedOutputStream(handle, "zstd") as stream:
        for block in blocks(data, 0, len(data)):
            stream.write(block)
