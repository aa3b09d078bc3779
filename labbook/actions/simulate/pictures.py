"""Pictures that commands of the simulator draw where they are asked for: in which forms, and into which file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from simulator.result import SceneResult

ANIMATION_KINDS = (".gif",)


def save_plot(draw: Callable[[], Figure], path: Path) -> None:
    """Draw a figure in the style of papers and save it."""
    from reports.figures.style import publication_style

    with publication_style():
        draw().savefig(path)


def draw_motion(result: SceneResult, plot: Path | None, animation: Path | None) -> None:
    """Draw the trajectory of a result, and make a moving picture of it, where a file is given."""
    from labbook.presenting.simulation.trajectory import drawn_trajectory
    from reports.figures.jump_animation import write_animation
    from reports.figures.trajectory import draw_trajectory

    motion = drawn_trajectory(result)
    if plot is not None:
        save_plot(lambda: draw_trajectory(motion), plot)
    if animation is not None:
        write_animation(motion, animation)
