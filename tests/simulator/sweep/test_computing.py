"""A Dask cluster that loses a worker, schedulers that do not answer, and libraries that are not there."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from typing import Any

import distributed
import pytest

from data_schema.errors import UsageError
from simulator.sweep.run import LIBRARIES, cluster, run_sweep, threads
from tests.helpers.scenes import is_sentence
from tests.helpers.sweeps import every_byte, grid_sweep, sobol_sweep
from tests.helpers.wording import refuses, says


def test_a_lost_worker_costs_nothing_but_time(tmp_path: Path) -> None:
    sweep = sobol_sweep(2048)
    with threads() as computing:
        here = run_sweep(sweep, tmp_path / "here.nc", computing)
    done_jumps = 0
    start: Any = distributed.LocalCluster
    with start(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as local:
        victim = next(iter(local.workers.values())).pid

        def advance(jumps: int) -> None:
            nonlocal done_jumps
            done_jumps += jumps
            if done_jumps == 5 * 128:
                os.kill(victim, signal.SIGKILL)

        with cluster(local.scheduler_address) as computing:
            there = run_sweep(sweep, tmp_path / "cluster.nc", computing, advance)
    assert done_jumps == 2048
    assert len(sweep.chunks) == 16
    assert there.summary == here.summary
    assert every_byte(tmp_path / "cluster.nc") == every_byte(tmp_path / "here.nc")


@pytest.mark.parametrize(("kind", "library"), [*LIBRARIES.items(), ("--scheduler", "distributed")])
def test_an_absent_library_is_named_before_anything_runs(
    kind: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    computing = cluster("tcp://a:1") if kind == "--scheduler" else threads()
    said = ("needs", library, "pip install 'robot-labbook[sweeps]'")
    with refuses(UsageError, *said) as refused, computing as found:
        run_sweep(grid_sweep("b_ad=0,100"), tmp_path / f"out{kind}", found)
    assert is_sentence(str(refused.value))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("address", ["nowhere", "tcp://127.0.0.1:9", "http//:"])
def test_a_scheduler_that_does_not_answer(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("simulator.sweep.run.CONNECT_WITHIN_S", 0.5)
    with pytest.raises(UsageError) as refused, cluster(address):
        pass
    says(str(refused.value), "no Dask scheduler", address, "start one")
    assert is_sentence(str(refused.value))
