"""A large file is read from a mapping in blocks, and gives what the same bytes give in memory; all are synthetic."""

from __future__ import annotations

import hashlib
import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from data_schema.errors import InputRefused
from ingest import spool
from ingest.model import Declarations, ReadFile
from ingest.read import read_file
from ingest.spool import map_and_hash, mapped, read_and_hash
from ingest.store import Store, signal_sha256
from ingest.tables import rows
from tests.ingest.bad_input import Case
from tests.ingest.synthetic import LOG_HEADER, bertec_acquire, icharger_rows, robot_rows, text, twenty_faults
from tests.ingest.test_bad_files import CASES, STUCK

SOME = [
    pytest.param(case, marks=pytest.mark.soak if place % 4 else ())
    for place, case in enumerate([*(case for case in CASES if case.data), Case("stuck logger", STUCK)])
]
"""Every fourth in a normal run."""


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks of a few hundred rows, so that a small file is read as a large one is."""
    monkeypatch.setattr(spool, "BLOCK_BYTES", 4096)
    monkeypatch.setattr(rows, "BLOCK_BYTES", 6000)
    monkeypatch.setattr(rows, "PIECE_BYTES", 900)
    monkeypatch.setattr(spool, "BLOCK_ROWS", 100)


def map_of(data: bytes, folder: Path) -> bytes:
    found, sha256 = map_and_hash(b"", io.BytesIO(data), folder)
    assert sha256 == hashlib.sha256(data).hexdigest()
    assert mapped(found) is not None
    return found


def assert_same(one: ReadFile, other: ReadFile) -> None:
    for name in ("format", "findings", "charges", "evidence", "rows_read", "rows_kept"):
        assert getattr(one, name) == getattr(other, name)
    for first, second in zip(one.parts, other.parts, strict=True):
        for name in ("part", "rate_hz", "gaps", "start_utc", "start_original"):
            assert getattr(first, name) == getattr(second, name)
        assert signal_sha256(first) == signal_sha256(second)


@pytest.mark.parametrize("case", SOME, ids=lambda case: case.name)
def test_a_mapped_file_reads_as_its_bytes_do(case: Case, tmp_path: Path) -> None:
    assert_same(read_file(map_of(case.data, tmp_path), Declarations()), read_file(case.data, Declarations()))
    assert list(tmp_path.iterdir()) == []  # nothing with a name, whatever ends the process


@pytest.mark.parametrize(
    "data",
    [bertec_acquire(plates=2), text("", icharger_rows()), twenty_faults()[0], twenty_faults()[0].replace(b"\n", b"\r")],
)
def test_every_reader_takes_a_mapped_file(data: bytes, tmp_path: Path) -> None:
    assert_same(read_file(map_of(data, tmp_path), Declarations()), read_file(data, Declarations()))


def test_a_file_beyond_the_bound_is_mapped_and_kept_byte_for_byte(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = text(LOG_HEADER, robot_rows(3000))
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    store = Store(tmp_path / "store")
    assert mapped(read_and_hash(path, tmp_path, len(data))[0]) is None
    with pytest.raises(InputRefused, match="largest_file_bytes"):
        read_and_hash(path, tmp_path, len(data) - 1)
    monkeypatch.setattr(spool, "LARGE_BYTES", 10_000)
    found, sha256 = store.read_and_hash(path, 10**9)
    assert mapped(found) is not None
    assert bytes(store.raw(store.put_raw(found, sha256).path, sha256)) == data
    (part,) = read_file(found, Declarations()).parts
    assert spool.folder_of(part.channels[0].values) == store.root
    _, kept = store.put_signal(part)
    (whole,) = read_file(data, Declarations()).parts
    for name, values in store.samples(kept.path, ["body_height", "leg_length"]).items():
        expected = whole.time_s if name == "time" else {c.name: c.values for c in whole.channels}[name]
        assert np.array_equal(values, expected)
    with pytest.raises(InputRefused, match="largest_file_bytes"):
        store.read_and_hash(path, 20_000)
    assert sorted(child.name for child in store.root.iterdir()) == ["raw", "signals"]


NULS = """
import re, sys
from pathlib import Path
from ingest.model import Declarations
from ingest.read import read_file
from ingest.spool import LARGE_BYTES, mapped, read_and_hash

path = Path(sys.argv[1])
data, _sha256 = read_and_hash(path, path.parent, 1 << 40)
assert mapped(data) is not None
assert read_file(data, Declarations()).refused
peak_kb = re.search(r"VmHWM:\\s*([0-9]+)", Path("/proc/self/status").read_text())
assert int(peak_kb[1]) << 10 < 2 * LARGE_BYTES, peak_kb[0]
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="tells how much memory a process had")
def test_a_file_of_nuls_that_takes_no_room_is_refused_in_constant_memory(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    with path.open("wb") as file:
        file.truncate(5 * spool.LARGE_BYTES)
    subprocess.run([sys.executable, "-c", NULS, path], check=True)
    with path.open("wb") as file:
        file.truncate(1 << 42)
    with pytest.raises(InputRefused, match="largest_file_bytes"):
        read_and_hash(path, tmp_path, 1 << 40)


@pytest.mark.parametrize("large", [10**9, 10_000], ids=["in memory", "mapped"])
def test_a_file_that_grows_or_is_replaced_meanwhile_is_read_as_it_was(
    large: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spool, "LARGE_BYTES", large)
    data = text(LOG_HEADER, robot_rows(3000))
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    found, sha256 = read_and_hash(path, tmp_path, 10**9)
    with path.open("ab") as growing:
        growing.write(data)
    path.write_bytes(b"other")
    assert bytes(found) == data
    assert sha256 == hashlib.sha256(data).hexdigest()
