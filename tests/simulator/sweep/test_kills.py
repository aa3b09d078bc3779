"""Sweeps killed by the system (SIGKILL) and given again: the file is that of an undisturbed one."""

from __future__ import annotations

import contextlib
import random
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.cli.shell import LABBOOK, environment, good, labbook
from tests.helpers.sweeps import every_byte

KILLS, SOAK_KILLS = 1, 20


def words(rows: int, out: str) -> list[str]:
    over = ("--over", "b_ad=0:300", "--over", "foot_radius=0.02:0.04", "--sobol", str(rows), "--seed", "5")
    return ["sim", "sweep", "--scene", "sim2", *over, "--accuracy", "1e-4", "--out", out, "--json"]


def chunks_done(folder: Path) -> int:
    return len(list((folder / "killed.nc.part").glob("[0-9]*.npy")))


@contextlib.contextmanager
def at_work(rows: int, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    quiet = subprocess.DEVNULL
    with subprocess.Popen(
        [LABBOOK, *words(rows, "killed.nc")], cwd=folder, env=environment(), stdin=quiet, stdout=quiet
    ) as process:
        yield process


def more_chunks(folder: Path, count: int) -> Callable[[], bool]:
    """The moment at which so many more chunks are done."""
    wanted = chunks_done(folder) + count
    return lambda: chunks_done(folder) >= wanted


def later(seconds: float) -> Callable[[], bool]:
    """The moment after so many seconds."""
    end = time.monotonic() + seconds
    return lambda: time.monotonic() >= end


def killed(rows: int, folder: Path, moment: Callable[[], bool]) -> bool:
    """Start the sweep, or go on with it, and kill it at a moment; return whether it was not done by then."""
    with at_work(rows, folder) as process:
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
        assert killed(rows, tmp_path, more_chunks(tmp_path, chance.randint(1, 12)))
    assert assert_undisturbed(rows, tmp_path) >= KILLS


@pytest.mark.soak
def test_killed_at_twenty_random_moments(tmp_path: Path) -> None:
    rows, chance, kills = 2**18, random.Random(12), 0
    good(labbook(*words(rows, "undisturbed.nc"), at=tmp_path))
    while kills < SOAK_KILLS:
        if killed(rows, tmp_path, later(chance.uniform(0.0, 4.0))):
            kills += 1
        else:  # it was done before the moment came: begin anew
            (tmp_path / "killed.nc").unlink()
    assert_undisturbed(rows, tmp_path)
