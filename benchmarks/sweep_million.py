"""A million jumps in one sweep: time, memory, and whether a jump costs the same in small and large sweeps."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.processes import LABBOOK, run_process
from benchmarks.section import Benchmark, Budget, Section, Table
from benchmarks.timing import Work, in_turns
from simulator.scene_file import load_scene
from simulator.sweep.chunks import recipe_for, simulate_rows
from simulator.sweep.design import sobol

TITLE = "A sweep of a million jumps"
ACCURACY = 1e-4
REPEATS = {1_000: 5, 10_000: 3, 100_000: 2, 1_000_000: 1}
"""Sweeps of so many jumps, and how often each is run."""
MILLION_S, MILLION_MB = 12.0, 2000.0
IN_TURNS, TURNS, LANES_FASTER = 8192, 6, 1.8
"""Jumps that both kernels simulate in turns on one thread, how often, and how much faster lanes should be."""
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
    run_process([LABBOOK, "sim", "warm", "sim2", "--lanes"])
    sweep(1)
    taken: dict[int, Taken] = {}
    for jumps, repeats in REPEATS.items():
        say(f"{jumps} jumps, {repeats} times")
        taken[jumps] = min((sweep(jumps) for _ in range(repeats)), key=lambda found: found.jump_us)
    million = taken[max(taken)]
    say("both kernels in turns")
    beside = {goal: _kernels(goal) for goal in (1e-4, 1e-6)}
    first, last = taken[min(taken)], million
    return Section(
        TITLE,
        f"`labbook sim sweep --scene sim2 {' '.join(_OVER)} --sobol COUNT --accuracy {ACCURACY:g} --out sweep.nc`, a "
        f"whole process on {os.cpu_count()} cores: chunks to disk with a sync each, then a NetCDF file of every number "
        "that a jump gives. The kernels were compiled before; from 10000 jumps on they are in lanes.",
        (
            Budget("a million jumps, from start to exit", MILLION_S, "s", million.wall_s),
            Budget("their peak memory", MILLION_MB, "MB", million.peak_mb, why="no /proc here"),
            *(
                Budget(f"processor time of a jump at {goal:g}, scalar over lanes (min)", LANES_FASTER, "×", ratio, True)
                for goal, (_, _, ratio) in beside.items()
            ),
        ),
        (
            Table(
                ("jumps", "process, s", "peak, MB", "simulating and keeping, µs a jump", "the file, µs a jump", "MB"),
                tuple(_row(jumps, found) for jumps, found in taken.items()),
                f"A jump in the largest sweep costs {last.jump_us / first.jump_us:.2f} times one in the smallest, for "
                "which starting the threads and syncing the chunks is a part of the time. Memory does not hold the "
                "results: chunks go to disk as they are done, and to the file a few outputs at a time; what grows is "
                "the sample itself, 8 bytes a jump and parameter.",
            ),
            Table(
                ("accuracy", "scalar kernel, µs a jump", "in lanes, µs a jump", "ratio"),
                tuple((f"{goal:g}", *map(_short, found)) for goal, found in beside.items()),
                f"Least processor time of one thread for {IN_TURNS} of these jumps, {TURNS} times in turns, "
                "to the same bits. Counted once: of the 148 steps of such a jump at 1e-4 (226 at 1e-6) 130 (204) are "
                "taken in lanes, the others with nine events by the scalar kernel.",
            ),
        ),
    )


def _kernels(accuracy: float) -> tuple[float, float, float]:
    """Return the processor time of a jump in µs, with the scalar kernel and in lanes, and their ratio."""
    scene = load_scene("sim2")
    design = sobol(_OVER[1::2], scene.effects, IN_TURNS, 0)
    recipe = recipe_for(scene, design, accuracy)
    values = design.rows(0, IN_TURNS)
    scalar, lanes = replace(recipe, why_scalar="asked"), replace(recipe, why_scalar=None)
    if not np.array_equal(simulate_rows(scalar, values), simulate_rows(lanes, values), equal_nan=True):
        raise AssertionError("lanes and the scalar kernel differ")
    recipes = {"scalar": scalar, "lanes": lanes}
    works = {name: Work(partial(simulate_rows, of), lambda: values) for name, of in recipes.items()}
    slow, quick = (found.cpu_minimum / IN_TURNS * 1e6 for found in in_turns(works, TURNS).values())
    return slow, quick, slow / quick


def _short(value: float) -> str:
    return f"{value:.3g}"


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
    return str(jumps), _short(found.wall_s), peak, *map(_short, (found.jump_us, found.write_us, found.file_mb))


BENCHMARK = Benchmark("sweep_million", measure)
