"""Figure 3.13 of the thesis: the cost of a jump over active damping, for feet, extension gains and grounds."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from reports.display import general_text, stated_text
from reports.figures.series import LineStyle
from reports.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    TWO_COLUMNS_IN,
    VERMILLION,
    is_narrow,
    light_grid,
    new_figure,
    publication_style,
)
from reports.figures.thesis_style import MILLI
from simulator.thesis.comparisons import OverDamping

CAPTION = (
    "Cost of one jump over the coefficient of active damping (0: compression-extension, dots), for feet of three "
    "radii, a soft (dashed) and a stiff (solid) extension, and factors on the ground's stiffness (rows, softest "
    "above) and drag (columns)."
)
_FOOT_COLOURS = (BLUE, GREEN, VERMILLION)
_GAIN_STYLES: tuple[LineStyle, ...] = ("--", "-")


def draw_joules_by_damping(costs: OverDamping, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw a panel for each ground, all on one scale."""
    with publication_style():
        narrow = is_narrow(width_in)
        rows, columns = len(costs.stiffness_factors), len(costs.drag_factors)
        figure = new_figure(width_in, 4.6 if narrow else 5.2)
        grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for row, column in itertools.product(range(rows), range(columns)):
            axes = grid[row, column]
            for gain, foot in itertools.product(range(len(costs.extension_gains)), range(len(costs.foot_radii_m))):
                cost_j = costs.jumps.cost_j[row, column, gain, foot]
                colour = _FOOT_COLOURS[foot % len(_FOOT_COLOURS)]
                style = _GAIN_STYLES[gain % len(_GAIN_STYLES)]
                axes.plot(costs.active_damping_kg_m, cost_j, color=colour, linestyle=style)
                axes.plot(costs.active_damping_kg_m[0], cost_j[0], "o", color=colour, markersize=2.5, clip_on=False)
            stiffness = stated_text(costs.stiffness_factors[row])
            drag = stated_text(costs.drag_factors[column])
            axes.set_title(
                f"{stiffness} × K, {drag} × D" if narrow else f"stiffness × {stiffness}, drag × {drag}",
                loc="left",
                fontsize=6 if narrow else 7,
                fontweight="normal",
            )
            axes.set_xlim(0.0, float(costs.active_damping_kg_m[-1]))
            light_grid(axes)
        grid[0, 0].set_ylim(0.0, 1.05 * float(np.nanmax(costs.jumps.cost_j)))
        for axes in grid[:, 0]:
            axes.set_ylabel("Cost (J)")
        for axes in grid[-1]:
            axes.set_xlabel("b_AD (kg/m)")
        figure.legend(handles=_handles(costs), loc="outside lower center", ncols=2 if narrow else 5, handlelength=2.2)
        return figure


def _handles(costs: OverDamping) -> list[Line2D]:
    feet = [
        Line2D([], [], color=_FOOT_COLOURS[place % len(_FOOT_COLOURS)], label=f"foot radius {radius_m * MILLI:.0f} mm")
        for place, radius_m in enumerate(costs.foot_radii_m)
    ]
    gains = [
        Line2D(
            [],
            [],
            color=BLACK,
            linestyle=_GAIN_STYLES[place % len(_GAIN_STYLES)],
            label=f"gain {stated_text(gain)} ({general_text(stiffness)} N/m)",
        )
        for place, (gain, stiffness) in enumerate(
            zip(costs.extension_gains, costs.extension_stiffnesses_n_m, strict=True)
        )
    ]
    return [*feet, *gains]
