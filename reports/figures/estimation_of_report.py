"""Estimation plots of a report: every run of control and treatment, group by group, and below them the difference."""

from __future__ import annotations

import statistics
from typing import TYPE_CHECKING

from data_schema.outcomes import Outcome
from reports.content import ReportContent
from reports.display import as_shown, common_places, interval_text, level_text, value_text, with_unit
from reports.evidence import Comparison
from reports.figures.estimation import Estimation, EstimationGroup, axis_values, draw_estimations
from reports.figures.kind import absence_text, figures_of_outcomes
from reports.naming import levels_name, swept_factor, swept_words, treated_levels, treatment_label, treatment_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
            values[0 if condition.control else 1].extend(run.value for run in summary.runs)
    names = swept_words(swept_factor(content)).control, treatment_label(content)
    bounds: tuple[float, ...] = ()
    tested = None
    item, control = comparison.decision.equivalence, values[0]
    if item is not None and control:
        of_mean = 0.01 * statistics.fmean(control) if item.estimate.unit == "%" else 1.0
        bounds = of_mean * item.low, of_mean * item.high
        found = [of_mean * value for value in axis_values(item.estimate)]  # estimate, low, high
        tested = (found[1], found[2]) if len(found) == 3 else None
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
    level = level_text(chosen[0].decision.difference) if chosen else "confidence interval"
    tested = next((item.estimate for c in chosen if (item := c.decision.equivalence) is not None), None)
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
        number = as_shown(comparison.decision.difference)
        size = with_unit(value_text(number.value, common_places([comparison.decision.difference])), number.unit)
        interval = interval_text(comparison.decision.difference)
        name = levels_name(content, comparison.group) or "all runs"
        runs = f"{comparison.decision.n_control} and {comparison.decision.n_treatment} runs"
        parts.append(f"{name}: {size}{f' ({interval})' if interval else ''}, {runs}")
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
