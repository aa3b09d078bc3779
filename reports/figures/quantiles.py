"""Residuals beside normal quantiles: on the line and within the band they are as tests take them to be."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.figure import Figure

from data_schema.rounding import level_text
from data_schema.vocabulary import Undefined
from reports.display import NO_BREAK, in_sentence, shown_unit
from reports.figures.estimation import marker_pt, named_with_unit
from reports.figures.style import (
    BLUE,
    GREY,
    ONE_COLUMN_IN,
    PALE,
    VERMILLION,
    light_grid,
    new_figure,
    plain_ticks,
    publication_style,
)
from stats.groups.residuals import NormalQuantiles

_MARKS = ("o", "s", "^", "D", "v", "P")
"""Marks of groups: more than these are not distinguishable."""


@dataclass(frozen=True, slots=True)
class Quantiles:
    """Ordered residuals in `unit` ("J", "m") of what is called `quantity`.

    `groups` names the group of each, in the same order, or is empty; `order` has the names as a legend shows them, the
    first in the control's colour. Up to six have a mark of their own.
    """

    quantity: str
    unit: str
    found: NormalQuantiles
    groups: tuple[str, ...] = ()
    order: tuple[str, ...] = ()


def draw_quantiles(quantiles: Quantiles, width_in: float = ONE_COLUMN_IN) -> Figure:
    """Draw every residual over its normal quantile, with line and pointwise band.

    `quantiles.found` is what `stats.normal_quantiles` returns; `width_in` is the figure's width in inches. Returns a
    matplotlib figure.
    """
    about, found = in_sentence(quantiles.quantity), quantiles.found
    with publication_style():
        unit, factor = shown_unit(quantiles.unit)
        figure = new_figure(width_in, min(0.85 * width_in, 3.6))
        axes = figure.add_subplot()

        def shown(values: tuple[float, ...]) -> list[float]:
            return [factor * value for value in values]

        if not isinstance(found.middle, Undefined):
            label = "median of each place, if normal"
            axes.plot(found.expected, shown(found.middle), color=GREY, linewidth=0.9, label=label, zorder=2)
        if not isinstance(found.low, Undefined) and not isinstance(found.high, Undefined):
            band = f"{level_text(found.level).replace(' ', NO_BREAK)} of each place, if normal"
            ends = shown(found.low), shown(found.high)
            axes.fill_between(found.expected, *ends, color=PALE, linewidth=0, label=band, zorder=1)
        several = 1 < len(quantiles.order) <= len(_MARKS)
        for name, mark in zip(quantiles.order if several else ("",), _MARKS, strict=False):
            places = [place for place, _ in enumerate(found.observed) if not several or quantiles.groups[place] == name]
            axes.plot(
                [found.expected[place] for place in places],
                [factor * found.observed[place] for place in places],
                mark,
                color=VERMILLION if several and name == quantiles.order[0] else BLUE,
                markersize=marker_pt(len(found.observed)),
                markeredgewidth=0,
                alpha=0.8,
                label=name,
                zorder=3,
            )
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(plain_ticks())
        axes.set_xlabel("Normal quantile (standard deviations)")
        axes.set_ylabel(named_with_unit(f"Residual of {about}", unit))
        light_grid(axes, "both")
        if axes.get_legend_handles_labels()[1]:
            figure.legend(loc="outside lower center", ncols=2)
        return figure
