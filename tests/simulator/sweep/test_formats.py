"""Formats and clusters whose libraries are not there, and the blocks of a Zarr folder."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from data_schema.errors import UsageError
from simulator.sweep.compute import Threads, connect_cluster, cores
from simulator.sweep.result_file import BLOCK, FORMATS, block_shape, format_of
from simulator.sweep.run import run_sweep
from tests.helpers.scenes import is_sentence
from tests.helpers.sweeps import grid_sweep
from tests.helpers.wording import refuses, says


@pytest.mark.parametrize("kind", FORMATS)
def test_an_absent_library_is_named_before_anything_runs(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = format_of(Path(f"out{kind}")).library
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(UsageError) as refused:
        run_sweep(grid_sweep("b_ad=0,100"), tmp_path / f"out{kind}", Threads())
    says(str(refused.value), "needs", library, "pip install 'robot-labbook[sweeps]'")
    assert is_sentence(str(refused.value))
    assert list(tmp_path.iterdir()) == []


def test_without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        refuses(UsageError, "--scheduler"),
        connect_cluster("tcp://a:1"),
    ):
        pass


@pytest.mark.parametrize("address", ["nowhere", "tcp://127.0.0.1:9", "http//:"])
def test_a_scheduler_that_does_not_answer(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("simulator.sweep.compute.CONNECT_WITHIN_S", 0.5)
    with pytest.raises(UsageError) as refused, connect_cluster(address):
        pass
    says(str(refused.value), "no Dask scheduler", address, "start one")
    assert is_sentence(str(refused.value))


def test_one_thread_a_core() -> None:
    assert Threads().count == cores() >= 1
    assert Threads(3).count == 3


def test_a_long_axis_is_divided() -> None:
    assert block_shape((10_000_000, 2)) == (BLOCK // 2, 2)
    assert block_shape((5, 100_000)) == (1, BLOCK)
    assert block_shape((31, 3)) == (31, 3)
