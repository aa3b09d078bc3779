"""Residuals against groups, days and fitted values: what a comparison should not show, a pattern."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.display import in_sentence, shown_unit
from reports.figures.estimation_parts import (
    UPRIGHT,
    drawn_indices,
    height_of_names,
    marker_pt,
    named_with_unit,
    part_text,
    put_above,
    set_limits,
    swarm,
)
from reports.figures.kind import draw_words
from reports.figures.style import (
    BLACK,
    BLUE,
    GREY,
    TWO_COLUMNS_IN,
    is_narrow,
    lay_out,
    light_grid,
    new_figure,
    plain_ticks,
    publication_style,
)

_LABEL_PT = 4.0
_MOST_LABELS = 12
"""More names than these stand upright below their places."""
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

    `width_in` is the figure's width in inches. Returns a matplotlib figure; where all residuals are 0 it says that
    there is nothing to draw.
    """
    quantity = in_sentence(plot.quantity)
    if not any(plot.residuals):
        return draw_words(f"Nothing to draw: all residuals of {quantity} are 0.", width_in)
    with publication_style():
        unit, factor = shown_unit(plot.unit)
        values = [factor * value for value in plot.residuals]
        count = len(plot.against)
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 2.3 * count if narrow else 2.9)
        shape = (count, 1) if narrow else (1, count)
        panels = figure.subplots(*shape, squeeze=False, sharey=True).flatten()
        figure.supylabel(named_with_unit(f"Residual of {quantity}", unit), fontsize=8)
        higher: list[float] = []
        for axes, against in zip(panels, plot.against, strict=True):
            set_limits(axes, [*values, 0.0])
            axes.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
            light_grid(axes)
            shown, _factor = shown_unit(against.unit)
            axes.set_xlabel(named_with_unit(against.name, shown))
            if against.at and isinstance(against.at[0], str):
                higher.append(_name_places(axes, against, width_in if narrow else width_in / count))
        put_above(figure, _line(plot), width_in)
        figure.set_figheight(figure.get_figheight() + (sum(higher) if narrow else max(higher, default=0.0)))
        lay_out(figure)
        for axes, against in zip(panels, plot.against, strict=True):
            _draw_points(axes, against, values)
        return figure


def _line(plot: ResidualPlot) -> str:
    """Say what the short lines are, where there are any, and whether not every residual is drawn."""
    of = [
        in_sentence(against.name)
        for against in plot.against
        if against.means and against.at and isinstance(against.at[0], str)
    ]
    means = f"Short line: mean of the residuals of each {' and '.join(of)}." if of else ""
    parts = part_text(size for against in plot.against for size in _sizes(against))
    return " ".join(part for part in (means, parts) if part)


def _names(against: Against) -> list[str]:
    return list(against.order or dict.fromkeys(str(at) for at in against.at))


def _sizes(against: Against) -> list[int]:
    """Return how many residuals are drawn over each other's place."""
    if not against.at or not isinstance(against.at[0], str):
        return [len(against.at)]
    return list(Counter(against.at).values())


def _name_places(axes: Axes, against: Against, width_in: float) -> float:
    """Write the names below their places; return the inches that upright ones take beyond what lying ones do."""
    names = _names(against)
    axes.set_xlim(-0.6, len(names) - 0.4)
    letters = int(0.75 * 72.0 * width_in / len(names) / _LABEL_PT)
    upright = len(names) > _MOST_LABELS or letters < max(len(word) for name in names for word in name.split(" "))
    broken = ["\n".join(textwrap.wrap(name, UPRIGHT if upright else letters)) for name in names]
    axes.set_xticks(range(len(names)), broken, rotation=90 if upright else 0)
    return height_of_names(broken, upright)


def _draw_points(axes: Axes, against: Against, values: Sequence[float]) -> None:
    size = marker_pt(max(_sizes(against), default=0))
    if not against.at or not isinstance(against.at[0], str):
        factor = shown_unit(against.unit)[1]
        indices = drawn_indices(values)
        _mark(
            axes, [factor * float(against.at[place]) for place in indices], [values[place] for place in indices], size
        )
        axes.xaxis.set_major_locator(plain_ticks())
        return
    for place, name in enumerate(_names(against)):
        own = [value for value, at in zip(values, against.at, strict=True) if at == name]
        drawn = [own[index] for index in drawn_indices(own)]
        _mark(axes, [place + offset for offset in swarm(drawn, axes, size)], drawn, size)
        if not against.means:
            continue
        mean = sum(own) / len(own)
        axes.plot([place - _HALF_MEAN, place + _HALF_MEAN], [mean, mean], color=BLACK, linewidth=0.9, zorder=4)


def _mark(axes: Axes, x: Sequence[float], y: Sequence[float], size: float) -> None:
    axes.plot(x, y, "o", color=BLUE, markersize=size, markeredgewidth=0, alpha=0.75, zorder=3)
