"""Ten million jumps: bounded memory, and every jump in the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray

from benchmarks.processes import run_process
from tests.cli.shell import LABBOOK

JUMPS = 10_000_000
MOST_MB = 2000.0


@pytest.mark.soak
def test_ten_million_jumps_in_bounded_memory(tmp_path: Path) -> None:
    over = ("--over", "b_ad=0:300", "--over", "foot_radius=0.02:0.04")
    words = ("sim", "sweep", "--scene", "sim2", *over, "--sobol", f"{JUMPS}", "--accuracy", "1e-1")
    done = run_process([LABBOOK, *words, "--out", tmp_path / "sweep.nc"])
    assert done.peak_mb is None or done.peak_mb < MOST_MB
    with xarray.open_dataset(tmp_path / "sweep.nc") as dataset:
        assert dict(dataset.sizes) == {"sample": JUMPS}
        assert np.isfinite(dataset["cost_J"].values).all()
