"""Specific resistance of two robots on the same walks: each walk a line, and the means beside (thesis 2.2.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from data_schema.vocabulary import Undefined
from reports.figures.style import BLACK, GREY, ONE_COLUMN_IN, VERMILLION, light_grid, new_figure, publication_style

_ASIDE = 0.12
"""How far beside its walks a mean stands, in the distance of the robots."""


@dataclass(frozen=True, slots=True)
class RobotWalks:
    """One robot: its specific resistance on each walk, in one order for all robots, and their mean with interval."""

    robot: str
    values: Sequence[float]
    mean: float
    interval: tuple[float, float] | Undefined
    label: str


def draw_field(robots: Sequence[RobotWalks], width_in: float = ONE_COLUMN_IN) -> Figure:
    """Draw the walks as lines from robot to robot, from 0 on."""
    with publication_style():
        figure = new_figure(width_in, 2.8)
        axes = figure.add_subplot()
        places = range(len(robots))
        for values in zip(*(one.values for one in robots), strict=True):
            axes.plot(places, values, "o-", color=GREY, markersize=3, linewidth=0.7)
        for place, one in enumerate(robots):
            if isinstance(one.interval, Undefined):
                continue
            ends = [[abs(end - one.mean)] for end in one.interval]
            aside = place + (_ASIDE if place else -_ASIDE)
            look: dict[str, Any] = {"fmt": "D", "color": VERMILLION, "markersize": 4, "capsize": 3, "zorder": 5}
            axes.errorbar([aside], [one.mean], yerr=ends, label="" if place else one.label, **look)
        axes.set_xticks(list(places), [one.robot for one in robots], color=BLACK)
        axes.set_xlim(-0.5, len(robots) - 0.5)
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel("Specific resistance")
        light_grid(axes)
        if axes.get_legend_handles_labels()[0]:
            figure.legend(loc="outside lower center")
        return figure
