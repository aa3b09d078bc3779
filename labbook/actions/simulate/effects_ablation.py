"""What `labbook sim effects` does: each effect of a scene left out, alone and in pairs, and the smallest set found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from data_schema.errors import UsageError
from simulator.ablation.kernel_time import KernelTime, kernel_time
from simulator.ablation.measure import Ablation, ablation_of_effects, measured_scene, sets_to_leave_out
from simulator.ablation.tolerance import tolerance_of
from simulator.changes import changed_by_words, without_auto
from simulator.scene import Scene
from simulator.scene_file import load_scene

Step = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class EffectsRequest:
    """A scene's name or file and the words that change it, the tolerance in words, the accuracy of each simulation.

    With `timings` a kernel is compiled for each effect that is left out; otherwise for the full scene and the smallest
    set only.
    """

    scene: str
    within: str
    sets: tuple[str, ...] = ()
    effects: str | None = None
    accuracy: float = 1e-6
    timings: bool = False


@dataclass(frozen=True, slots=True)
class EffectsTask:
    """A request that can be done, and the number of steps it takes."""

    scene: Scene
    tolerance: float
    accuracy: float
    timings: bool

    @property
    def sets(self) -> tuple[frozenset[str], ...]:
        """The effects that are left out, alone and in pairs."""
        return sets_to_leave_out(measured_scene(self.scene))

    @property
    def kernels(self) -> int:
        """Number of timed kernels: of the full scene, of the smallest set, and where asked for without each effect."""
        return 2 + (sum(len(left_out) == 1 for left_out in self.sets) if self.timings else 0)

    @property
    def steps(self) -> int:
        """Number of simulated sets and of timed kernels, the search counted as one."""
        return len(self.sets) + 1 + self.kernels


@dataclass(frozen=True, slots=True)
class MeasuredEffects:
    """What the effects are worth, and times of the compiled kernels: `times_without` each effect where asked for."""

    scene: Scene
    ablation: Ablation
    full_time: KernelTime
    smallest_time: KernelTime
    times_without: Mapping[str, KernelTime] = field(default_factory=dict)


def effects_task(request: EffectsRequest) -> EffectsTask:
    """Read a request; raises `UsageError` for what cannot be done."""
    words, auto = without_auto(request.effects)
    if auto:
        raise UsageError("sim effects finds the smallest set of effects itself: leave auto out of --effects.")
    tolerance = tolerance_of(request.within, request.accuracy)
    scene = changed_by_words(load_scene(request.scene), request.sets, words)
    return EffectsTask(scene, tolerance, request.accuracy, request.timings)


def measure_effects(task: EffectsTask, step: Step) -> MeasuredEffects:
    """Measure what the effects are worth; `step` is told of each of the task's steps when it is done."""
    ablation = ablation_of_effects(task.scene, task.tolerance, task.accuracy, step)

    def timed(left_out: tuple[str, ...], what: str) -> KernelTime:
        measured = kernel_time(ablation.scene.changed(effects_off=left_out), task.accuracy)
        step(f"time {what}")
        return measured

    full_time = timed((), "of the full scene")
    smallest_time = timed(ablation.smallest.left_out.effects, "of the smallest set")
    return MeasuredEffects(
        scene=task.scene,
        ablation=ablation,
        full_time=full_time,
        smallest_time=smallest_time,
        times_without={name: timed((name,), f"without {name}") for name in ablation.alone} if task.timings else {},
    )
