"""Measured stiffness and damping over the gains that were set, with their lines (thesis fig. 4.5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from reports.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    TWO_COLUMNS_IN,
    VERMILLION,
    is_narrow,
    light_grid,
    new_figure,
    publication_style,
)

_COLOURS, _MARKERS = (BLACK, BLUE, VERMILLION, GREEN, ORANGE), "os^vD"


@dataclass(frozen=True, slots=True)
class OverGain:
    """One neutral length: gains, coefficients with their intervals, and the line's ends, none where there is none."""

    label: str
    gains: Sequence[float]
    values: Sequence[float]
    intervals: Sequence[tuple[float, float]]
    line: tuple[tuple[float, float], tuple[float, float]] | None


def draw_characterisation(
    stiffness: Sequence[OverGain], damping: Sequence[OverGain], width_in: float = TWO_COLUMNS_IN
) -> Figure:
    """Draw stiffness over position gain and damping over velocity gain, side by side."""
    with publication_style():
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 4.8 if narrow else 2.7)
        panels = figure.subplots(2, 1) if narrow else figure.subplots(1, 2)
        labels = (("Position gain", "Stiffness (N/m)"), ("Velocity gain", "Damping (kg/s)"))
        for axes, series, (across, up) in zip(panels, (stiffness, damping), labels, strict=True):
            for place, one in enumerate(series):
                colour, marker = _COLOURS[place % len(_COLOURS)], _MARKERS[place % len(_MARKERS)]
                ends = [
                    [value - low for value, (low, _) in zip(one.values, one.intervals, strict=True)],
                    [high - value for value, (_, high) in zip(one.values, one.intervals, strict=True)],
                ]
                axes.errorbar(
                    one.gains,
                    one.values,
                    yerr=ends,
                    fmt=marker,
                    color=colour,
                    markersize=3.5,
                    capsize=2,
                    clip_on=False,  # a gain of 0 stands on the axis
                    zorder=3,
                    label=one.label,
                )
                if one.line is not None:
                    axes.plot(*one.line, color=colour, linewidth=0.9)
            axes.set_xlabel(across)
            axes.set_ylabel(up)
            axes.set_xlim(left=0.0)
            axes.set_ylim(bottom=0.0)
            light_grid(axes)
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=1 if narrow else 4)
        return figure
