"""Trajectories of masses on a leg, and its stiffness and damping over the gains that were set (thesis fig. 4.5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from reports.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    TWO_COLUMNS_IN,
    VERMILLION,
    is_narrow,
    light_grid,
    new_figure,
    publication_style,
)

_COLOURS, _STYLES, _MARKERS = (VERMILLION, BLACK, BLUE, GREEN, ORANGE), ("-", "--", ":", "-."), "osD^v"
_ASIDE = 0.006
"""How far beside each other points of one gain stand, in the range of gains."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A mass on the leg: compressions in m and forces in N, as measured, and as fitted in order of time.

    `place` is that of its neutral length among those shown.
    """

    label: str
    place: int
    measured_m: NDArray[np.float64]
    measured_n: NDArray[np.float64]
    fitted_m: NDArray[np.float64]
    fitted_n: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class OverGain:
    """One neutral length: gains, masses in kg, coefficients with intervals, and the line's ends, if there is one.

    `filled` are the marks of coefficients from as many points as a condition needs.
    """

    label: str
    gains: Sequence[float]
    masses_kg: Sequence[float]
    values: Sequence[float]
    intervals: Sequence[tuple[float, float]]
    filled: Sequence[bool]
    line: tuple[tuple[float, float], tuple[float, float]] | None


def draw_characterisation(
    trajectories: Sequence[Trajectory],
    stiffness: Sequence[OverGain],
    damping: Sequence[OverGain],
    width_in: float = TWO_COLUMNS_IN,
) -> Figure:
    """Draw trajectories with their fits, stiffness over position gain, and damping over velocity gain."""
    masses = sorted(set(chain.from_iterable(one.masses_kg for one in stiffness)))
    with publication_style():
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 7.0 if narrow else 2.7)
        of_motion, *panels = figure.subplots(3, 1) if narrow else figure.subplots(1, 3)
        for one in trajectories:
            of_motion.plot(100.0 * one.measured_m, one.measured_n, ".", color=GREY, markersize=2)
            of_motion.plot(100.0 * one.fitted_m, one.fitted_n, color=_COLOURS[one.place % len(_COLOURS)], linewidth=0.9)
        of_motion.set_xlabel("Compression (cm)")
        of_motion.set_ylabel("Force of the leg (N)")
        of_motion.set_title(trajectories[0].label)
        light_grid(of_motion)
        labels = (("Position gain", "Stiffness (N/m)"), ("Velocity gain", "Damping (kg/s)"))
        for axes, series, (across, up) in zip(panels, (stiffness, damping), labels, strict=True):
            _draw_over_gain(axes, series, masses)
            axes.set_xlabel(across)
            axes.set_ylabel(up)
            axes.set_ylim(bottom=0.0)
            light_grid(axes)
        handles = [
            Line2D([], [], color=_COLOURS[place % len(_COLOURS)], ls=_STYLES[place % len(_STYLES)])
            for place in range(len(stiffness))
        ]
        names = [one.label for one in stiffness]
        handles += [Line2D([], [], color=GREY, marker=_marker(mass, masses), linestyle="") for mass in masses]
        names += [f"{mass:g} kg" for mass in masses]
        figure.legend(handles, names, loc="outside lower center", ncols=2 if narrow else 6)
        return figure


def _marker(mass_kg: float, masses: Sequence[float]) -> str:
    return _MARKERS[masses.index(mass_kg) % len(_MARKERS)]


def _draw_over_gain(axes: Axes, series: Sequence[OverGain], masses: Sequence[float]) -> None:
    """Draw each length's line, and the points of each mass beside each other."""
    widest = max((max(one.gains) for one in series if one.gains), default=1.0) or 1.0
    beside = len(series) * len(masses)
    for place, one in enumerate(series):
        colour = _COLOURS[place % len(_COLOURS)]
        points = zip(one.gains, one.masses_kg, one.values, one.intervals, one.filled, strict=True)
        for gain, mass, value, (low, high), filled in points:
            step = place * len(masses) + masses.index(mass) - 0.5 * (beside - 1)
            axes.errorbar(
                [gain + _ASIDE * widest * step],
                [value],
                yerr=[[value - low], [high - value]],
                fmt=_marker(mass, masses),
                color=colour,
                markerfacecolor=colour if filled else "white",
                markersize=3,
                capsize=1.5,
                zorder=3,
            )
        if one.line is not None:
            axes.plot(*one.line, color=colour, linestyle=_STYLES[place % len(_STYLES)], linewidth=0.9)
