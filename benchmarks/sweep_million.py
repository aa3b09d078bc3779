"""A million jumps in one sweep: time, memory, and whether a jump costs the same in small and large sweeps."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.processes import LABBOOK, run_process
from benchmarks.section import Benchmark, Budget, Section, Table

TITLE = "A sweep of a million jumps"
ACCURACY = 1e-4
REPEATS = {1_000: 5, 10_000: 3, 100_000: 2, 1_000_000: 1}
"""Sweeps of so many jumps, and how often each is run."""
MILLION_S, MILLION_MB = 60.0, 2000.0
_OVER = ("--over", "b_ad=0:300", "--over", "foot_radius=0.02:0.04")


@dataclass(frozen=True, slots=True)
class Taken:
    """What a sweep took: the whole process, and a jump without start and compiling."""

    wall_s: float
    peak_mb: float | None
    jump_us: float
    write_us: float
    file_mb: float


def measure(say: Callable[[str], None]) -> Section:
    """Run sweeps of every size, each a process of its own; the kernel is compiled and on disk before."""
    say("compiling")
    sweep(1)
    taken: dict[int, Taken] = {}
    for jumps, repeats in REPEATS.items():
        say(f"{jumps} jumps, {repeats} times")
        taken[jumps] = min((sweep(jumps) for _ in range(repeats)), key=lambda found: found.jump_us)
    million = taken[max(taken)]
    first, last = taken[min(taken)], million
    return Section(
        TITLE,
        f"`labbook sim sweep --scene sim2 {' '.join(_OVER)} --sobol COUNT --accuracy {ACCURACY:g} --out sweep.nc`, a "
        f"whole process on {os.cpu_count()} cores: chunks to disk with a sync each, then a NetCDF file of every number "
        "that a jump gives. The kernel was compiled before.",
        (
            Budget("a million jumps, from start to exit", MILLION_S, "s", million.wall_s),
            Budget(
                "their peak memory",
                MILLION_MB,
                "MB",
                million.peak_mb,
                why="no /proc here" if not million.peak_mb else "",
            ),
        ),
        (
            Table(
                ("jumps", "process, s", "peak, MB", "simulating and keeping, µs a jump", "the file, µs a jump", "MB"),
                tuple(_row(jumps, found) for jumps, found in taken.items()),
                f"A jump in the largest sweep costs {last.jump_us / first.jump_us:.2f} times one in the smallest, for "
                "which starting the threads and syncing the chunks is a part of the time. Memory does not hold the "
                "results: chunks go to disk as they are done, and to the file output by output; what grows is the "
                "sample itself, 8 bytes a jump and parameter.",
            ),
        ),
    )


def sweep(jumps: int) -> Taken:
    """Run one sweep of so many jumps as a process of its own."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        out = Path(name) / "sweep.nc"
        words = ("sim", "sweep", "--scene", "sim2", *_OVER, "--sobol", str(jumps), "--accuracy", f"{ACCURACY:g}")
        run = run_process([LABBOOK, *words, "--out", out, "--json"])
        found = json.loads(run.output)
        return Taken(
            run.wall_s,
            run.peak_mb,
            1e6 * found["compute_time_s"] / jumps,
            1e6 * found["write_time_s"] / jumps,
            out.stat().st_size / 1e6,
        )


def _row(jumps: int, found: Taken) -> tuple[str, ...]:
    peak = "-" if found.peak_mb is None else f"{found.peak_mb:.0f}"
    times = (f"{found.jump_us:.3g}", f"{found.write_us:.3g}")
    return (f"{jumps}", f"{found.wall_s:.3g}", peak, *times, f"{found.file_mb:.3g}")


BENCHMARK = Benchmark("sweep_million", measure)
