"""Volume fractions of grains in flasks of several sizes, and their lines to a bed without walls (thesis fig. 5.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from reports.figures.style import BLUE, ONE_COLUMN_IN, VERMILLION, light_grid, new_figure, publication_style

_LOOKS = ((BLUE, "o", "-"), (VERMILLION, "s", "--"))


@dataclass(frozen=True, slots=True)
class FractionLine:
    """One state of the grains: measurements, the line with its band from 0 on, and the fraction at 0.

    `wall` is grain size over radius; band and interval are empty where the fit is exact.
    """

    label: str
    wall: Sequence[float]
    fractions: Sequence[float]
    line_wall: Sequence[float]
    line: Sequence[float]
    band: tuple[Sequence[float], Sequence[float]] | None
    at_0: float
    interval: tuple[float, float] | None


def draw_compaction(states: Sequence[FractionLine]) -> Figure:
    """Draw all measurements, the lines with their bands, and the fractions without walls."""
    with publication_style():
        figure = new_figure(ONE_COLUMN_IN, 2.8)
        axes = figure.add_subplot()
        for state, (colour, marker, style) in zip(states, _LOOKS, strict=True):
            if state.band is not None:
                axes.fill_between(state.line_wall, *state.band, color=colour, alpha=0.15, linewidth=0.0)
            axes.plot(state.line_wall, state.line, color=colour, linestyle=style)
            axes.plot(state.wall, state.fractions, marker, color=colour, markersize=3.5, label=state.label)
            ends = None if state.interval is None else [[abs(end - state.at_0)] for end in state.interval]
            axes.errorbar(
                [0.0], [state.at_0], yerr=ends, fmt="D", color=colour, markersize=4, capsize=3, clip_on=False, zorder=5
            )
        axes.set_xlim(left=0.0)
        axes.set_xlabel("Grain size / flask radius")
        axes.set_ylabel("Volume fraction")
        light_grid(axes)
        figure.legend(loc="outside lower center", ncols=2)
        return figure
