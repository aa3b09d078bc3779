"""Sweeps killed by the system (SIGKILL) and given again are those of an undisturbed one; and ten million jumps."""

from __future__ import annotations

import random
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray

from benchmarks.processes import run_process
from tests.cli.shell import LABBOOK, environment, good, labbook
from tests.helpers.figures import Count, record
from tests.helpers.sweeps import every_byte

KILLS, SOAK_KILLS = 1, 20


def words(rows: int, out: str) -> list[str]:
    over = ("--over", "b_ad=0:300", "--over", "foot_radius=0.02:0.04", "--sobol", str(rows), "--seed", "5")
    return ["sim", "sweep", "--scene", "sim2", *over, "--accuracy", "1e-4", "--out", out, "--json"]


def chunks_done(folder: Path) -> int:
    return len(list((folder / "killed.nc.part").glob("[0-9]*.npy")))


def killed(rows: int, folder: Path, moment: Callable[[], bool]) -> bool:
    """Start the sweep, or go on with it, and kill it at a moment; return whether it was not done by then."""
    command, quiet = [LABBOOK, *words(rows, "killed.nc")], subprocess.DEVNULL
    with subprocess.Popen(command, cwd=folder, env=environment(), stdin=quiet, stdout=quiet) as process:
        while process.poll() is None and not moment():
            time.sleep(0.001)
        process.kill()
    return process.returncode == -signal.SIGKILL


def assert_undisturbed(rows: int, folder: Path) -> int:
    """Give the command once more, compare with an undisturbed sweep; return the chunks that were there from before."""
    last = good(labbook(*words(rows, "killed.nc"), at=folder)).json
    assert every_byte(folder / "killed.nc") == every_byte(folder / "undisturbed.nc")
    assert {path.name for path in folder.iterdir()} == {"killed.nc", "undisturbed.nc"}
    before = last["chunks_before"]
    assert isinstance(before, int)
    return before


def test_killed_at_random_moments(tmp_path: Path) -> None:
    rows, chance = 8192, random.Random(11)
    good(labbook(*words(rows, "undisturbed.nc"), at=tmp_path))
    for _ in range(KILLS):
        wanted = chunks_done(tmp_path) + chance.randint(1, 12)
        assert killed(rows, tmp_path, lambda wanted=wanted: chunks_done(tmp_path) >= wanted)  # type: ignore[misc]
    assert assert_undisturbed(rows, tmp_path) >= KILLS


@pytest.mark.soak
def test_killed_at_twenty_random_moments(tmp_path: Path) -> None:
    rows, chance, kills, tried = 2**18, random.Random(12), 0, 0
    good(labbook(*words(rows, "undisturbed.nc"), at=tmp_path))
    while kills < SOAK_KILLS:
        end_s, tried = time.monotonic() + chance.uniform(0.0, 4.0), tried + 1
        if killed(rows, tmp_path, lambda end_s=end_s: time.monotonic() >= end_s):  # type: ignore[misc]
            kills += 1
        else:  # it was done before the moment came: begin anew
            (tmp_path / "killed.nc").unlink()
    assert_undisturbed(rows, tmp_path)
    record(Count("sim sweep", "kill", "files", tried=tried, cut_off=kills))


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
