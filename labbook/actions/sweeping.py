"""What `labbook sim sweep` does: a scene, changed by words, simulated over a grid or a sample, to a file."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError
from simulator.changes import changed_by_words
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.sweep.cluster import connected
from simulator.sweep.design import Design, grid, sobol
from simulator.sweep.run import Finished, run_sweep
from simulator.sweep.sweep import Sweep
from simulator.sweep.threads import Threads
from simulator.sweep.words import axes_of, ranges_of


@dataclass(frozen=True, slots=True)
class SweepRequest:
    """A scene's name or file and the words that change it, what is swept, how accurately, and where to.

    `sample`: rows of a Sobol sample, drawn with `seed`; without it a grid. `scheduler`: the address of a Dask cluster.
    """

    scene: str
    over: tuple[str, ...]
    out: Path
    sets: tuple[str, ...] = ()
    effects: str | None = None
    accuracy: float = 1e-6
    sample: int | None = None
    seed: int | None = None
    scheduler: str | None = None


def planned_sweep(request: SweepRequest) -> Sweep:
    """Return the sweep that is asked for; raises `UsageError` where it has no meaning or cannot be simulated."""
    given = load_scene(request.scene)
    scene = changed_by_words(given, request.sets, request.effects)
    design = _design(request, scene)
    for axis in design.axes:
        if scene.values.get(axis.parameter) is not given.values.get(axis.parameter):
            raise UsageError(f"{axis.parameter} is both set and swept: leave out one of --set and --over.")
    return Sweep(scene, design, request.accuracy, importlib.metadata.version("robot-labbook"))


def _design(request: SweepRequest, scene: Scene) -> Design:
    if request.sample is not None:
        return sobol(ranges_of(request.over, scene.effects), request.sample, request.seed or 0)
    if request.seed is not None:
        raise UsageError("--seed draws a sample, and a grid has none: add --sobol COUNT, or leave --seed out.")
    return grid(axes_of(request.over, scene.effects))


def run_planned(sweep: Sweep, request: SweepRequest, advance: Callable[[int], None]) -> Finished:
    """Run a sweep, here or on the cluster asked for; `advance` is told how many more chunks are done."""
    if request.scheduler is None:
        return run_sweep(sweep, request.out, Threads(), advance)
    with connected(request.scheduler) as cluster:
        return run_sweep(sweep, request.out, cluster, advance)
