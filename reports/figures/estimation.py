"""Estimation plots: every value of each group with mean and SD, and in a panel below the differences with intervals.

As Cumming draws them ("Understanding the New Statistics", 2012).
"""

from __future__ import annotations

import math
import statistics
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.display import EQUALS, as_shown, level_text, shown_unit
from reports.figures.style import (
    BLACK,
    BLUE,
    GREY,
    TWO_COLUMNS_IN,
    VERMILLION,
    light_grid,
    paper_figure,
    plain_ticks,
    spread,
)
from reports.numbers import Number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT_IN = 3.3
_LABEL_LETTERS = 22
"""As many letters fit beside a panel."""
_WIDTH = 0.5
"""How much of a group's place its points take; mean and SD stand beside them."""
_SD_AT = 0.38
_GAP = 0.012
"""Half of the gap at the mean, as a part of the axis."""
_NAME_PT, _LINE_PT = 4.3, 3.6
"""Widths of a letter of the groups' names, and of the line above a figure."""
_UPRIGHT_LETTERS, _UPRIGHT_IN = 24, 0.8
"""Letters in a line of a name that stands upright, and the height that such names add."""


@dataclass(frozen=True, slots=True)
class EstimationGroup:
    """A group and its values."""

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Estimation:
    """Groups and their differences from one of them.

    Values are in `unit` ("J", "m"); `reference` is the place of the group that the others are compared with, and
    `differences` has one number a group, in `unit` or "%", None for the reference. `bounds` are differences that
    matter, in the unit of `differences`. `difference` names the
    differences ("Savings"), `interval` the method of their intervals, which a line above the figure repeats.
    """

    quantity: str
    unit: str
    groups: tuple[EstimationGroup, ...]
    reference: int
    differences: tuple[Number | None, ...]
    bounds: tuple[float, ...] = ()
    difference: str = ""
    interval: str = ""


def draw_estimation(estimation: Estimation, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw all values, mean and SD of each group, and below them the differences with their intervals.

    `width_in` is the figure's width in inches. Returns a matplotlib figure that belongs to no window.

    >>> ce, ad = EstimationGroup("CE", (44.1, 42.8, 43.9)), EstimationGroup("AD", (38.0, 39.2, 37.5))
    >>> saved = Number(-5.37, "J", ci_low=-6.98, ci_high=-3.75)
    >>> figure = draw_estimation(Estimation("Energy of a jump", "J", (ce, ad), reference=0, differences=(None, saved)))
    >>> figure.savefig("energy.pdf")  # doctest: +SKIP
    """
    one, differences = estimation, [end for number in estimation.differences for end in _ends(number)]
    with paper_figure(_HEIGHT_IN, width_in) as figure:
        ratios = (3, 3 if one.bounds else 2)  # bounds make the intervals small
        upper, lower = figure.subplots(2, 1, height_ratios=ratios)
        set_limits(upper, [_factors(one)[0] * value for group in one.groups for value in group.values])
        set_limits(lower, [0.0, *differences, *(_factors(one)[1] * bound for bound in one.bounds)])
        _draw_values(upper, one)
        _draw_differences(lower, one)
        names = [f"{group.name}\nn{EQUALS}{len(group.values)}" for group in one.groups]
        if set_names(lower, names, width_in):
            figure.set_figheight(_HEIGHT_IN + _UPRIGHT_IN)
        for axes in (upper, lower):
            axes.set_xlim(-0.6, len(one.groups) - 0.4)
            light_grid(axes)
        upper.set_xticks([])
        _label(upper, lower, one)
        figure.align_ylabels()
        if one.interval:
            bounds = " Dashed: bounds of equivalence." if one.bounds else ""
            line = f"Gapped line: mean and SD. Interval: {one.interval}.{bounds}"
            figure.suptitle(textwrap.fill(line, int(72.0 * width_in / _LINE_PT)), x=0.01, ha="left", fontsize=6.5)
        return figure


def _factors(one: Estimation) -> tuple[float, float]:
    """Return the factors from stored values, and from bounds, to those shown."""
    unit = next((number.unit for number in one.differences if number is not None), one.unit)
    return shown_unit(one.unit)[1], shown_unit(unit)[1]


def _ends(number: Number | None) -> list[float]:
    """Return what of a difference the axis holds: estimate and finite ends."""
    shown = None if number is None else as_shown(number)
    found = [] if shown is None else [shown.known, *(shown.interval or ())]
    return [value for value in found if value is not None and math.isfinite(value)]


def _label(upper: Axes, lower: Axes, one: Estimation) -> None:
    upper.set_ylabel(textwrap.fill(named_with_unit(one.quantity, shown_unit(one.unit)[0]), _LABEL_LETTERS))
    shown = [as_shown(number) for number in one.differences if number is not None]
    unit, level = (shown[0].unit, f"\n({level_text(shown[0])})") if shown else (shown_unit(one.unit)[0], "")
    difference = one.difference or f"Mean difference from {one.groups[one.reference].name}"
    called = named_with_unit(difference, unit)
    lower.set_ylabel(f"{textwrap.fill(called, _LABEL_LETTERS)}{level}")


def _draw_values(axes: Axes, one: Estimation) -> None:
    """Draw every value, and beside each group its mean as a gap in the line of its SD."""
    factor = _factors(one)[0]
    size = marker_pt(max(len(group.values) for group in one.groups))
    low, high = axes.get_ylim()
    for place, group in enumerate(one.groups):
        colour = VERMILLION if place == one.reference else BLUE
        values = [factor * value for value in group.values]
        beside = [place - 0.1 + _WIDTH * x for x in spread(len(values))]
        axes.plot(beside, values, "o", color=colour, markersize=size, markeredgewidth=0, alpha=0.75, zorder=3)
        if not values:
            continue
        mean, sd = statistics.fmean(values), statistics.stdev(values) if len(values) > 1 else 0.0
        gap = _GAP * (high - low)
        if sd <= gap:
            axes.plot([place + _SD_AT], [mean], "_", color=colour, markersize=5, zorder=4)
            continue
        for side in (-1.0, 1.0):
            ends = [mean + side * gap, mean + side * sd]
            axes.plot([place + _SD_AT] * 2, ends, color=colour, linewidth=1.6, solid_capstyle="butt", zorder=4)


def _draw_differences(axes: Axes, one: Estimation) -> None:
    """Draw each difference as a stroke across its interval, which a dot would hide where the bounds are far apart.

    Where a difference or its interval does not exist, words say so in its place.
    """
    factor = _factors(one)[1]
    axes.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
    for bound in one.bounds:
        axes.axhline(factor * bound, color=BLACK, linewidth=0.8, linestyle="--", zorder=2)
    for place, number in enumerate(one.differences):
        if number is None:
            continue
        shown = as_shown(number)
        if shown.known is None or shown.interval is None:
            words = "undefined" if shown.known is None else "no interval"
            axes.text(place, shown.known or 0.0, words, color=GREY, fontsize=6.5, ha="center", va="bottom")
        else:
            axes.plot([place] * 2, shown.interval, color=BLACK, linewidth=1.2, solid_capstyle="butt", zorder=5)
        if shown.known is None:
            continue
        axes.plot([place], [shown.known], "_", color=BLACK, markersize=12.0, markeredgewidth=0.9, zorder=6)


def marker_pt(most: int) -> float:
    """Return the diameter of marks, in points, where the largest group has `most` values."""
    return 4.0 if most <= 40 else 3.0 if most <= 120 else 1.8


def set_limits(axes: Axes, values: Sequence[float]) -> None:
    """Let the axis of values hold all of these, with some room."""
    low, high = min(values, default=0.0), max(values, default=1.0)
    room = 0.07 * (high - low) or 0.05 * abs(high) or 1.0
    axes.set_ylim(low - room, high + room)
    axes.yaxis.set_major_locator(plain_ticks())


def set_names(axes: Axes, names: Sequence[str], width_in: float) -> bool:
    """Write names below their places, broken so that neighbours do not touch; return whether they stand upright.

    They do where a word is too long for its place.
    """
    letters = max(1, int((72.0 * width_in - 60.0) / len(names) / _NAME_PT))
    upright = any(len(word) > letters for name in names for word in name.split())
    lines = _UPRIGHT_LETTERS if upright else letters
    broken = ["\n".join(textwrap.fill(part, lines) for part in name.split("\n")) for name in names]
    axes.set_xticks(range(len(names)), broken, rotation=90 if upright else 0)
    return upright


def named_with_unit(quantity: str, unit: str) -> str:
    """Return what stands at an axis: "Energy (J)"; the unit "1" is not written."""
    return quantity if unit in ("", "1") else f"{quantity} ({unit})"
