"""Figure 3.5 of the thesis: the mechanical energies of one jump, with the leg's virtual spring."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures.style import (
    BLACK,
    BLUE,
    PURPLE,
    TWO_COLUMNS_IN,
    VERMILLION,
    is_narrow,
    light_grid,
    new_figure,
    publication_style,
)
from reports.figures.thesis_style import AD_LOOK, CE_LOOK, mark_instant
from simulator.thesis.energies import JumpEnergies
from simulator.thesis.motions import Pair

CAPTION = (
    "Total mechanical energy of body, leg and foot (Eq. 3.3) during one stance, and its parts: kinetic, spring and "
    "gravitational energy of body and leg (dotted) and of foot and ground (solid). What pressing the ground has "
    "cost is lost at once and not part of the total. Grey lines: switch to the stiff leg, which puts energy into "
    "its spring, and lift-off."
)
_AFTER_LIFTOFF_S = 0.03
_LINE_WIDTH = 1.3


def draw_energies(energies: Pair[JumpEnergies], width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw either controller in a panel of its own, both on one scale."""
    with publication_style():
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 5.4 if narrow else 3.2)
        shape = (2, 1) if narrow else (1, 2)
        panels = figure.subplots(*shape, sharex=True, sharey=True)
        end_s = max(part.motion.liftoff_time_s for part in (energies.ce, energies.ad)) + _AFTER_LIFTOFF_S
        for axes, look, curves in zip(panels, (CE_LOOK, AD_LOOK), (energies.ce, energies.ad), strict=True):
            _draw_panel(axes, curves, end_s)
            axes.set_title(look.label[0].upper() + look.label[1:], loc="left")
            if axes is panels[-1] or not narrow:
                axes.set_xlabel("Time since touchdown (s)")
            if axes is panels[0] or narrow:
                axes.set_ylabel("Energy (J)")
        panels[0].set_xlim(0.0, end_s)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2 if narrow else 4, handlelength=2.6)
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
