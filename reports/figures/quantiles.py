"""Residuals beside normal quantiles: on the line and within the band they are as tests take them to be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from data_schema.rounding import level_text
from data_schema.vocabulary import Undefined
from reports.display import NO_BREAK, in_sentence, shown_unit
from reports.figures.estimation_parts import MARKS, MOST_DRAWN, columns_of, marker_pt, named_with_unit, put_above
from reports.figures.kind import draw_words
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
    matplotlib figure; where all residuals are 0 it says that there is nothing to draw.
    """
    about = in_sentence(quantiles.quantity)
    if not any(quantiles.found.observed):
        return draw_words(f"Nothing to draw: all residuals of {about} are 0.", width_in)
    with publication_style():
        found, (unit, factor) = quantiles.found, shown_unit(quantiles.unit)
        figure = new_figure(width_in, min(0.85 * width_in, 3.6))
        axes = figure.add_subplot()
        indices = _drawn_indices(found.expected)
        expected = [found.expected[place] for place in indices]

        def drawn(values: tuple[float, ...]) -> list[float]:
            return [factor * values[place] for place in indices]

        if not isinstance(found.middle, Undefined):
            label = "median of each place, if normal"
            axes.plot(expected, drawn(found.middle), color=GREY, linewidth=0.9, label=label, zorder=2)
        if not isinstance(found.low, Undefined) and not isinstance(found.high, Undefined):
            level = level_text(found.level).replace(" ", NO_BREAK)
            band = f"{level} of each place, if normal"
            axes.fill_between(
                expected, drawn(found.low), drawn(found.high), color=PALE, linewidth=0, label=band, zorder=1
            )
        marks = _draw_marks(axes, quantiles, indices, expected, drawn(found.observed))
        if len(marks) > 1:
            _name_marks(figure, marks, width_in)
        put_above(figure, _part_text(len(indices), len(found.observed)), width_in)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(plain_ticks())
        axes.set_xlabel("Normal quantile (standard deviations)")
        axes.set_ylabel(named_with_unit(f"Residual of {about}", unit))
        light_grid(axes, "both")
        if axes.get_legend_handles_labels()[1]:
            axes.legend(loc="upper left")
        return figure


def _draw_marks(
    axes: Axes, quantiles: Quantiles, indices: Sequence[int], expected: Sequence[float], values: Sequence[float]
) -> dict[str, str]:
    """Draw the residuals at `indices`, and return the mark of each group; one for all where groups have none."""
    size = marker_pt(len(quantiles.found.observed))
    marks = dict(zip(quantiles.order, MARKS, strict=False)) if 1 < len(quantiles.order) <= len(MARKS) else {"": "o"}
    names = [quantiles.groups[place] for place in indices] if len(marks) > 1 else [""] * len(indices)
    for name, mark in marks.items():
        colour = VERMILLION if len(marks) > 1 and name == quantiles.order[0] else BLUE
        axes.plot(
            [at for at, own in zip(expected, names, strict=True) if own == name],
            [value for value, own in zip(values, names, strict=True) if own == name],
            mark,
            color=colour,
            markersize=size,
            markeredgewidth=0,
            alpha=0.8,
            zorder=3,
        )
    return marks


def _drawn_indices(expected: tuple[float, ...]) -> list[int]:
    """Return which values are drawn: all, or of many those at even steps of the normal value, both ends among them."""
    if len(expected) <= MOST_DRAWN:
        return list(range(len(expected)))
    steps = np.linspace(expected[0], expected[-1], MOST_DRAWN)
    return sorted({int(place) for place in np.searchsorted(expected, steps).clip(0, len(expected) - 1)})


def _part_text(drawn: int, n: int) -> str:
    return "" if drawn == n else f"{drawn} of {n} residuals are drawn, evenly along the axis, with the ends."


def _name_marks(figure: Figure, marks: Mapping[str, str], width_in: float) -> None:
    """Write below the axes which mark is which group's; the first is the control's."""
    handles = [
        Line2D([], [], linestyle="none", marker=mark, color=BLUE if place else VERMILLION, markersize=4)
        for place, mark in enumerate(marks.values())
    ]
    names = list(marks)
    figure.legend(handles, names, loc="outside lower center", ncols=columns_of(names, width_in), handletextpad=0.1)
