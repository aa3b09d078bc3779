"""Formats and clusters whose libraries are not there."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from data_schema.errors import UsageError
from simulator.sweep.computing import cluster, threads
from simulator.sweep.run import LIBRARIES, run_sweep
from tests.helpers.scenes import is_sentence
from tests.helpers.sweeps import grid_sweep
from tests.helpers.wording import refuses, says


@pytest.mark.parametrize(("kind", "library"), LIBRARIES.items())
def test_an_absent_library_is_named_before_anything_runs(
    kind: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(UsageError) as refused, threads() as computing:
        run_sweep(grid_sweep("b_ad=0,100"), tmp_path / f"out{kind}", computing)
    says(str(refused.value), "needs", library, "pip install 'robot-labbook[sweeps]'")
    assert is_sentence(str(refused.value))
    assert list(tmp_path.iterdir()) == []


def test_without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        refuses(UsageError, "--scheduler"),
        cluster("tcp://a:1"),
    ):
        pass


@pytest.mark.parametrize("address", ["nowhere", "tcp://127.0.0.1:9", "http//:"])
def test_a_scheduler_that_does_not_answer(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("simulator.sweep.computing.CONNECT_WITHIN_S", 0.5)
    with pytest.raises(UsageError) as refused, cluster(address):
        pass
    says(str(refused.value), "no Dask scheduler", address, "start one")
    assert is_sentence(str(refused.value))
