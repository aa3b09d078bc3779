"""Joules a jump by battery pack."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from reports.content import ReportContent
from reports.figures.kind import FigureKind
from reports.figures.style import BLACK, BLUE, GREY, is_narrow, light_grid, new_figure
from reports.wording import list_text

_GOLDEN_STEP = (math.sqrt(5.0) - 1.0) / 2.0


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw every run by its pack, with mean and interval; less the condition's mean where that is given."""
    order = content.order
    figure = new_figure(width_in, 2.5 if is_narrow(width_in) else 2.8)
    axes = figure.add_subplot()
    deviations = all(point.deviation_j is not None for point in order.points)
    packs = sorted({point.pack for point in order.points})
    for place, pack in enumerate(packs):
        values = [
            point.joules if not deviations or point.deviation_j is None else point.deviation_j
            for point in order.points
            if point.pack == pack
        ]
        spread = [place + ((i * _GOLDEN_STEP) % 1.0 - 0.5) * 0.4 for i in range(len(values))]
        axes.plot(spread, values, "o", color=BLUE, alpha=0.4, markersize=2.8, markeredgewidth=0, zorder=2)
    for summary in order.packs:
        mean = summary.mean
        if summary.pack in packs and isinstance(mean.value, int | float):
            spans = [
                [abs(end - mean.value)] if isinstance(end, int | float) else [0.0]
                for end in (mean.ci_low, mean.ci_high)
            ]
            axes.errorbar(
                [packs.index(summary.pack)],
                [mean.value],
                yerr=spans,
                fmt="D",
                color=BLACK,
                markersize=4.5,
                capsize=4,
                zorder=4,
            )
    if deviations:
        axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=1)
    axes.set_xticks(range(len(packs)), packs)
    axes.set_xlim(-0.6, len(packs) - 0.4)
    axes.set_xlabel("Battery pack")
    axes.set_ylabel("Difference from the\ncondition's mean (J a jump)" if deviations else "Energy (J a jump)")
    light_grid(axes)
    return figure


def caption(content: ReportContent) -> str:
    """Say what is drawn."""
    points = content.order.points
    less = "less the mean of its condition, " if all(point.deviation_j is not None for point in points) else ""
    return f"Energy of a jump in each run, {less}by battery pack; diamonds are means with confidence interval."


def alternative(content: ReportContent) -> str:
    """Describe the plot in words."""
    packs = sorted({point.pack for point in content.order.points})
    return f"Dots of joules a jump for battery packs {list_text(packs)}, with the mean of each pack."


def absent(content: ReportContent) -> str | None:
    """Give the reason where no run has a pack and an energy."""
    return None if content.order.points else "No run with both a battery pack and joules a jump."


PACKS = FigureKind("packs", "Battery packs", draw, caption, alternative, absent)
