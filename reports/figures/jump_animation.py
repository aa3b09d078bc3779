"""A simulated jump as a moving picture: body, five-bar leg, foot and the ground under it, slowed down."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path

import numpy as np
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from reports.drawn import FloatArray, LegDrawing, Trajectory
from reports.figures.style import BLACK, BLUE, GREY, PALE, VERMILLION, new_figure, publication_style

FRAMES_PER_SECOND = 25
MOST_FRAMES = 250
_SLOWEST = 5.0
_WIDTH_IN, _HEIGHT_IN, _DOTS_PER_IN = 2.8, 4.2, 100
_TITLE_LETTERS, _TITLE_LINE_IN = 44, 0.14
"""Letters of the title in a line, and the height that each of its lines adds to the picture."""
_BODY_WIDTH_M, _BODY_HEIGHT_M = 0.12, 0.05
_HALF_WIDTH_M = 0.22


def frame_times(trajectory: Trajectory) -> tuple[FloatArray, float]:
    """Return the frames' times, s, evenly spaced, and how many times slower than life they play.

    A short jump plays five times slower; a long motion faster, so that there are at most `MOST_FRAMES`.
    """
    start, end = float(trajectory.time_s[0]), float(trajectory.time_s[-1])
    slower = min(_SLOWEST, MOST_FRAMES / (FRAMES_PER_SECOND * max(end - start, 1e-9)))
    n_frames = max(2, min(MOST_FRAMES, math.ceil((end - start) * slower * FRAMES_PER_SECOND)))
    return np.linspace(start, end, n_frames), slower


def knee_m(leg: LegDrawing, body_height_m: float, foot_height_m: float) -> tuple[float, float]:
    """Return the right knee's distance from the rail and its height, m; the law of cosines at the hip.

    A leg longer than its links reach, which a flight may ask for, is drawn straight, one shorter folded.
    """
    length_m = max(body_height_m - foot_height_m, 1e-9)
    upper, lower = leg.upper_link_m, leg.lower_link_m
    cosine = min(1.0, max(-1.0, (upper**2 - lower**2 + length_m**2) / (2.0 * upper * length_m)))
    return upper * math.sqrt(1.0 - cosine**2), body_height_m - upper * cosine


def write_animation(trajectory: Trajectory, path: Path) -> None:
    """Write the motion as an animated GIF, under the title of its plot.

    `path` ends in .gif; an existing file is replaced.
    """
    times, slower = frame_times(trajectory)
    body, foot, ground = (
        np.interp(times, trajectory.time_s, heights)
        for heights in (trajectory.body_height_m, trajectory.foot_height_m, trajectory.ground_height_m)
    )
    with publication_style():
        title = textwrap.wrap(trajectory.title, _TITLE_LETTERS)
        figure = new_figure(_WIDTH_IN, _HEIGHT_IN + _TITLE_LINE_IN * len(title))
        figure.suptitle("\n".join(title), fontsize=7, fontweight="bold", x=0.02, ha="left")
        axes = figure.subplots()
        picture = _Picture(axes, trajectory, body)
        axes.set_title(" ", loc="left")
        figure.draw_without_rendering()
        figure.set_layout_engine(None)  # laid out once: the frames stand still, and are drawn ten times as fast
        pace = f"{slower:.2g} times slower" if slower > 1.0 else f"{1.0 / slower:.2g} times faster"
        writer = PillowWriter(fps=FRAMES_PER_SECOND)
        with writer.saving(figure, str(path), dpi=_DOTS_PER_IN):
            for time_s, body_m, foot_m, ground_m in zip(times, body, foot, ground, strict=True):
                picture.show(float(body_m), float(foot_m), float(ground_m))
                axes.set_title(f"{time_s:.3f} s, {pace}", loc="left", fontweight="normal")
                writer.grab_frame()


class _Picture:
    """The parts of the picture that move."""

    def __init__(self, axes: Axes, trajectory: Trajectory, body_height_m: FloatArray) -> None:
        self.leg = trajectory.leg
        lowest = min(float(trajectory.ground_height_m.min()), float(trajectory.foot_height_m.min())) - 0.06
        axes.set_xlim(-_HALF_WIDTH_M, _HALF_WIDTH_M)
        axes.set_ylim(lowest, float(body_height_m.max()) + 0.08)
        axes.set_aspect("equal")
        axes.set_xticks([])
        axes.set_ylabel("Height (m)")
        far = 10.0
        axes.axvline(0.0, color=GREY, linewidth=0.5, zorder=2.5)
        axes.add_patch(Rectangle((-far, -far), 2 * far, far, color=PALE, linewidth=0, zorder=1))
        self.hollow = Rectangle((0.0, 0.0), 0.0, 0.0, color="white", linewidth=0, zorder=2)
        axes.add_patch(self.hollow)
        (self.links,) = axes.plot([], [], color=BLACK, linewidth=1.8, marker="o", markersize=3, zorder=4)
        self.body = Rectangle((0.0, 0.0), _BODY_WIDTH_M, _BODY_HEIGHT_M, color=BLUE, zorder=3)
        axes.add_patch(self.body)
        (self.foot,) = axes.plot([], [], color=VERMILLION, linewidth=3.0, solid_capstyle="butt", zorder=5)

    def show(self, body_m: float, foot_m: float, ground_m: float) -> None:
        """Move everything to these heights."""
        out, up = knee_m(self.leg, body_m, foot_m)
        self.links.set_data([0.0, out, 0.0, -out, 0.0], [body_m, up, foot_m, up, body_m])
        self.body.set_xy((-_BODY_WIDTH_M / 2, body_m - _BODY_HEIGHT_M / 2))
        radius = self.leg.foot_radius_m
        self.foot.set_data([-radius, radius], [foot_m, foot_m])
        self.hollow.set_bounds(-radius, min(ground_m, 0.0), 2 * radius, max(-ground_m, 0.0))
