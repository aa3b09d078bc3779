"""Residuals against groups, days and fitted values: what a comparison should not show, a pattern."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.display import in_sentence, shown_unit
from reports.figures.estimation import marker_pt, named_with_unit, put_above, set_limits, set_names
from reports.figures.style import (
    BLACK,
    BLUE,
    GREY,
    TWO_COLUMNS_IN,
    is_narrow,
    light_grid,
    new_figure,
    publication_style,
    spread,
)

_HALF_MEAN = 0.3


@dataclass(frozen=True, slots=True)
class Against:
    """What residuals are drawn against: names of groups or days, or numbers in `unit`; one for each residual.

    `order` has the names as they stand side by side, where that is not the order of their first residuals. `means` is
    whether each name has a line at the mean of its residuals: not where that is 0 by construction.
    """

    name: str
    at: tuple[str, ...] | tuple[float, ...]
    unit: str = ""
    order: tuple[str, ...] = ()
    means: bool = True


@dataclass(frozen=True, slots=True)
class ResidualPlot:
    """Residuals in `unit` of what is called `quantity`, and what each panel shows them against."""

    quantity: str
    unit: str
    residuals: tuple[float, ...]
    against: tuple[Against, ...]


def draw_residuals(plot: ResidualPlot, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw one panel for each variable of `plot.against`, with means that can differ as short lines.

    `width_in` is the figure's width in inches. Returns a matplotlib figure.
    """
    quantity = in_sentence(plot.quantity)
    with publication_style():
        unit, factor = shown_unit(plot.unit)
        values = [factor * value for value in plot.residuals]
        count, narrow = len(plot.against), is_narrow(width_in)
        figure = new_figure(width_in, 2.3 * count if narrow else 2.9)
        panels = figure.subplots(*((count, 1) if narrow else (1, count)), squeeze=False, sharey=True).flatten()
        figure.supylabel(named_with_unit(f"Residual of {quantity}", unit), fontsize=8)
        for axes, against in zip(panels, plot.against, strict=True):
            set_limits(axes, [*values, 0.0])
            axes.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
            light_grid(axes)
            axes.set_xlabel(named_with_unit(against.name, shown_unit(against.unit)[0]))
            _draw_points(axes, against, values, width_in if narrow else width_in / count)
        named = [in_sentence(against.name) for against in plot.against if against.means and _is_named(against)]
        if named:
            put_above(figure, f"Short line: mean of the residuals of each {' and '.join(named)}.", width_in)
        return figure


def _is_named(against: Against) -> bool:
    return bool(against.at) and isinstance(against.at[0], str)


def _draw_points(axes: Axes, against: Against, values: Sequence[float], width_in: float) -> None:
    size = marker_pt(len(values))
    look: dict[str, Any] = {"color": BLUE, "markersize": size, "markeredgewidth": 0, "alpha": 0.75, "zorder": 3}
    if not _is_named(against):
        factor = shown_unit(against.unit)[1]
        axes.plot([factor * float(at) for at in against.at], values, "o", **look)
        return
    names = list(against.order or dict.fromkeys(map(str, against.at)))
    axes.set_xlim(-0.6, len(names) - 0.4)
    set_names(axes, names, width_in)
    for place, name in enumerate(names):
        own = [value for value, at in zip(values, against.at, strict=True) if at == name]
        axes.plot([place + 0.5 * x for x in spread(len(own))], own, "o", **look)
        if against.means:
            mean = statistics.fmean(own)
            axes.plot([place - _HALF_MEAN, place + _HALF_MEAN], [mean, mean], color=BLACK, linewidth=0.9, zorder=4)
