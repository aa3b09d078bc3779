"""Estimation plots of a report: every run of control and treatment, group by group, and below them the difference."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from data_schema.vocabulary import Undefined
from reports.content import Comparison, ReportContent
from reports.display import as_shown, common_places, interval_text, level_text, shown_unit, value_text, with_unit
from reports.figures.estimation_parts import (
    DrawnGroup,
    draw_difference,
    draw_values,
    ends_of,
    named_with_unit,
    set_limits,
    set_names,
)
from reports.figures.kind import FigureKind
from reports.figures.style import BLACK, BLUE, GREY, VERMILLION, is_narrow, light_grid, new_figure
from reports.inference import Side
from reports.naming import levels_name, swept_factor, swept_words
from reports.numbers import Quantity
from reports.sentences import absence_text
from reports.tables.table import STORED_UNITS

_ROW_IN = 3.0
_TITLES = {Quantity.JOULES: "Energy of a jump", Quantity.APEX: "Apex height"}


def pooled(content: ReportContent, quantity: Quantity) -> list[Comparison]:
    """Return the comparisons that are drawn: all treated levels of a group against its control."""
    factors = max((len(comparison.group) for comparison in content.comparisons), default=0)
    return [
        comparison
        for comparison in content.comparisons
        if comparison.quantity is quantity and comparison.opens and len(comparison.group) == factors
    ]


def _sides(content: ReportContent, comparison: Comparison) -> tuple[DrawnGroup, DrawnGroup]:
    """Return the runs of control and treatment with their mean and SD, in the unit that is shown."""
    called = swept_words(swept_factor(content))
    factor = shown_unit(STORED_UNITS[comparison.quantity])[1]
    names = (called.control, called.treatment_short)
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


def _draw(content: ReportContent, width_in: float, quantity: Quantity) -> Figure:
    """Draw a pair of panels a group, values above and difference below; those of a row share the lower axis."""
    chosen = pooled(content, quantity)
    across = min(len(chosen), 2 if is_narrow(width_in) else 4)
    rows = -(-len(chosen) // across)
    figure = new_figure(width_in, _ROW_IN * rows)
    grid = figure.subplots(2 * rows, across, squeeze=False, gridspec_kw={"height_ratios": (3, 2) * rows})
    for axes in grid.flat:
        axes.set_visible(False)
    sides = [_sides(content, comparison) for comparison in chosen]
    bounds = [_bounds(comparison, control.mean) for comparison, (control, _) in zip(chosen, sides, strict=True)]
    below = [end for comparison in chosen for end in ends_of(as_shown(comparison.welch_difference))]
    below += [0.0, *(bound for both in bounds for bound in both)]
    uppers = []
    for place, (comparison, groups) in enumerate(zip(chosen, sides, strict=True)):
        row, column = divmod(place, across)
        upper, lower = grid[2 * row][column], grid[2 * row + 1][column]
        difference = as_shown(comparison.welch_difference)
        for axes in (upper, lower):
            axes.set_visible(True)
            axes.set_xlim(-0.6, 1.6)
            light_grid(axes)
        set_limits(upper, [value for group in groups for value in group.values])
        set_limits(lower, below)
        upper.set_xticks([])
        upper.set_title(levels_name(content, comparison.group).replace(", ", "\n") or "all runs", fontsize=7)
        set_names(lower, groups, (), width_in / across)
        lower.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
        for bound in bounds[place]:
            lower.axhline(bound, color=BLACK, linewidth=0.8, linestyle="--", zorder=2)
        draw_difference(lower, difference, 1.0, 0.0)
        if column == 0:
            unit = difference.unit
            upper.set_ylabel(named_with_unit(_TITLES[quantity], unit))
            lower.set_ylabel(f"{named_with_unit('Difference', unit)}\n({level_text(difference)})")
        uppers.append(upper)
    figure.align_ylabels()
    figure.draw_without_rendering()  # which points touch follows from the layout
    for upper, groups in zip(uppers, sides, strict=True):
        draw_values(upper, groups, {})
    return figure


def _bounds(comparison: Comparison, control_mean: float | None) -> tuple[float, ...]:
    """Return the bounds of equivalence in the unit that is shown; those in percent are of the control's mean."""
    item = comparison.equivalence
    if item is None:
        return ()
    if item.estimate.unit != "%":
        factor = shown_unit(item.estimate.unit)[1]
        return factor * item.low, factor * item.high
    return () if control_mean is None else (0.01 * control_mean * item.low, 0.01 * control_mean * item.high)


def _caption(content: ReportContent, quantity: Quantity) -> str:
    chosen = pooled(content, quantity)
    called = swept_words(swept_factor(content))
    level = level_text(chosen[0].welch_difference) if chosen else "confidence interval"
    dashed = (
        " Dashed: the bounds within which a difference counts as none."
        if any(c.equivalence is not None for c in chosen)
        else ""
    )
    of_days = " Means, standard deviations and differences are those of day means." if content.counted == "day" else ""
    return (
        f"{_TITLES[quantity]}, every run of {called.control_long} and of {called.treatment} (all levels of the "
        f"{called.coefficient} together), group by group. Beside the points: mean (gap) and standard deviation (line). "
        f"Below: treatment less control with its {level} by Welch; the panels share this axis.{dashed}{of_days}"
    )


def _alternative(content: ReportContent, quantity: Quantity) -> str:
    parts = []
    for comparison in pooled(content, quantity):
        number = as_shown(comparison.welch_difference)
        size = with_unit(value_text(number.value, common_places([comparison.welch_difference])), number.unit)
        interval = interval_text(comparison.welch_difference)
        name = levels_name(content, comparison.group) or "all runs"
        runs = f"{comparison.n_control} and {comparison.n_treatment} {content.counted}s"
        parts.append(f"{name}: {size}{f' ({interval})' if interval else ''}, {runs}")
    return f"Single runs and the difference of {quantity}, treatment less control. {'; '.join(parts)}."


def _absent(content: ReportContent, quantity: Quantity) -> str | None:
    if pooled(content, quantity):
        return None
    return absence_text(content, f"is no group with {quantity} of both a control and a treatment")


def _kind(quantity: Quantity, name: str) -> FigureKind:
    def of(function: Callable[[ReportContent, Quantity], str]) -> Callable[[ReportContent], str]:
        return lambda content: function(content, quantity)

    return FigureKind(
        name,
        f"{_TITLES[quantity]}: every run, and the difference",
        lambda content, width_in: _draw(content, width_in, quantity),
        of(_caption),
        of(_alternative),
        lambda content: _absent(content, quantity),
    )


ESTIMATION_JOULES = _kind(Quantity.JOULES, "estimation_joules")
ESTIMATION_APEX = _kind(Quantity.APEX, "estimation_apex")
