"""Estimates with intervals, one a row: the parts that forest plots share."""

from __future__ import annotations

import math

from matplotlib.axes import Axes

from reports.display import as_shown
from reports.figures.style import BLACK, GREY
from reports.numbers import Number


def draw_estimate(
    axes: Axes, number: Number, row: float, *, colour: str = BLACK, marker: str = "o", scale: float = 1.0
) -> None:
    """Draw one number and its interval at a height; where the number does not exist, say so in its place."""
    shown = as_shown(number)
    if not isinstance(shown.value, int | float):
        axes.text(0.02, row, "undefined", transform=axes.get_yaxis_transform(), color=GREY, fontsize=6.5, va="center")
        return
    low, high = shown.ci_low, shown.ci_high
    if isinstance(low, int | float) and isinstance(high, int | float) and math.isfinite(low + high):
        axes.plot([low, high], [row, row], color=colour, linewidth=1.1 * scale, solid_capstyle="butt", zorder=3)
    axes.plot([shown.value], [row], marker, color=colour, markersize=4.2 * scale, zorder=4)


def tidy_rows(axes: Axes, rows: int) -> None:
    """Put row 0 on top, drop the left spine and its ticks."""
    axes.set_ylim(rows - 0.4, -0.6)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
