"""What `labbook sim run` does: a scene, changed by words, simulated, drawn and animated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError
from simulator.changes import changed_by_words, without_auto
from simulator.jump import simulate
from simulator.result import SceneResult
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.worth.measure import Worth, worth_of_effects
from simulator.worth.tolerance import tolerance_of

PLOT_KINDS = (".png", ".svg", ".pdf")
ANIMATION_KINDS = (".gif",)
SEARCH_ACCURACY = 1e-6
"""The finest accuracy at which the smallest set is searched; the scene is then simulated to the one asked for."""


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
    """What a run gave; `worth` is that of the scene with all its effects, where the smallest set was asked for."""

    result: SceneResult
    worth: Worth | None = None


def run_scene(request: RunRequest, step: Callable[[str], None] = lambda _done: None) -> DoneRun:
    """Simulate a scene, and draw the pictures that are asked for; `step` is told of each set of effects tried."""
    for option, path, kinds in (
        ("--plot", request.plot, PLOT_KINDS),
        ("--animate", request.animation, ANIMATION_KINDS),
    ):
        if path is not None and path.suffix not in kinds:
            raise UsageError(f"{option} {path} does not say which form: end it in {', '.join(kinds)}.")
    scene, worth = _scene(request, step)
    drawn = request.plot is not None or request.animation is not None
    result = simulate(scene, request.accuracy, trajectory=drawn)
    if drawn:
        from labbook.presenting.trajectory import trajectory_of

        motion = trajectory_of(result)
        if request.plot is not None:
            from reports.figures.style import publication_style
            from reports.figures.trajectory import draw_trajectory

            with publication_style():
                draw_trajectory(motion).savefig(request.plot)
        if request.animation is not None:
            from reports.figures.jump_animation import write_animation

            write_animation(motion, request.animation)
    return DoneRun(result, worth)


def _scene(request: RunRequest, step: Callable[[str], None]) -> tuple[Scene, Worth | None]:
    """Return the scene to simulate, and what its effects are worth where some are to be left out."""
    given = load_scene(request.scene)
    if request.within is None:
        return changed_by_words(given, request.sets, request.effects), None
    words, auto = without_auto(request.effects)
    if not auto:
        raise UsageError(f"--within {request.within} is for effects left out by themselves: add --effects auto.")
    accuracy = request.accuracy if request.accuracy > SEARCH_ACCURACY else SEARCH_ACCURACY
    tolerance = tolerance_of(request.within, accuracy)
    scene = changed_by_words(given, request.sets, words)
    worth = worth_of_effects(scene, tolerance, accuracy, step)
    return scene.changed(effects_off=worth.smallest.left_out.effects), worth
