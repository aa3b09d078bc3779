"""Figures 3.2 and 3.4 to 3.6 of the thesis: the ground, and one jump with either controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from reports.figures.style import BLACK, BLUE, GREY, PURPLE, VERMILLION, legend_below, light_grid, paper_figure
from simulator.thesis.figures import GroundFunctions, JumpEnergies, Motion, Pair, PowerSurface

MILLI = 1e3
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class ControllerLook:
    """How one controller is drawn in every figure of ch. 3: distinguished by colour and by dashes."""

    label: str
    colour: str
    line_style: Literal["-", "--"]

    @property
    def line(self) -> dict[str, Any]:
        """How its lines are drawn."""
        return {"color": self.colour, "linestyle": self.line_style}


CE_LOOK = ControllerLook("compression-extension (CE)", VERMILLION, "--")
AD_LOOK = ControllerLook("active damping (AD)", BLUE, "-")


def with_looks(pair: Pair[T]) -> tuple[tuple[ControllerLook, T], tuple[ControllerLook, T]]:
    """Return what belongs to either controller with how that is drawn."""
    return (CE_LOOK, pair.ce), (AD_LOOK, pair.ad)


def mark_instant(axes: Axes, time_s: float, words: str = "") -> None:
    """Draw a thin line at an instant; words stand beside it, at the top."""
    axes.axvline(time_s, color=GREY, linewidth=0.6, zorder=1)
    if words:
        axes.annotate(
            words,
            (time_s, 1.0),
            xycoords=axes.get_xaxis_transform(),
            xytext=(-2, -2),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="top",
            fontsize=6,
            color=GREY,
        )


GROUND_FUNCTIONS_CAPTION = (
    "Stiffness function K, inertial drag D and added mass of the simulated grains over the depth of the foot. The "
    "dotted line is where the cone of grains under the foot is complete: from there on K is linear and D constant."
)


def draw_ground_functions(curves: GroundFunctions) -> Figure:
    """Draw the three functions side by side."""
    panels = (
        ("Stiffness function", "K (N)", curves.resistance_n),
        ("Inertial drag", "D (kg/m)", curves.drag_kg_m),
        ("Added mass", "Added mass (g)", curves.added_mass_kg * MILLI),
    )
    with paper_figure(2.1) as figure:
        grid = figure.subplots(1, 3)
        for axes, (title, label, values) in zip(grid, panels, strict=True):
            axes.plot(curves.depth_m * MILLI, values, color=BLACK)
            axes.axvline(curves.cone_depth_m * MILLI, color=GREY, linewidth=0.8, linestyle=":")
            axes.set_title(title, loc="left")
            axes.set_ylabel(label)
            axes.set_xlim(0.0, float(curves.depth_m[-1]) * MILLI)
            axes.set_ylim(bottom=0.0)
            light_grid(axes)
            axes.set_xlabel("Depth (mm)")
        grid[0].annotate(
            "cone complete",
            (curves.cone_depth_m * MILLI, 0.04),
            xycoords=grid[0].get_xaxis_transform(),
            xytext=(4, 0),
            textcoords="offset points",
            fontsize=7,
            color=GREY,
        )
        return figure


BODY_AND_TOE_CAPTION = (
    "Body and toe of one jump. Both controllers are one until the leg switches to its stiff extension; then "
    "compression-extension drives the toe further into the ground than active damping does. Heights are above the "
    "undisturbed ground; dots mark lift-off. After it the toe may dip by up to a millimetre below the print that it "
    "has left: the leg's soft gains press it down for an instant, and contact is looked for only once it has risen."
)


def draw_body_and_toe(paths: Pair[Motion]) -> Figure:
    """Draw the body's height above, the toe's below, over one time."""
    with paper_figure(3.6) as figure:
        body, toe = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        end_s = max(float(path.time_s[-1]) for path in (paths.ce, paths.ad))
        for look, path in with_looks(paths):
            body.plot(path.time_s, path.body_height_m * MILLI, label=look.label, **look.line)
            toe.plot(path.time_s, path.foot_height_m * MILLI, **look.line)
            left = int((path.time_s >= path.liftoff_time_s).argmax())
            for axes, heights in ((body, path.body_height_m), (toe, path.foot_height_m)):
                axes.plot(
                    path.time_s[left], heights[left] * MILLI, "o", color=look.colour, markersize=3.5, clip_on=False
                )
        toe.axhline(0.0, color=GREY, linewidth=0.5)
        for axes, words in ((body, "switch to extension"), (toe, "")):
            mark_instant(axes, paths.ce.switch_time_s, words)
            axes.set_xlim(0.0, end_s)
            light_grid(axes)
        body.set_ylabel("Body (mm)")
        toe.set_ylabel("Toe (mm)")
        toe.set_xlabel("Time since touchdown (s)")
        figure.align_ylabels([body, toe])
        legend_below(figure, [body], 2, handlelength=3.2)
        return figure


ENERGIES_CAPTION = (
    "Total mechanical energy of body, leg and foot (Eq. 3.3) during one stance, and its parts: kinetic, spring and "
    "gravitational energy of body and leg (dotted) and of foot and ground (solid). What pressing the ground has "
    "cost is lost at once and not part of the total. Grey lines: switch to the stiff leg, which puts energy into "
    "its spring, and lift-off."
)
_AFTER_LIFTOFF_S = 0.03
_LINE_WIDTH = 1.3


def draw_energies(energies: Pair[JumpEnergies]) -> Figure:
    """Draw either controller in a panel of its own, both on one scale."""
    with paper_figure(3.2) as figure:
        panels = figure.subplots(1, 2, sharex=True, sharey=True)
        end_s = max(part.motion.liftoff_time_s for part in (energies.ce, energies.ad)) + _AFTER_LIFTOFF_S
        for axes, (look, curves) in zip(panels, with_looks(energies), strict=True):
            _draw_panel(axes, curves, end_s)
            axes.set_title(look.label[0].upper() + look.label[1:], loc="left")
            axes.set_xlabel("Time since touchdown (s)")
        panels[0].set_ylabel("Energy (J)")
        panels[0].set_xlim(0.0, end_s)
        legend_below(figure, panels, 4, handlelength=2.6)
        return figure


def _draw_panel(axes: Axes, curves: JumpEnergies, end_s: float) -> None:
    motion = curves.motion
    shown = motion.time_s <= end_s
    lines = (
        ("total", curves.total_j, BLACK, "-"),
        ("leg spring", curves.leg_spring_j, PURPLE, ":"),
        ("body, kinetic", curves.body_kinetic_j, VERMILLION, ":"),
        ("body, gravitational", curves.body_gravity_j, BLUE, ":"),
        ("pressing the ground", curves.ground_spring_j, PURPLE, "-"),
        ("foot, kinetic", curves.foot_kinetic_j, VERMILLION, "-"),
        ("foot, gravitational", curves.foot_gravity_j, BLUE, "-"),
    )
    for label, values, colour, style in lines:
        axes.plot(
            motion.time_s[shown], values[shown], color=colour, linestyle=style, linewidth=_LINE_WIDTH, label=label
        )
    mark_instant(axes, motion.switch_time_s, "switch to extension")
    mark_instant(axes, motion.liftoff_time_s, "lift-off")
    light_grid(axes)


POWER_SURFACE_CAPTION = (
    "Power that the ground takes from the foot (Eq. 3.4) over the foot's depth and velocity, as a map: the darker, "
    "the more is lost. Paths of the foot from three initial velocities (circles) part at the switch to extension "
    "(dots), where compression-extension drives the foot down into the costly region. Each path ends at the "
    "velocity 0, at lift-off."
)
_LEVELS_W = (-800.0, -400.0, -200.0, -100.0, -50.0, -25.0, -10.0, -5.0, 0.0)


def draw_power_surface(power: PowerSurface) -> Figure:
    """Draw the map in greys with its contours, and the paths over it."""
    with paper_figure(3.8) as figure:
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
            for look, path in with_looks(pair):
                stance = path.time_s <= path.liftoff_time_s
                axes.plot(
                    -path.foot_height_m[stance] * MILLI,
                    path.foot_velocity_m_s[stance],
                    linewidth=1.4,
                    **look.line,
                )
            _mark_path(axes, pair.ce)
        axes.set_xlim(0.0, float(depth_mm[-1]))
        axes.set_ylim(float(power.velocity_m_s[0]), 0.02)
        axes.set_xlabel("Depth of the foot (mm)")
        axes.set_ylabel("Velocity of the foot (m/s)")
        handles = [
            *(Line2D([], [], linewidth=1.4, label=look.label, **look.line) for look in (CE_LOOK, AD_LOOK)),
            Line2D([], [], color=BLACK, marker="o", markerfacecolor="white", linestyle="none", label="touchdown"),
            Line2D([], [], color=BLACK, marker="o", markersize=3.5, linestyle="none", label="switch to extension"),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=4, handlelength=3.0)
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
