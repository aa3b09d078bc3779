"""The time that a jump takes in the kernels compiled for sets of a scene's effects, and the time to compile them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from simulator.ablation.study import Ablation
from simulator.accuracy.labbook_runs import KernelRun
from simulator.scene import Scene

FEWEST_RUNS = 5
LONG_ENOUGH_S = 0.2


@dataclass(frozen=True, slots=True)
class KernelTime:
    """Time of a jump, the least of several runs.

    `compile_time_s` is short where the kernel was on disk already; not `compiled`: a kernel in plain Python.
    """

    time_per_jump_s: float
    compile_time_s: float
    runs: int
    compiled: bool


def kernel_time(scene: Scene, accuracy: float) -> KernelTime:
    """Run the scene's kernel repeatedly, at least five times, and time it without what surrounds it."""
    kernel = KernelRun(scene, accuracy)
    spent: list[float] = []
    while len(spent) < FEWEST_RUNS or sum(spent) < LONG_ENOUGH_S:
        started = time.perf_counter()
        kernel.run()
        spent.append(time.perf_counter() - started)
    return KernelTime(
        time_per_jump_s=min(spent) / max(kernel.jumps_made, 1),
        compile_time_s=kernel.kernel.compile_time_s,
        runs=len(spent),
        compiled=hasattr(kernel.kernel.batch, "compile"),
    )


@dataclass(frozen=True, slots=True)
class AblationTimes:
    """Times with all effects, with the smallest set, and where asked for without each effect that may go alone."""

    full: KernelTime
    smallest: KernelTime
    without: Mapping[str, KernelTime]


def ablation_times(ablation: Ablation, each: bool, step: Callable[[str], None]) -> AblationTimes:
    """Compile and time the kernels; `step` is called after each."""

    def timed(left_out: tuple[str, ...], what: str) -> KernelTime:
        measured = kernel_time(ablation.scene.changed(effects_off=left_out), ablation.accuracy)
        step(f"time {what}")
        return measured

    return AblationTimes(
        full=timed((), "of the full scene"),
        smallest=timed(ablation.smallest.left_out.effects, "of the smallest set"),
        without={name: timed((name,), f"without {name}") for name in ablation.alone} if each else {},
    )
