"""Hops on a force plate: aligned traces, estimated over measured joules, and the window (thesis fig. 3.7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
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

_COLOURS, _MARKERS = (BLUE, VERMILLION, GREEN, ORANGE, BLACK), "os^vD"


@dataclass(frozen=True, slots=True)
class HopsOfCondition:
    """One condition: traces over the time since touchdown, a row a hop, and joules a hop of its runs.

    `estimated_j` has the hops' joules by run, as `measured_j` has one value a run.
    """

    label: str
    time_s: Sequence[float]
    force_n: Sequence[Sequence[float]]
    length_m: Sequence[Sequence[float]]
    measured_j: Sequence[float]
    estimated_j: Sequence[Sequence[float]]


@dataclass(frozen=True, slots=True)
class WindowChoice:
    """By window in samples the difference that it makes (relative to the first) and the slope, and the window used."""

    windows: Sequence[int]
    differences: Sequence[float]
    slopes: Sequence[float]
    used: int


def draw_force_plate(
    conditions: Sequence[HopsOfCondition],
    slope: float,
    label: str,
    choice: WindowChoice,
    width_in: float = TWO_COLUMNS_IN,
) -> Figure:
    """Draw force and leg length of the hops, estimated over measured joules with the line, and what the window does."""
    with publication_style():
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 9.6 if narrow else 5.0)
        panels = figure.subplots(4, 1) if narrow else figure.subplots(2, 2).T.ravel()
        force, leg, joules, windows = panels
        for place, one in enumerate(conditions):
            colour = _COLOURS[place % len(_COLOURS)]
            milliseconds = [1e3 * time_s for time_s in one.time_s]
            for row, (forces, lengths) in enumerate(zip(one.force_n, one.length_m, strict=True)):
                named = one.label if row == 0 else "_"
                force.plot(milliseconds, forces, color=colour, linewidth=0.4, alpha=0.6, label=named)
                leg.plot(
                    milliseconds, [100.0 * length_m for length_m in lengths], color=colour, linewidth=0.4, alpha=0.6
                )
            _joules(joules, one, colour, _MARKERS[place % len(_MARKERS)])
        for axes, up in ((force, "Force on the plate (N)"), (leg, "Leg length (cm)")):
            axes.axvline(0.0, color=BLACK, linewidth=1.2)
            axes.set_xlabel("Time since touchdown (ms)")
            axes.set_ylabel(up)
        most = 1.1 * max(max(one.measured_j) for one in conditions)
        joules.plot((0.0, most), (0.0, slope * most), color=BLACK, linewidth=0.9, label=label)
        joules.plot((0.0, most), (0.0, most), color=BLACK, linewidth=0.6, linestyle=":", label="equal")
        joules.set_xlabel("Measured joules a hop (J)")
        joules.set_ylabel("Estimated joules a hop (J)")
        joules.set_xlim(left=0.0)
        joules.set_ylim(bottom=0.0)
        joules.legend(loc="lower right")
        _windows(windows, choice)
        for axes in panels:
            light_grid(axes)
        handles, names = force.get_legend_handles_labels()
        shown = figure.legend(handles, names, loc="outside lower center", ncols=2 if narrow else 4)
        for line in shown.get_lines():
            line.set(linewidth=1.5, alpha=1.0)
        return figure


def _joules(axes: Axes, one: HopsOfCondition, colour: str, marker: str) -> None:
    """Draw the hops of each run as points, and the runs' means."""
    for measured_j, hops_j in zip(one.measured_j, one.estimated_j, strict=True):
        axes.plot([measured_j] * len(hops_j), hops_j, ".", color=colour, alpha=0.3, markersize=2, markeredgewidth=0)
        axes.plot(measured_j, sum(hops_j) / len(hops_j), marker, color=colour, markersize=3.5)


def _windows(axes: Axes, choice: WindowChoice) -> None:
    """Draw differences and slopes over the window, each with its axis."""
    axes.plot(choice.windows, choice.differences, "o-", color=BLUE, markersize=2, linewidth=0.8)
    axes.axvline(choice.used, color=BLACK, linewidth=0.8, linestyle="--")
    axes.set_xlabel("Window of the moving average (samples)")
    axes.set_ylabel("Change of the force by the next (1)", color=BLUE)
    axes.set_ylim(bottom=0.0)
    right = axes.twinx()
    right.plot(choice.windows, choice.slopes, "s-", color=VERMILLION, markersize=2, linewidth=0.8)
    right.set_ylabel("Slope (1)", color=VERMILLION)
