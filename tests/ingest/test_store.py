"""The store gives back what it was given, whatever a column is like and however it is encoded for that."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from data_schema.errors import BookDamaged
from ingest.model import ChannelData, FloatArray, SignalPart
from ingest.store import FileInStore, Store, signal_sha256

N = 20_000


def part(*columns: FloatArray) -> SignalPart:
    """Channels c0, c1, ... at 300 Hz."""
    channels = tuple(
        ChannelData(f"c{number}", "m", "", None, 1.0, 0.0, 1, (), values) for number, values in enumerate(columns)
    )
    return SignalPart("log", np.arange(len(columns[0]) if columns else N) / 300, 300.0, None, None, channels, ())


@given(columns=st.integers(0, 200).flatmap(lambda n: st.lists(arrays(np.float64, n), min_size=1, max_size=4)))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_samples_come_back_bit_by_bit(tmp_path: Path, columns: list[FloatArray]) -> None:
    store, kept = Store(tmp_path), part(*columns)
    sha256, file = store.put_signal(kept)
    path = file.path
    found = store.samples(path, [channel.name for channel in kept.channels])
    assert list(found) == ["time", *(channel.name for channel in kept.channels)]
    for channel in kept.channels:
        assert found[channel.name].tobytes() == channel.values.tobytes()
    assert sha256 == signal_sha256(kept)
    store.check_samples(path, sha256, "log")
    assert store.has_samples(path, sha256, file.file_sha256)
    assert store.put_signal(kept) == (sha256, FileInStore(path, None))


@pytest.mark.parametrize(
    ("values", "most_bytes"),
    [
        (np.full(N, 400.0), 0.2),
        (np.arange(N) % 20 / 10, 1.0),
        (np.round(np.random.default_rng(1).normal(0.3, 0.001, N), 6), 4.0),
        (np.random.default_rng(1).normal(0.3, 0.001, N), 8.0),
    ],
    ids=["held", "coarse", "six decimals", "noise"],
)
def test_samples_take_the_space_of_what_they_say(tmp_path: Path, values: FloatArray, most_bytes: float) -> None:
    sizes = [
        (tmp_path / Store(tmp_path).put_signal(part(*columns))[1].path).stat().st_size for columns in ([], [values])
    ]
    assert sizes[1] - sizes[0] < most_bytes * N


def test_a_rebuild_writes_only_samples_that_are_not_whole(tmp_path: Path) -> None:
    store, kept = Store(tmp_path), part(np.arange(300.0))
    sha256, file = store.put_signal(kept)
    path = file.path
    inode = (tmp_path / path).stat().st_ino
    assert store.put_signal(kept, anew=True) == (sha256, file)
    assert (tmp_path / path).stat().st_ino == inode
    (tmp_path / path).chmod(0o644)
    (tmp_path / path).write_bytes((tmp_path / path).read_bytes()[:-20])
    assert not store.has_samples(path, sha256, file.file_sha256)
    assert store.put_signal(kept, anew=True) == (sha256, file)
    store.check_samples(path, sha256, "r001.csv")


@pytest.mark.parametrize("damage", ["another value", "another name", "time renamed", "cut", "missing"])
def test_samples_that_are_not_those_that_were_kept_are_told(tmp_path: Path, damage: str) -> None:
    store = Store(tmp_path)
    sha256, stored = store.put_signal(part(np.arange(300.0)))
    path = stored.path
    file = tmp_path / path
    content, table = file.read_bytes(), pq.read_table(file)
    file.unlink()
    if damage == "cut":
        file.write_bytes(content[:-20])
    elif damage == "another value":
        pq.write_table(table.set_column(1, "c0 [m]", [np.arange(1, 301.0)]), file)
    elif damage == "time renamed":
        pq.write_table(table.rename_columns(["times [s]", "c0 [m]"]), file)
    elif damage == "another name":
        pq.write_table(table.rename_columns(["time [s]", "c1 [m]"]), file)
    with pytest.raises(BookDamaged, match=r"r001\.csv.*rebuild"):
        store.check_samples(path, sha256, "r001.csv")
