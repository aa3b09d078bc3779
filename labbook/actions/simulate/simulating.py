"""What `labbook sim run` does: a scene, changed by words, simulated, drawn and animated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError
from labbook.actions.simulate.enough_effects import auto_of, with_enough
from simulator.ablation.measure import Ablation
from simulator.changes import changed_by_words
from simulator.jump import simulate
from simulator.result import SceneResult
from simulator.scene_file import load_scene

PLOT_KINDS = (".png", ".svg", ".pdf")
ANIMATION_KINDS = (".gif",)


@dataclass(frozen=True, slots=True)
class RunRequest:
    """A scene's name or file, the words that change it, the accuracy, and the pictures wanted.

    `within`: the tolerance, in words, for which `auto` among the effects finds the smallest set.
    """

    scene: str
    sets: tuple[str, ...] = ()
    effects: str | None = None
    accuracy: float = 1e-6
    plot: Path | None = None
    animation: Path | None = None
    within: str | None = None


@dataclass(frozen=True, slots=True)
class DoneRun:
    """What a run gave; `ablation` is that of the scene with all its effects, where the smallest set was asked for."""

    result: SceneResult
    ablation: Ablation | None = None


def run_scene(request: RunRequest, step: Callable[[str], None] = lambda _done: None) -> DoneRun:
    """Simulate a scene, and draw the pictures that are asked for; `step` is told of each set of effects tried."""
    for option, path, kinds in (
        ("--plot", request.plot, PLOT_KINDS),
        ("--animate", request.animation, ANIMATION_KINDS),
    ):
        if path is not None and path.suffix not in kinds:
            raise UsageError(f"{option} {path} does not say which form: end it in {', '.join(kinds)}.")
    auto = auto_of(request.effects, request.within, request.accuracy)
    full = changed_by_words(load_scene(request.scene), request.sets, auto.words)
    ablation = auto.ablation(full, step)
    drawn = request.plot is not None or request.animation is not None
    result = simulate(with_enough(full, ablation), request.accuracy, trajectory=drawn)
    if drawn:
        from labbook.presenting.simulation.trajectory import trajectory_of

        motion = trajectory_of(result)
        if request.plot is not None:
            from reports.figures.style import publication_style
            from reports.figures.trajectory import draw_trajectory

            with publication_style():
                draw_trajectory(motion).savefig(request.plot)
        if request.animation is not None:
            from reports.figures.jump_animation import write_animation

            write_animation(motion, request.animation)
    return DoneRun(result, ablation)
