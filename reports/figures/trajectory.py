"""One simulated jump: heights of body and foot, the leg's force, and the contact modes as bands behind them."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from data_schema.errors import UsageError
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
    legend_below,
    light_grid,
    paper_figure,
)
from simulator.kernel.layout import FLIGHT, MODES
from simulator.parameter import GRAVITY_M_S2
from simulator.result import JumpResult, SceneResult
from simulator.scene import Scene

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

MODE_COLOURS = {"intruding": ORANGE, "jammed": SKY, "creeping": PURPLE, "carried": GREEN}
"""Bands behind the lines, by mode; flight has none."""

_BAND_ALPHA = 0.25
_MARK_STYLES = ("--", "-.")


def draw_trajectory(result: SceneResult, title: str, mode_name: Callable[[str], str]) -> Figure:
    """Draw the last jump of a scene: heights of body, foot and ground, and below them the leg's force, over time.

    `mode_name` says what a contact mode is called on its ground. The force is that on the body, from its acceleration;
    where the rail rubs, that is in it. Raises `UsageError` where no motion was recorded.
    """
    if result.trajectory is None:
        raise UsageError(f"the motion of scene {result.scene.name} was not kept: simulate it with its trajectory.")
    scene, motion = result.scene, result.trajectory
    last = motion["jump"].to_numpy() == motion["jump"].to_numpy().max(initial=0)
    time_s, body_m, foot_m, acceleration_m_s2, modes = (
        motion[name].to_numpy()[last] for name in ("time", "body_height", "foot_height", "body_acceleration", "mode")
    )
    ground_m = _ground_m(scene, foot_m, modes == FLIGHT)
    with paper_figure(4.4) as figure:
        heights, force = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        heights.set_title(textwrap.fill(title, int(14 * TWO_COLUMNS_IN)), loc="left")
        for axes in (heights, force):
            _draw_bands(axes, time_s, modes, mode_name)
            light_grid(axes)
        heights.plot(time_s, body_m, color=BLUE, label="body")
        heights.plot(time_s, foot_m, color=VERMILLION, label="foot")
        heights.plot(time_s, ground_m, color=GREY, linewidth=0.8, linestyle=":", label="ground")
        if "hydrostatic_stiffness" in scene.effects:
            heights.axhline(0.0, color=GREY, linewidth=0.5, label="surface")
        heights.set_ylabel("Height (m)")
        push_n = scene["body_mass"] * (acceleration_m_s2 + GRAVITY_M_S2)
        force.plot(time_s, push_n, color=BLACK, label="leg's push")
        force.axhline(0.0, color=GREY, linewidth=0.5)
        force.set_ylabel("Leg force (N)")
        force.set_xlabel("Time (s)")
        for axes in (heights, force):
            _draw_marks(axes, result.jump)
        legend_below(figure, (heights, force), 5)
        return figure


def _draw_bands(axes: Axes, time_s: FloatArray, modes: IntArray, mode_name: Callable[[str], str]) -> None:
    edges = [0, *(np.flatnonzero(np.diff(modes)) + 1).tolist(), len(modes) - 1]
    named = set[str]()
    for first, last in pairwise(edges):
        mode = MODES[int(modes[first])]
        if mode in MODE_COLOURS and time_s[last] > time_s[first]:
            label = "" if mode in named else mode_name(mode)
            named.add(mode)
            colour = MODE_COLOURS[mode]
            axes.axvspan(
                time_s[first], time_s[last], color=colour, alpha=_BAND_ALPHA, linewidth=0, label=label, zorder=0
            )


def _draw_marks(axes: Axes, jump: JumpResult) -> None:
    marks = {"lift-off": jump.liftoff_time_s, "apex": jump.apex_time_s}
    for (name, after_s), style in zip(marks.items(), _MARK_STYLES, strict=True):
        if after_s is not None:
            at_s = jump.touchdown_time_s + after_s
            axes.axvline(at_s, color=BLACK, linestyle=style, linewidth=0.8, label=name, zorder=1)


def _ground_m(scene: Scene, foot_m: FloatArray, flight: NDArray[np.bool_]) -> FloatArray:
    """Height of the ground under the foot.

    A rigid ground stays at 0, grains keep the hollow that the foot has pressed. The emulator's platform bears the foot,
    and is up again in flight.
    """
    if "rigid_ground" in scene.effects:
        return np.zeros_like(foot_m)
    if "emulated_ground" not in scene.effects:
        return np.asarray(np.minimum.accumulate(np.minimum(foot_m, 0.0)))
    return np.where(flight, 0.0, foot_m)
