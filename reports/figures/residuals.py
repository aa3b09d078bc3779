"""Residuals against groups, days and fitted values: what a comparison should not show, a pattern."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from reports.display import shown_unit
from reports.figures.estimation_parts import named_with_unit, set_limits
from reports.figures.style import (
    BLACK,
    BLUE,
    GREY,
    TWO_COLUMNS_IN,
    is_narrow,
    light_grid,
    new_figure,
    publication_style,
)
from reports.figures.swarm import marker_pt, swarm

_LABEL_PT = 4.0
_MOST_LABELS = 12
"""More names than these stand upright below their places."""
_HALF_MEAN = 0.3


@dataclass(frozen=True, slots=True)
class Against:
    """What residuals are drawn against: names of groups or days, or numbers in `unit`; one for each residual.

    `order` has the names as they stand side by side, where that is not the order of their first residuals.
    """

    name: str
    at: tuple[str, ...] | tuple[float, ...]
    unit: str = ""
    order: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ResidualPlot:
    """Residuals in `unit` of what is called `quantity`, and what each panel shows them against."""

    quantity: str
    unit: str
    residuals: tuple[float, ...]
    against: tuple[Against, ...]


def draw_residuals(plot: ResidualPlot, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw one panel for each thing that the residuals are drawn against; means of names as short lines."""
    with publication_style():
        unit, factor = shown_unit(plot.unit)
        values = [factor * value for value in plot.residuals]
        count = len(plot.against)
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 2.3 * count if narrow else 2.9)
        shape = (count, 1) if narrow else (1, count)
        panels = figure.subplots(*shape, squeeze=False, sharey=True).flatten()
        quantity = f"{plot.quantity[:1].lower()}{plot.quantity[1:]}"
        figure.supylabel(named_with_unit(f"Residual of {quantity}", unit), fontsize=8)
        for axes, against in zip(panels, plot.against, strict=True):
            set_limits(axes, [*values, 0.0])
            axes.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
            light_grid(axes)
            shown, _factor = shown_unit(against.unit)
            axes.set_xlabel(named_with_unit(against.name, shown))
            if against.at and isinstance(against.at[0], str):
                _name_places(axes, against, width_in if narrow else width_in / count)
        figure.draw_without_rendering()
        for axes, against in zip(panels, plot.against, strict=True):
            _draw_points(axes, against, values)
        return figure


def _names(against: Against) -> list[str]:
    return list(against.order or dict.fromkeys(str(at) for at in against.at))


def _name_places(axes: Axes, against: Against, width_in: float) -> None:
    names = _names(against)
    axes.set_xlim(-0.6, len(names) - 0.4)
    letters = int(0.75 * 72.0 * width_in / len(names) / _LABEL_PT)
    if len(names) > _MOST_LABELS or letters < max(map(len, (word for name in names for word in name.split()))):
        axes.set_xticks(range(len(names)), names, rotation=90)
    else:
        axes.set_xticks(range(len(names)), ["\n".join(textwrap.wrap(name, letters)) for name in names])


def _draw_points(axes: Axes, against: Against, values: Sequence[float]) -> None:
    size = marker_pt(len(values))
    if not against.at or not isinstance(against.at[0], str):
        factor = shown_unit(against.unit)[1]
        _mark(axes, [factor * float(at) for at in against.at], values, size)
        axes.xaxis.set_major_locator(MaxNLocator(6))
        return
    for place, name in enumerate(_names(against)):
        own = [value for value, at in zip(values, against.at, strict=True) if at == name]
        _mark(axes, [place + offset for offset in swarm(own, axes, size)], own, size)
        mean = sum(own) / len(own)
        axes.plot([place - _HALF_MEAN, place + _HALF_MEAN], [mean, mean], color=BLACK, linewidth=0.9, zorder=4)


def _mark(axes: Axes, x: Sequence[float], y: Sequence[float], size: float) -> None:
    axes.plot(x, y, "o", color=BLUE, markersize=size, markeredgewidth=0, alpha=0.75, zorder=3)
