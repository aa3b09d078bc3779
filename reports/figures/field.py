"""Specific resistance of two robots on the same walks, and their ratio, beside the thesis's (2.2.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_schema.vocabulary import Undefined
from reports.figures.style import (
    BLACK,
    BLUE,
    GREY,
    ONE_COLUMN_IN,
    VERMILLION,
    light_grid,
    new_figure,
    publication_style,
)

_ASIDE = 0.15
"""How far beside its walks a mean stands, in the distance of the robots; the published value stands as far beyond."""


@dataclass(frozen=True, slots=True)
class OnWalks:
    """A robot, or the ratio of both: its value on each walk, in one order for all; their mean with interval.

    `published` is the thesis's value, None where it has none of that name.
    """

    name: str
    values: Sequence[float]
    mean: float
    interval: tuple[float, float] | Undefined
    published: float | None


def draw_field(robots: Sequence[OnWalks], ratio: OnWalks, label: str, width_in: float = ONE_COLUMN_IN) -> Figure:
    """Draw the walks as lines from robot to robot, from 0 on, and the ratio on each walk; `label` is of the means."""
    with publication_style():
        figure = new_figure(width_in, 2.9)
        of_robots, of_ratio = figure.subplots(1, 2, width_ratios=(2.2, 1.0))
        places = range(len(robots))
        for values in zip(*(one.values for one in robots), strict=True):
            of_robots.plot(places, values, "o-", color=GREY, markersize=3, linewidth=0.7, label="one walk")
        for place, one in enumerate(robots):
            _draw_mean(of_robots, place, 1 if place else -1, one, label)
        of_robots.set_xticks(list(places), [one.name for one in robots], color=BLACK)
        of_robots.set_xlim(-0.6, len(robots) - 0.4)
        of_robots.set_ylim(bottom=0.0)
        of_robots.set_ylabel("Specific resistance")
        of_ratio.axhline(1.0, color=BLACK, linewidth=0.7)
        of_ratio.plot([0.0] * len(ratio.values), ratio.values, "o", color=GREY, markersize=3)
        _draw_mean(of_ratio, 0, 1, ratio, label)
        of_ratio.set_xticks([0], [ratio.name], color=BLACK)
        of_ratio.set_xlim(-0.4, 0.6)
        of_ratio.set_ylabel("Ratio")
        for axes in (of_robots, of_ratio):
            light_grid(axes)
        handles = dict(zip(*reversed(of_robots.get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3)
        return figure


def _draw_mean(axes: Axes, place: int, side: int, one: OnWalks, label: str) -> None:
    """Draw a mean with its interval beside the walks, and beyond it the thesis's value."""
    ends = None if isinstance(one.interval, Undefined) else [[abs(end - one.mean)] for end in one.interval]
    look: dict[str, Any] = {"fmt": "D", "color": VERMILLION, "markersize": 4, "capsize": 3, "zorder": 5}
    axes.errorbar([place + side * _ASIDE], [one.mean], yerr=ends, label=label, **look)
    if one.published is not None:
        axes.plot([place + 2 * side * _ASIDE], [one.published], "*", color=BLUE, markersize=6, label="the thesis")
