"""The samples of one signal as they are stored: their hash, and one Parquet file with a column a channel."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from data_schema.errors import BookDamaged
from ingest.model import ChannelData, SignalPart
from ingest.spool import release, row_blocks, to_arrow, to_numpy

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


def read_samples(path: Path, channels: Sequence[str]) -> dict[str, np.ndarray]:
    """Read `time` and the named channels back; each an array of float64, shape (n_samples,).

    Raises `BookDamaged` when they are missing or a page is no longer what was written.
    """
    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as source:
            columns = {name.rsplit(" [", 1)[0]: name for name in source.schema_arrow.names}
            wanted = {name: columns[name] for name in ("time", *channels) if name in columns}
            table = source.read(columns=list(wanted.values()))
    except (OSError, pa.ArrowInvalid) as error:
        raise BookDamaged(
            f"the samples {path} cannot be read ({error}): run `labbook rebuild` to read them anew from the raw copy."
        ) from error
    return {name: to_numpy(table.column(column)) for name, column in wanted.items()}


def stored_sha256(path: Path) -> str:
    """Read all samples of a file, page by page with its checksum, and hash them as `signal_sha256` did.

    Raises `OSError`, `ValueError` or `pa.ArrowException` when they cannot be read.
    """
    with pq.ParquetFile(path, page_checksum_verification=True) as source:
        first, *channels = names = source.schema_arrow.names
        if first != _TIME:
            raise ValueError(f"its first column is {first!r} and not {_TIME!r}")
        if source.num_row_groups == 1:  # ten times as quick as a column after the other
            table = source.read_row_group(0)
            return _sha256(channels, (to_numpy(table.column(name)) for name in names))
        blocks = (
            to_numpy(source.read_row_group(group, columns=[name]).column(name))
            for name in names
            for group in range(source.num_row_groups)
        )
        return _sha256(channels, blocks)


def _sha256(names: Sequence[str], columns: Iterable[np.ndarray]) -> str:
    """Hash the names of the channels, then every value of the time and of the channels in order."""
    digest = hashlib.sha256("\n".join(names).encode())
    for values in columns:
        for rows in row_blocks(values):
            digest.update(np.ascontiguousarray(values[rows], dtype="<f8").data)
    return digest.hexdigest()


def _column_name(channel: ChannelData) -> str:
    return f"{channel.name} [{channel.unit}]" if channel.unit else channel.name


def _rises(values: np.ndarray) -> bool:
    """Time and counters: their bytes, one stream each, hardly change from sample to sample."""
    rising = values.size > 1 and bool(np.all(values[1:] > values[:-1]))
    release(values)
    return rising


def _repeats(values: np.ndarray) -> bool:
    """Tell whether a dictionary is shorter: held values, converter steps and few decimals come again.

    Where as many as half of all n values differ, m of them picked evenly hold about m^2 / n repeats.
    """
    picked = values[:: max(1, values.size // _PICKED)].copy()
    release(values)
    share = picked.size / values.size if values.size else 1.0
    return np.unique(picked).size < picked.size * max(0.5, 1.0 - share)
