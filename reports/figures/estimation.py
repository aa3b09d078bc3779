"""Estimation plots: every value of each group with mean and SD, and in a panel below the differences with intervals.

As Cumming draws them ("Understanding the New Statistics", 2012). Those of a report have every run of control and
treatment, group by group, and below them the difference.
"""

from __future__ import annotations

import math
import statistics
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from data_schema.outcomes import Outcome
from reports.content import Comparison, ReportContent
from reports.display import EQUALS, as_shown, level_text, number_text, shown_unit
from reports.figures.kind import absence_text, figures_of_outcomes
from reports.figures.style import (
    BLACK,
    BLUE,
    GREY,
    TWO_COLUMNS_IN,
    VERMILLION,
    is_narrow,
    light_grid,
    new_figure,
    plain_ticks,
    publication_style,
    spread,
)
from reports.naming import levels_name, swept_factor, swept_words, treated_levels, treatment_label, treatment_name
from reports.numbers import Number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW_IN = 3.3
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
    matter, in the unit of `differences`, and `tested` the interval that is held against them. `difference` names the
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
    title: str = ""
    tested: tuple[float, float] | None = None


def draw_estimation(estimation: Estimation, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw all values, mean and SD of each group, and below them the differences with their intervals.

    `width_in` is the figure's width in inches. Returns a matplotlib figure that belongs to no window.

    >>> ce, ad = EstimationGroup("CE", (44.1, 42.8, 43.9)), EstimationGroup("AD", (38.0, 39.2, 37.5))
    >>> saved = Number(-5.37, "J", ci_low=-6.98, ci_high=-3.75)
    >>> figure = draw_estimation(Estimation("Energy of a jump", "J", (ce, ad), reference=0, differences=(None, saved)))
    >>> figure.savefig("energy.pdf")  # doctest: +SKIP
    """
    with publication_style():
        figure = draw_estimations([estimation], width_in)
        if estimation.interval:
            bounds = " Dashed: bounds of equivalence." if estimation.bounds else ""
            put_above(figure, f"Gapped line: mean and SD. Interval: {estimation.interval}.{bounds}", width_in)
        return figure


def draw_estimations(panels: Sequence[Estimation], width_in: float, *, share_values: bool = False) -> Figure:
    """Draw estimations beside each other on one axis of differences, with `share_values` on one of values too."""
    across = min(len(panels), 2 if is_narrow(width_in) else 4)
    rows = -(-len(panels) // across)
    figure = new_figure(width_in, _ROW_IN * rows)
    ratios = (3, 3 if any(one.bounds for one in panels) else 2)  # bounds make the intervals small
    grid = figure.subplots(2 * rows, across, squeeze=False, gridspec_kw={"height_ratios": ratios * rows})
    values = [_values(one) for one in panels]
    differences = [end for one in panels for end in _ends(one)]
    for axes in grid.flat:
        axes.set_visible(False)
    for place, one in enumerate(panels):
        row, column = divmod(place, across)
        upper, lower = grid[2 * row][column], grid[2 * row + 1][column]
        set_limits(upper, [value for each in values for value in each] if share_values else values[place])
        set_limits(lower, [0.0, *differences])
        _draw_values(upper, one)
        _draw_differences(lower, one)
        names = [f"{group.name}\nn{EQUALS}{len(group.values)}" for group in one.groups]
        upright = set_names(lower, names, width_in / across)
        if upright and len(panels) == 1:
            figure.set_figheight(figure.get_figheight() + _UPRIGHT_IN)
        upper.set_title(one.title, fontsize=7)
        for axes in (upper, lower):
            axes.set_visible(True)
            axes.set_xlim(-0.6, len(one.groups) - 0.4)
            light_grid(axes)
        upper.set_xticks([])
        if column == 0:
            _label(upper, lower, one)
    figure.align_ylabels()
    return figure


def _factors(one: Estimation) -> tuple[float, float]:
    """Return the factors from stored values, and from bounds, to those shown."""
    unit = next((number.unit for number in one.differences if number is not None), one.unit)
    return shown_unit(one.unit)[1], shown_unit(unit)[1]


def _values(one: Estimation) -> list[float]:
    return [_factors(one)[0] * value for group in one.groups for value in group.values]


def _ends(one: Estimation) -> list[float]:
    """Return all that the axis of differences holds: estimates, finite ends, bounds, and what is held against them."""
    shown = [as_shown(number) for number in one.differences if number is not None]
    found = [end for number in shown for end in (number.known, *(number.interval or ()))]
    values = [*found, *(_factors(one)[1] * end for end in (*one.bounds, *(one.tested or ())))]
    return [value for value in values if value is not None and math.isfinite(value)]


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

    The interval that is held against the bounds lies behind it as a thicker line. Where a difference or its interval
    does not exist, words say so in its place.
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
        if one.tested is not None:
            tested = [factor * end for end in one.tested]
            axes.plot([place] * 2, tested, color=GREY, linewidth=5.0, solid_capstyle="butt", zorder=4)
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


def put_above(figure: Figure, line: str, width_in: float) -> None:
    """Write a line above the figure."""
    figure.suptitle(textwrap.fill(line, int(72.0 * width_in / _LINE_PT)), x=0.01, ha="left", fontsize=6.5)


def named_with_unit(quantity: str, unit: str) -> str:
    """Return what stands at an axis: "Energy (J)"; the unit "1" is not written."""
    return quantity if unit in ("", "1") else f"{quantity} ({unit})"


def _drawn(content: ReportContent, quantity: Outcome) -> list[Comparison]:
    return [comparison for comparison in content.pooled if comparison.quantity is quantity]


def _draw(content: ReportContent, quantity: Outcome, width_in: float) -> Figure:
    """Draw a pair of panels a group, values above and difference below.

    Joules share their axis. Heights do not: groups lie further apart than their runs scatter.
    """
    panels = [_estimation(content, comparison) for comparison in _drawn(content, quantity)]
    return draw_estimations(panels, width_in, share_values=quantity.has_savings)


def _estimation(content: ReportContent, comparison: Comparison) -> Estimation:
    """Return the runs of control and treatment, and what was held against bounds; in percent, of the control's mean."""
    values: tuple[list[float], list[float]] = ([], [])
    for condition in content.conditions:
        labels = {level.factor: level.label for level in condition.levels}
        summary = condition.summary(comparison.quantity)
        if summary is not None and comparison.group.items() <= labels.items():
            values[0 if condition.control else 1].extend(value for _run, value in summary.runs)
    names = swept_words(swept_factor(content)).control, treatment_label(content)
    bounds: tuple[float, ...] = ()
    tested = None
    item, control = comparison.decision.equivalence, values[0]
    if item is not None and control:
        of_mean = 0.01 * statistics.fmean(control) if item.estimate.unit == "%" else 1.0
        bounds = of_mean * item.low, of_mean * item.high
        if item.estimate.interval is not None:
            tested = of_mean * item.estimate.interval[0], of_mean * item.estimate.interval[1]
    return Estimation(
        quantity=comparison.quantity.heading,
        unit=comparison.quantity.unit,
        groups=tuple(EstimationGroup(name, tuple(own)) for name, own in zip(names, values, strict=True)),
        reference=0,
        differences=(None, comparison.decision.difference),
        bounds=bounds,
        title=levels_name(content, comparison.group).replace(", ", "\n") or "all runs",
        tested=tested,
    )


def _caption(content: ReportContent, quantity: Outcome) -> str:
    chosen = _drawn(content, quantity)
    called = swept_words(swept_factor(content))
    level = level_text(chosen[0].decision.difference)
    tested = next((item.estimate for c in chosen if (item := c.decision.equivalence) is not None), None)
    dashed = ""
    if tested is not None:
        dashed = (
            " Dashed: the bounds within which a difference counts as none; the test against them (TOST) goes by the "
            f"{level_text(tested)}, the thick grey line."
        )
    axes = "the lower panels share their vertical axis, each upper one has its own"
    if quantity.has_savings:
        axes = "all upper panels share one vertical axis, and all lower ones another"
    together = f" (all levels of the {called.coefficient} together)" if len(treated_levels(content, {})) > 1 else ""
    sides = f"{called.the_control} and of {treatment_name(content, {})}{together}"
    return (
        f"{quantity.heading}, every run of {sides}, group by group. "
        "Beside the points: mean (gap) and standard deviation (line). "
        f"Below: treatment less control (stroke) with its {level} by the days that hold both (line); {axes}.{dashed}"
    )


def _alternative(content: ReportContent, quantity: Outcome) -> str:
    parts = []
    for comparison in _drawn(content, quantity):
        name, lead = levels_name(content, comparison.group) or "all runs", comparison.decision
        parts.append(f"{name}: {number_text(lead.difference)}, {lead.n_control} and {lead.n_treatment} runs")
    return f"Single runs and the difference of {quantity}, treatment less control. {'; '.join(parts)}."


def _absent(content: ReportContent, quantity: Outcome) -> str | None:
    if _drawn(content, quantity):
        return None
    return absence_text(content, f"is no group with {quantity} of both a control and a treatment")


_SHOWS = ("factors", "conditions", "comparisons")
ESTIMATIONS = figures_of_outcomes(
    "estimation_{}", "{}: every run, and the difference", _draw, _caption, _alternative, _absent, _SHOWS
)
"""A figure an outcome."""
