"""The store of files: byte-exact raw copies and the channels read from them, both named by SHA-256.

A file is written under a temporary name, synced, renamed, and its folder synced, before any row refers to it. A crash
can leave a file without a row, never a row without its file. Nothing here deletes or moves a user's file. Every command
opens a store and few read or write in one, so numpy and pyarrow are loaded by those that do.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
import secrets
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from data_schema.disk import SPECIAL, is_special, make_folder, sync, sync_names
from data_schema.errors import BookDamaged

if TYPE_CHECKING:
    import numpy as np
    import pyarrow as pa

    from ingest.model import ChannelData, SignalPart

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


_RESTORE = "restore it from a backup, or ingest the original file again."
_READ_ANEW = "run `labbook rebuild` to read them anew from the raw copy."


@contextlib.contextmanager
def _damaged(what: str, remedy: str) -> Iterator[None]:
    """Raise `BookDamaged` for what the system or Arrow cannot read."""
    import pyarrow as pa

    try:
        yield
    except (OSError, ValueError, pa.ArrowException) as error:
        raise BookDamaged(f"{what} cannot be read ({error}): {remedy}") from error


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

        with (
            _damaged(f"the raw copy {store_path}", _RESTORE),
            pa.input_stream(self._file(store_path), compression="zstd") as stream,
        ):
            first = stream.read(LARGE_BYTES + 1)
            if len(first) > LARGE_BYTES:
                data, found = map_and_hash(first, stream, self.root)
            else:
                data, found = first, hashlib.sha256(first).hexdigest()
        if found != sha256:
            raise BookDamaged(f"the raw copy {store_path} was changed after it was kept: {_RESTORE}")
        return data

    def is_beginning(self, store_path: str, data: bytes) -> bool | None:
        """Tell which of a stored copy and other bytes begins with the other, reading no further than they are alike.

        True where `data` begins with the copy, a tail of NULs aside, which programs that allocate a file beforehand
        fill later; False where the copy begins with `data`; None where neither does. Raises `BookDamaged` when the copy
        cannot be read.
        """
        import pyarrow as pa

        place, block = 0, _FIRST_BYTES
        with (
            _damaged(f"the raw copy {store_path}", _RESTORE),
            pa.input_stream(self._file(store_path), compression="zstd") as stream,
        ):
            while piece := stream.read(block):
                beside = data[place : place + len(piece)]
                if piece != beside:
                    return _only_nul_differs(piece, beside, stream, place)
                place, block = place + len(piece), _MORE_BYTES
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
        """Read `time` and the named channels back; each an array of float64, shape (n_samples,).

        Raises `BookDamaged` when they are missing or a page is no longer what was written.
        """
        import pyarrow.parquet as pq

        from ingest.spool import to_numpy

        with (
            _damaged(f"the samples {store_path}", _READ_ANEW),
            pq.ParquetFile(self._file(store_path), page_checksum_verification=True) as source,
        ):
            columns = {name.rsplit(" [", 1)[0]: name for name in source.schema_arrow.names}
            wanted = {name: columns[name] for name in ("time", *channels) if name in columns}
            table = source.read(columns=list(wanted.values()))
        return {name: to_numpy(table.column(column)) for name, column in wanted.items()}

    def check_samples(self, store_path: str, sha256: str, of: str) -> None:
        """Read all stored samples of the file `of`, page by page with its checksum; raises `BookDamaged` where their
        hash is another.
        """
        import pyarrow.parquet as pq

        from ingest.spool import to_numpy

        what = f"the samples {store_path} of {of}"
        with (  # names of columns have no checksum
            _damaged(what, _READ_ANEW),
            pq.ParquetFile(self._file(store_path), page_checksum_verification=True) as source,
        ):
            first, *channels = names = source.schema_arrow.names
            if first != _TIME:
                raise ValueError(f"its first column is {first!r} and not {_TIME!r}")
            if source.num_row_groups == 1:  # ten times as quick as a column after the other
                table = source.read_row_group(0)
                found = _sha256(channels, (to_numpy(table.column(name)) for name in names))
            else:
                blocks = (
                    to_numpy(source.read_row_group(group, columns=[name]).column(name))
                    for name in names
                    for group in range(source.num_row_groups)
                )
                found = _sha256(channels, blocks)
        if found != sha256:
            raise BookDamaged(f"{what} are not those that were kept: {_READ_ANEW}")

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


_TIME = "time [s]"
"""The column that stands first."""
_PICKED = 1 << 12
_GROUP_ROWS = 1 << 20
"""Rows of a group of the Parquet file."""


def signal_sha256(part: SignalPart) -> str:
    """Hash the samples, whatever file they are stored in: channel names, units, then every value in order."""
    columns = (part.time_s, *(channel.values for channel in part.channels))
    return _sha256([_column_name(channel) for channel in part.channels], columns)


def write_samples(part: SignalPart, handle: pa.NativeFile) -> None:
    """Write each column in the encoding that suits it; measured in docs/performance.md."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from ingest.spool import release, to_arrow

    columns = {_TIME: part.time_s, **{_column_name(channel): channel.values for channel in part.channels}}
    steady = [name for name, values in columns.items() if _rises(values)]
    repeating = [name for name, values in columns.items() if name not in steady and _repeats(values)]
    with pq.ParquetWriter(
        handle,
        pa.schema([(name, pa.float64()) for name in columns]),
        compression="zstd",
        use_dictionary=repeating,
        use_byte_stream_split=steady,
        write_page_checksum=True,
    ) as writer:
        for start in range(0, max(1, part.time_s.size), _GROUP_ROWS):
            rows = slice(start, start + _GROUP_ROWS)
            writer.write_table(pa.table([to_arrow(values[rows]) for values in columns.values()], list(columns)))
            release(*columns.values())


def _sha256(names: Sequence[str], columns: Iterable[np.ndarray]) -> str:
    """Hash the names of the channels, then every value of the time and of the channels in order."""
    import numpy as np

    from ingest.spool import row_blocks

    digest = hashlib.sha256("\n".join(names).encode())
    for values in columns:
        for rows in row_blocks(values):
            digest.update(np.ascontiguousarray(values[rows], dtype="<f8").data)
    return digest.hexdigest()


def _column_name(channel: ChannelData) -> str:
    return f"{channel.name} [{channel.unit}]" if channel.unit else channel.name


def _rises(values: np.ndarray) -> bool:
    """Time and counters: their bytes, one stream each, hardly change from sample to sample."""
    from ingest.spool import release

    rising = values.size > 1 and bool((values[1:] > values[:-1]).all())
    release(values)
    return rising


def _repeats(values: np.ndarray) -> bool:
    """Tell whether a dictionary is shorter: held values, converter steps and few decimals come again.

    Where as many as half of all n values differ, m of them picked evenly hold about m^2 / n repeats.
    """
    import numpy as np

    from ingest.spool import release

    picked = values[:: max(1, values.size // _PICKED)].copy()
    release(values)
    share = picked.size / values.size if values.size else 1.0
    return np.unique(picked).size < picked.size * max(0.5, 1.0 - share)
