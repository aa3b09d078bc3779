"""The store of files: byte-exact raw copies and the channels read from them, both named by SHA-256.

A file is written under a temporary name, synced, renamed, and its folder synced, before any row says that it exists.
A crash can leave a file without a row, never a row without its file. Nothing here deletes or moves a user's file.
"""

from __future__ import annotations

import hashlib
import os
import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from data_schema.errors import BookDamaged
from ingest.model import ChannelData, SignalPart

RAW_COMPRESSION_LEVEL = 1
"""Level 1 takes two thirds of the time of level 3, and its copies of logs are no larger (docs/performance.md)."""
_PICKED = 1 << 12


@dataclass(frozen=True, slots=True)
class Store:
    """A folder with `raw/` and `signals/` in it."""

    root: Path

    def put_raw(self, data: bytes, sha256: str) -> str:
        """Keep the bytes of a file; returns the path in the store. Keeping the same bytes again changes nothing."""
        path = f"raw/{sha256[:2]}/{sha256}.zst"
        if not (self.root / path).exists():
            compressed = pa.Codec("zstd", compression_level=RAW_COMPRESSION_LEVEL).compress(data)
            self._write(path, lambda handle: handle.write(memoryview(compressed)))
        return path

    def raw(self, store_path: str, sha256: str) -> bytes:
        """Return the kept bytes; raises `BookDamaged` when they are missing or no longer what was kept."""
        try:
            with pa.input_stream(str(self.root / store_path), compression="zstd") as stream:
                data: bytes = stream.read()
        except (OSError, pa.ArrowInvalid) as error:
            raise BookDamaged(
                f"the raw copy {store_path} cannot be read ({error}): restore it from a backup, or ingest the original "
                "file again."
            ) from error
        if hashlib.sha256(data).hexdigest() != sha256:
            raise BookDamaged(
                f"the raw copy {store_path} was changed after it was kept: restore it from a backup, or remove it and "
                "ingest the original file again."
            )
        return data

    def restore_raw(self, data: bytes, sha256: str) -> bool:
        """Put back a raw copy that is missing or was changed; returns whether it had to be."""
        path = f"raw/{sha256[:2]}/{sha256}.zst"
        try:
            self.raw(path, sha256)
        except BookDamaged:
            (self.root / path).unlink(missing_ok=True)
            self.put_raw(data, sha256)
            return True
        return False

    def put_signal(self, part: SignalPart, *, anew: bool = False) -> tuple[str, str]:
        """Keep the samples of one part; returns (SHA-256 of names, units and values, path in the store).

        What is there already is left alone, unless it is to be written `anew` because it may be damaged.
        """
        sha256 = signal_sha256(part)
        path = f"signals/{sha256[:2]}/{sha256}.parquet"
        if anew or not (self.root / path).exists():
            self._write(path, lambda handle: write_samples(part, handle))
        return sha256, path

    def samples(self, store_path: str, channels: Sequence[str]) -> dict[str, np.ndarray]:
        """Read `time` and the named channels back; each an array of float64, shape (n_samples,)."""
        try:
            with pq.ParquetFile(self.root / store_path, page_checksum_verification=True) as source:
                columns = {name.rsplit(" [", 1)[0]: name for name in source.schema_arrow.names}
                wanted = {name: columns[name] for name in ("time", *channels) if name in columns}
                table = source.read(columns=list(wanted.values()))
        except (OSError, pa.ArrowInvalid) as error:
            raise BookDamaged(
                f"the samples {store_path} cannot be read ({error}): run `labbook rebuild` to read them anew from the "
                "raw copy."
            ) from error
        return {name: table.column(column).to_numpy() for name, column in wanted.items()}

    def _write(self, path: str, write: Callable[[pa.NativeFile], object]) -> None:
        target = self.root / path
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = target.with_name(f".{target.name}.{secrets.token_hex(4)}")
        try:
            with pa.OSFile(str(temporary), "wb") as handle:
                write(handle)
            descriptor = os.open(temporary, os.O_RDONLY)
            try:
                os.fchmod(descriptor, 0o444)
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
            temporary.rename(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        sync_folder(target.parent)


def sync_folder(folder: Path) -> None:
    """Make a rename in `folder` survive a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def signal_sha256(part: SignalPart) -> str:
    """Hash what was sampled, whatever file it is kept in: channel names, units, then every value in order."""
    digest = hashlib.sha256("\n".join(_column_name(channel) for channel in part.channels).encode())
    for values in (part.time_s, *(channel.values for channel in part.channels)):
        digest.update(np.ascontiguousarray(values, dtype="<f8").data)
    return digest.hexdigest()


def _column_name(channel: ChannelData) -> str:
    return f"{channel.name} [{channel.unit}]" if channel.unit else channel.name


def write_samples(part: SignalPart, handle: pa.NativeFile) -> None:
    """Write each column in the encoding that suits it; measured in docs/performance.md."""
    columns = {"time [s]": part.time_s, **{_column_name(channel): channel.values for channel in part.channels}}
    steady = [name for name, values in columns.items() if _rises(values)]
    pq.write_table(
        pa.table(columns),
        handle,
        compression="zstd",
        use_dictionary=[name for name, values in columns.items() if name not in steady and _repeats(values)],
        use_byte_stream_split=steady,
        write_page_checksum=True,
    )


def _rises(values: np.ndarray) -> bool:
    """Time and counters: their bytes, one stream each, hardly change from sample to sample."""
    return values.size > 1 and bool(np.all(values[1:] > values[:-1]))


def _repeats(values: np.ndarray) -> bool:
    """Tell whether a dictionary is shorter: held values, converter steps and few decimals come again.

    Where as many as half of all n values differ, m of them picked evenly hold about m^2 / n repeats.
    """
    picked = values[:: max(1, values.size // _PICKED)]
    share = picked.size / values.size if values.size else 1.0
    return np.unique(picked).size < picked.size * max(0.5, 1.0 - share)
