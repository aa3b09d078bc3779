"""Hops on a force plate: aligned traces, estimated over measured joules, and the window (thesis fig. 3.7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

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

_COLOURS, _MARKERS = (BLUE, VERMILLION, GREEN, ORANGE, BLACK), "os^vD"
_ASIDE_J, _GOLDEN = 0.8, 0.618
"""Hops of a run are spread over so many joules, each by the golden section from the one before."""


@dataclass(frozen=True, slots=True)
class HopsOfCondition:
    """One condition: traces over the time since touchdown, a row a hop, and joules a hop of its runs.

    The foremost `first` traces are of the run's first hops. `hops_j` has the estimated joules of the first hops and of
    the others by run, as `measured_j` has one value a run.
    """

    label: str
    first: int
    time_s: Sequence[float]
    force_n: Sequence[Sequence[float]]
    length_m: Sequence[Sequence[float]]
    measured_j: Sequence[float]
    hops_j: Sequence[tuple[Sequence[float], Sequence[float]]]


@dataclass(frozen=True, slots=True)
class WindowChoice:
    """By window in samples the difference that it makes (relative to the first) and the slope, and the window used.

    `by_corner`: the corner of the differences is the window used.
    """

    windows: Sequence[int]
    differences: Sequence[float]
    slopes: Sequence[float]
    used: int
    by_corner: bool


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
        figure = new_figure(width_in, 9.6 if narrow else 4.7)
        panels = figure.subplots(4, 1) if narrow else figure.subplots(2, 2).T.ravel()
        force, leg, joules, windows = panels
        for place, one in enumerate(conditions):
            colour = _COLOURS[place % len(_COLOURS)]
            milliseconds = [1e3 * time_s for time_s in one.time_s]
            for row, (forces, lengths) in enumerate(zip(one.force_n, one.length_m, strict=True)):
                look: dict[str, Any] = {"color": colour, "linewidth": 0.4, "alpha": 0.6}
                if row < one.first:
                    look |= {"linestyle": (0, (2, 2)), "linewidth": 0.6}
                force.plot(milliseconds, forces, **look)
                leg.plot(milliseconds, [100.0 * length_m for length_m in lengths], **look)
            marker = _MARKERS[place % len(_MARKERS)]
            _joules(joules, one, colour, marker)
            force.plot([], [], marker=marker, color=colour, markersize=3.5, linewidth=1.5, label=one.label)
        force.plot(
            [],
            [],
            color=GREY,
            linewidth=1.0,
            linestyle=(0, (2, 2)),
            marker="o",
            markerfacecolor="none",
            markersize=3,
            label="the first hops of a run",
        )
        for axes, up in ((force, "Force on the plate (N)"), (leg, "Leg length (cm)")):
            axes.axvline(0.0, color=BLACK, linewidth=1.2)
            axes.set_xlabel("Time since touchdown (ms)")
            axes.set_ylabel(up)
        _line(joules, conditions, slope, label)
        _windows(windows, choice)
        for axes in panels:
            light_grid(axes)
        handles, names = force.get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=2 if narrow else 3)
        return figure


def _joules(axes: Axes, one: HopsOfCondition, colour: str, marker: str) -> None:
    """Draw the hops of each run as points beside each other, the first ones hollow, and the runs' means."""
    for measured_j, (first_j, others_j) in zip(one.measured_j, one.hops_j, strict=True):
        hops_j = [*first_j, *others_j]
        across = [measured_j + _ASIDE_J * ((place * _GOLDEN) % 1.0 - 0.5) for place in range(len(hops_j))]
        few = len(first_j)
        axes.plot(across[:few], first_j, "o", color=colour, markersize=2.5, markerfacecolor="none", markeredgewidth=0.6)
        axes.plot(across[few:], others_j, "o", color=colour, alpha=0.35, markersize=1.8, markeredgewidth=0)
        mean_j = sum(hops_j) / len(hops_j)
        axes.plot(
            measured_j, mean_j, marker, color=colour, markersize=4.5, markeredgecolor="white", markeredgewidth=0.6
        )


def _line(axes: Axes, conditions: Sequence[HopsOfCondition], slope: float, label: str) -> None:
    """Draw the line where there are hops, and that of equal joules."""
    measured = [measured_j for one in conditions for measured_j in one.measured_j]
    ends = 0.92 * min(measured), 1.06 * max(measured)
    axes.plot(ends, [slope * end for end in ends], color=BLACK, linewidth=0.9, label=label)
    axes.plot(ends, ends, color=BLACK, linewidth=0.6, linestyle=":", label="equal")
    axes.set_xlim(*ends)
    axes.set_xlabel("Measured joules a hop (J)")
    axes.set_ylabel("Estimated joules a hop (J)")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.25 * (high - low))
    axes.legend(loc="upper left", handlelength=1.2)


def _windows(axes: Axes, choice: WindowChoice) -> None:
    """Draw differences and slopes over the window, each with its axis."""
    axes.plot(choice.windows, choice.differences, "o-", color=BLUE, markersize=2, linewidth=0.8)
    axes.axvline(choice.used, color=BLACK, linewidth=0.8, linestyle="--")
    why = "corner" if choice.by_corner else "as given"
    axes.text(
        choice.used + 1.0,
        0.97,
        f"{why}: {choice.used} samples",
        transform=axes.get_xaxis_transform(),
        va="top",
        fontsize=7,
    )
    axes.set_xlabel("Window of the moving average (samples)")
    axes.set_ylabel("Change of the force, relative", color=BLUE)
    axes.set_ylim(bottom=0.0)
    right = axes.twinx()
    right.plot(choice.windows, choice.slopes, "s-", color=VERMILLION, markersize=2, linewidth=0.8)
    right.set_ylabel("Slope, estimated / measured", color=VERMILLION)
    right.spines.right.set_visible(True)
