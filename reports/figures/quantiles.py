"""Residuals beside normal quantiles: on the line and within the band they are as tests take them to be."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.figure import Figure

from data_schema.vocabulary import Undefined
from reports.display import NO_BREAK, general_text, shown_unit
from reports.figures.estimation_parts import named_with_unit
from reports.figures.style import BLUE, GREY, ONE_COLUMN_IN, PALE, light_grid, new_figure, publication_style
from reports.figures.swarm import marker_pt
from stats.residuals import NormalQuantiles


@dataclass(frozen=True, slots=True)
class Quantiles:
    """Ordered residuals in `unit` ("J", "m") of what is called `quantity`."""

    quantity: str
    unit: str
    found: NormalQuantiles


def draw_quantiles(quantiles: Quantiles, width_in: float = ONE_COLUMN_IN) -> Figure:
    """Draw every residual over the normal value that belongs to its place, with line and pointwise band."""
    with publication_style():
        found, (unit, factor) = quantiles.found, shown_unit(quantiles.unit)
        figure = new_figure(width_in, min(0.85 * width_in, 3.6))
        axes = figure.add_subplot()
        if not isinstance(found.middle, Undefined):
            line = [factor * value for value in found.middle]
            axes.plot(found.expected, line, color=GREY, linewidth=0.9, label="normal", zorder=2)
        if not isinstance(found.low, Undefined) and not isinstance(found.high, Undefined):
            low, high = ([factor * value for value in ends] for ends in (found.low, found.high))
            band = f"{general_text(100.0 * found.level)}{NO_BREAK}% of each place, if normal"
            axes.fill_between(found.expected, low, high, color=PALE, linewidth=0, label=band, zorder=1)
        axes.plot(
            found.expected,
            [factor * value for value in found.observed],
            "o",
            color=BLUE,
            markersize=marker_pt(len(found.observed)),
            markeredgewidth=0,
            alpha=0.8,
            zorder=3,
        )
        axes.set_xlabel("Normal quantile (standard deviations)")
        axes.set_ylabel(named_with_unit(f"Residual of {quantiles.quantity[:1].lower()}{quantiles.quantity[1:]}", unit))
        light_grid(axes, "both")
        if axes.get_legend_handles_labels()[1]:
            axes.legend(loc="upper left")
        return figure
