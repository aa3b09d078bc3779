"""Figure 3.6 of the thesis: the power that the ground takes from the foot (Eq. 3.4), and paths of the foot over it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from reports.figures.style import BLACK, GREY, TWO_COLUMNS_IN, is_narrow, new_figure, publication_style
from reports.figures.thesis_style import AD_LOOK, CE_LOOK, MILLI
from simulator.thesis.ground import PowerSurface
from simulator.thesis.motions import Motion

CAPTION = (
    "Power that the ground takes from the foot (Eq. 3.4) over the foot's depth and velocity, as a map: the darker, "
    "the more is lost. Paths of the foot from three initial velocities (circles) part at the switch to extension "
    "(dots), where compression-extension drives the foot down into the costly region. Each path ends at the "
    "velocity 0, at lift-off."
)
_LEVELS_W = (-800.0, -400.0, -200.0, -100.0, -50.0, -25.0, -10.0, -5.0, 0.0)


def draw_power_surface(power: PowerSurface, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw the map in greys with its contours, and the paths over it."""
    with publication_style():
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 3.3 if narrow else 3.8)
        axes = figure.add_subplot()
        greys = [str(shade) for shade in np.linspace(0.45, 1.0, len(_LEVELS_W) - 1)]
        depth_mm = power.depth_m * MILLI
        axes.contourf(depth_mm, power.velocity_m_s, power.power_w, levels=_LEVELS_W, colors=greys)
        lines = axes.contour(
            depth_mm, power.velocity_m_s, power.power_w, levels=_LEVELS_W[:-1], colors=GREY, linewidths=0.4
        )
        lines.set_linestyle("solid")
        axes.clabel(lines, fmt=lambda value: f"{value:.0f} W".replace("-", "−"), fontsize=6, colors=BLACK)
        for pair in power.motions:
            for look, path in ((CE_LOOK, pair.ce), (AD_LOOK, pair.ad)):
                stance = path.time_s <= path.liftoff_time_s
                axes.plot(
                    -path.foot_height_m[stance] * MILLI,
                    path.foot_velocity_m_s[stance],
                    color=look.colour,
                    linestyle=look.line_style,
                    linewidth=1.4,
                )
            _mark_path(axes, pair.ce)
        axes.set_xlim(0.0, float(depth_mm[-1]))
        axes.set_ylim(float(power.velocity_m_s[0]), 0.02)
        axes.set_xlabel("Depth of the foot (mm)")
        axes.set_ylabel("Velocity of the foot (m/s)")
        handles = [
            *(
                Line2D([], [], color=look.colour, linestyle=look.line_style, linewidth=1.4, label=look.label)
                for look in (CE_LOOK, AD_LOOK)
            ),
            Line2D([], [], color=BLACK, marker="o", markerfacecolor="white", linestyle="none", label="touchdown"),
            Line2D([], [], color=BLACK, marker="o", markersize=3.5, linestyle="none", label="switch to extension"),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=2 if narrow else 4, handlelength=3.0)
        return figure


def _mark_path(axes: Axes, path: Motion) -> None:
    switch = int((path.time_s >= path.switch_time_s).argmax())
    axes.plot(
        -path.foot_height_m[0] * MILLI,
        path.foot_velocity_m_s[0],
        "o",
        color=BLACK,
        markerfacecolor="white",
        clip_on=False,
        zorder=5,
    )
    axes.plot(
        -path.foot_height_m[switch] * MILLI, path.foot_velocity_m_s[switch], "o", color=BLACK, markersize=3.5, zorder=5
    )
