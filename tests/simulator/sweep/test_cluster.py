"""A sweep on a Dask cluster of two worker processes, one of which is killed."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import distributed

from simulator.sweep.computing import cluster, threads
from simulator.sweep.run import run_sweep
from tests.helpers.sweeps import every_byte, sobol_sweep


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
