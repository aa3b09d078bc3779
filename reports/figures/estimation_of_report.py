"""Estimation plots of a report: every run of control and treatment, group by group, and below them the difference."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.content import Comparison, ReportContent
from reports.display import as_shown, common_places, interval_text, level_text, shown_unit, value_text, with_unit
from reports.evidence import Side
from reports.figures.estimation_parts import (
    DrawnGroup,
    axis_values,
    draw_difference,
    draw_values,
    named_with_unit,
    set_limits,
    set_names,
)
from reports.figures.kind import figures_of_outcomes, levels_alone
from reports.figures.style import BLACK, BLUE, GREY, VERMILLION, is_narrow, lay_out, light_grid, new_figure
from reports.naming import levels_name, swept_factor, swept_words, treated_levels, treatment_label, treatment_name
from reports.numbers import Number
from reports.sentences import absence_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW_IN = 3.0
_LABEL_LETTERS = 22
"""As many letters fit beside a panel."""
_THIN, _THICK = 1.0, 5.0
"""Widths in points of the interval of a difference and of the one that is held against bounds."""


def _drawn(content: ReportContent, quantity: Outcome) -> list[Comparison]:
    return [comparison for comparison in content.pooled if comparison.quantity is quantity]


def _sides(content: ReportContent, comparison: Comparison) -> tuple[DrawnGroup, DrawnGroup]:
    """Return the runs of control and treatment with their mean and SD, in the unit that is shown."""
    called = swept_words(swept_factor(content))
    factor = shown_unit(comparison.quantity.unit)[1]
    names = (called.control, treatment_label(content))
    values: tuple[list[float], list[float]] = ([], [])
    for condition in content.conditions:
        labels = {level.factor: level.label for level in condition.levels}
        summary = condition.summary(comparison.quantity)
        if summary is not None and comparison.group.items() <= labels.items():
            values[0 if condition.control else 1].extend(factor * run.value for run in summary.runs)
    sides = comparison.sides or (None, None)
    control, treated = (
        DrawnGroup(name, tuple(own), (), _scaled(side, "mean", factor), _scaled(side, "sd", factor), colour)
        for name, own, side, colour in zip(names, values, sides, (VERMILLION, BLUE), strict=True)
    )
    return control, treated


def _scaled(side: Side | None, name: str, factor: float) -> float | None:
    value = None if side is None else getattr(side, name)
    return None if value is None or isinstance(value, Undefined) else factor * value


@dataclass(frozen=True, slots=True)
class _Tested:
    """Bounds of equivalence and the interval held against them, in the unit that is shown; `ends` is None without."""

    bounds: tuple[float, ...] = ()
    ends: tuple[float, float] | None = None


def _draw(content: ReportContent, quantity: Outcome, width_in: float) -> Figure:
    """Draw a pair of panels a group, values above and difference below.

    Differences share their axis, and so do joules. Heights do not: groups lie further apart than their runs scatter.
    """
    chosen = _drawn(content, quantity)
    across = min(len(chosen), 2 if is_narrow(width_in) else 4)
    rows = -(-len(chosen) // across)
    sides = [_sides(content, comparison) for comparison in chosen]
    tested = [_tested(comparison, control.mean) for comparison, (control, _) in zip(chosen, sides, strict=True)]
    figure = new_figure(width_in, _ROW_IN * rows)
    parts = (3, 3 if any(item.bounds for item in tested) else 2)  # bounds make the intervals small
    grid = figure.subplots(2 * rows, across, squeeze=False, gridspec_kw={"height_ratios": parts * rows})
    for axes in grid.flat:
        axes.set_visible(False)
    all_values = [value for groups in sides for group in groups for value in group.values]
    below = [end for comparison in chosen for end in axis_values(as_shown(comparison.lead.difference))]
    below += [0.0, *(value for item in tested for value in (*item.bounds, *(item.ends or ())))]
    uppers = []
    for place, (comparison, groups) in enumerate(zip(chosen, sides, strict=True)):
        row, column = divmod(place, across)
        upper, lower = grid[2 * row][column], grid[2 * row + 1][column]
        difference = as_shown(comparison.lead.difference)
        for axes in (upper, lower):
            axes.set_visible(True)
            axes.set_xlim(-0.6, 1.6)
            light_grid(axes)
        own_values = [value for group in groups for value in group.values]
        set_limits(upper, all_values if quantity.has_savings else own_values)
        set_limits(lower, below)
        upper.set_xticks([])
        upper.set_title(levels_name(content, comparison.group).replace(", ", "\n") or "all runs", fontsize=7)
        set_names(lower, groups, (), width_in / across)
        lower.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
        for bound in tested[place].bounds:
            lower.axhline(bound, color=BLACK, linewidth=0.8, linestyle="--", zorder=2)
        _draw_difference(lower, difference, tested[place].ends)
        if column == 0:
            unit = difference.unit
            upper.set_ylabel(textwrap.fill(named_with_unit(quantity.heading, unit), _LABEL_LETTERS))
            lower.set_ylabel(f"Mean\n{named_with_unit('difference', unit)}\n({level_text(difference)})")
        uppers.append(upper)
    figure.align_ylabels()
    lay_out(figure)  # which points touch follows from the layout
    for upper, groups in zip(uppers, sides, strict=True):
        draw_values(upper, groups, {})
    return figure


def _draw_difference(axes: Axes, number: Number, tested: tuple[float, float] | None) -> None:
    """Draw a difference as a stroke across its interval, which a dot would hide where the bounds are far apart.

    The interval that is held against the bounds lies behind it as a thicker line.
    """
    found = axis_values(number)
    if len(found) < 3:
        draw_difference(axes, number, 1.0, 0.0)
        return
    estimate, *ends = found
    axes.plot([1.0, 1.0], ends, color=BLACK, linewidth=_THIN, solid_capstyle="butt", zorder=5)
    if tested is not None:
        axes.plot([1.0, 1.0], tested, color=GREY, linewidth=_THICK, solid_capstyle="butt", zorder=4)
    axes.plot([1.0], [estimate], "_", color=BLACK, markersize=12.0, markeredgewidth=0.7, zorder=6)


def _tested(comparison: Comparison, control_mean: float | None) -> _Tested:
    """Return what a height was held against; bounds and interval in percent are of the control's mean."""
    item = comparison.lead.equivalence
    if item is None or (item.estimate.unit == "%" and control_mean is None):
        return _Tested()
    factor = 0.01 * (control_mean or 0.0) if item.estimate.unit == "%" else shown_unit(item.estimate.unit)[1]
    found = axis_values(item.estimate)  # estimate, low, high
    ends = (factor * found[1], factor * found[2]) if len(found) == 3 else None
    return _Tested((factor * item.low, factor * item.high), ends)


def _caption(content: ReportContent, quantity: Outcome) -> str:
    chosen = _drawn(content, quantity)
    called = swept_words(swept_factor(content))
    level = level_text(chosen[0].lead.difference) if chosen else "confidence interval"
    tested = next((item.estimate for c in chosen if (item := c.lead.equivalence) is not None), None)
    dashed = (
        ""
        if tested is None
        else f" Dashed: the bounds within which a difference counts as none; the test against them (TOST) goes by the "
        f"{level_text(tested)}, the thick grey line."
    )
    axes = (
        "all upper panels share one vertical axis, and all lower ones another"
        if quantity.has_savings
        else "the lower panels share their vertical axis, each upper one has its own"
    )
    by = "by the days that hold both" if any(c.decision is not None for c in chosen) else "by Welch"
    of_days = " Means, standard deviations and differences are those of day means." if content.counted == "day" else ""
    together = f" (all levels of the {called.coefficient} together)" if len(treated_levels(content, {})) > 1 else ""
    sides = f"{called.the_control} and of {treatment_name(content, {})}{together}"
    return (
        f"{quantity.heading}, every run of {sides}, group by group. "
        "Beside the points: mean (gap) and standard deviation (line). "
        f"Below: treatment less control (stroke) with its {level} {by} (line); {axes}.{dashed}{of_days}"
    )


def _alternative(content: ReportContent, quantity: Outcome) -> str:
    parts = []
    for comparison in _drawn(content, quantity):
        number = as_shown(comparison.lead.difference)
        size = with_unit(value_text(number.value, common_places([comparison.lead.difference])), number.unit)
        interval = interval_text(comparison.lead.difference)
        name = levels_name(content, comparison.group) or "all runs"
        runs = f"{comparison.lead.n_control} and {comparison.lead.n_treatment} {content.counted}s"
        parts.append(f"{name}: {size}{f' ({interval})' if interval else ''}, {runs}")
    return f"Single runs and the difference of {quantity}, treatment less control. {'; '.join(parts)}."


def _absent(content: ReportContent, quantity: Outcome) -> str | None:
    if _drawn(content, quantity):
        return None
    return absence_text(content, f"is no group with {quantity} of both a control and a treatment")


def _shows(content: ReportContent, quantity: Outcome) -> dict[str, object]:
    return {
        "factors": content.factors,
        "conditions": levels_alone(content, quantity),
        "comparisons": tuple(_drawn(content, quantity)),
        "counted": content.counted,
    }


ESTIMATIONS = figures_of_outcomes(
    "estimation_{}", "{}: every run, and the difference", _draw, _caption, _alternative, _absent, _shows
)
"""A figure an outcome."""
