"""One simulated jump: heights of body and foot, the leg's force, and the contact modes as bands behind them."""

from __future__ import annotations

import textwrap

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.drawn import Trajectory
from reports.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    TWO_COLUMNS_IN,
    VERMILLION,
    light_grid,
    new_figure,
    publication_style,
)

MODE_COLOURS = {"intruding": ORANGE, "jammed": SKY, "creeping": PURPLE, "carried": GREEN}
"""Bands behind the lines, by mode; flight has none."""

_BAND_ALPHA = 0.25
_MARK_STYLES = ("--", "-.", ":")


def draw_trajectory(trajectory: Trajectory) -> Figure:
    """Draw the heights of body, foot and ground, and below them the leg's force, over time."""
    with publication_style():
        figure = new_figure(TWO_COLUMNS_IN, 4.4)
        heights, force = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        heights.set_title(textwrap.fill(trajectory.title, int(14 * TWO_COLUMNS_IN)), loc="left")
        for axes in (heights, force):
            _draw_bands(axes, trajectory)
            light_grid(axes)
        heights.plot(trajectory.time_s, trajectory.body_height_m, color=BLUE, label="body")
        heights.plot(trajectory.time_s, trajectory.foot_height_m, color=VERMILLION, label="foot")
        heights.plot(
            trajectory.time_s, trajectory.ground_height_m, color=GREY, linewidth=0.8, linestyle=":", label="ground"
        )
        heights.set_ylabel("Height (m)")
        force.plot(trajectory.time_s, trajectory.leg_force_n, color=BLACK, label="leg's push")
        force.axhline(0.0, color=GREY, linewidth=0.5)
        force.set_ylabel("Leg force (N)")
        force.set_xlabel("Time (s)")
        for axes in (heights, force):
            _draw_marks(axes, trajectory)
        handles: dict[str, Artist] = {}
        for axes in (heights, force):
            handles.update({str(name): handle for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)})
        figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=5)
        return figure


def _draw_bands(axes: Axes, trajectory: Trajectory) -> None:
    for mode, colour in MODE_COLOURS.items():
        for index, span in enumerate(span for span in trajectory.spans if span.mode == mode):
            label = "" if index else span.name
            axes.axvspan(span.start_s, span.end_s, color=colour, alpha=_BAND_ALPHA, linewidth=0, label=label, zorder=0)


def _draw_marks(axes: Axes, trajectory: Trajectory) -> None:
    for (name, at), style in zip(trajectory.marks, _MARK_STYLES, strict=False):
        axes.axvline(at, color=BLACK, linestyle=style, linewidth=0.8, label=name, zorder=1)
