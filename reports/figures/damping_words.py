"""What is said about a plot against the swept factor: its marks, its ranges, why it is missing."""

from __future__ import annotations

from data_schema.outcomes import Outcome
from reports.content import ReportContent
from reports.display import general_text, shown_unit, stated_text
from reports.figures.series import axis_of, drawn_factor, series_lie_apart, series_of
from reports.naming import swept_factor, swept_words
from reports.sentences import absence_text
from reports.wording import count_text


def has_quantity(content: ReportContent, quantity: Outcome) -> bool:
    """Whether any condition has a mean of the quantity."""
    summaries = (condition.summary(quantity) for condition in content.conditions)
    return any(summary is not None and isinstance(summary.mean.value, int | float) for summary in summaries)


def absent_quantity(content: ReportContent, quantity: Outcome) -> str | None:
    """Give the reason why there is nothing of the quantity to draw, None where there is."""
    if has_quantity(content, quantity):
        return None
    if content.flow.runs_done and not content.flow.has_jump_runs:
        return f"There are no {quantity.plural} for this selection: none of its runs counts as one of jumps."
    return absence_text(content, f"are no {quantity.plural}")


def coefficient_of(content: ReportContent) -> str:
    """Return what the swept factor's levels are called."""
    return swept_words(drawn_factor(content)).coefficient


def points_text(content: ReportContent, quantity: Outcome) -> str:
    """Say what the marks are: means, SE, single runs and how many there are, and what the bars leave out."""
    found = [(c, summary) for c in content.conditions if (summary := c.summary(quantity)) is not None]
    counts = [summary.mean.n for _, summary in found if summary.mean.n is not None]
    sentences = []
    if any(condition.control for condition, _ in found):
        sentences.append(_control_text(content))
    sentences.append("The vertical axis does not start at zero.")
    if counts:
        low, high = min(counts), max(counts)
        runs = count_text(low, "run") if low == high else f"{low} to {count_text(high, 'run')}"
        if high == 1:
            sentences.append("Circles: the only run of a condition, which gives no standard error.")
        else:
            sentences.append(f"Circles: means of {runs} a condition; bars: ± 1 standard error; dots: single runs.")
    if any(summary.mean.shared_se is not None and (summary.mean.n or 0) > 1 for _, summary in found):
        shared_by = "the runs of a robot" if len(content.robots) > 1 else "all runs"
        sentences.append(f"The bars leave out the uncertainty that {shared_by} share.")
    if series_lie_apart(content, quantity):
        sentences.append("Each group has its panel; the vertical axes have one span but not one position.")
    elif len(series_of(content)) > 1:
        sentences.append("Conditions at one level are drawn side by side.")
    return " ".join(sentences)


def _control_text(content: ReportContent) -> str:
    """Say where the control stands: at its value, or before the levels that have none."""
    called, axis = swept_words(swept_factor(content)), axis_of(content)
    name = f"The control, {called.control_long}," if called.of_active_damping else f"The {called.control_level}"
    return f"{name} stands {f'at {stated_text(axis.control_position)}' if axis.continuous else 'first'}."


def range_text(content: ReportContent, quantity: Outcome) -> str:
    """Say in words between which values the condition means lie, for a reader who cannot see the plot."""
    unit, factor = shown_unit(quantity.unit)
    sentences = []
    swept = swept_factor(content)
    called = swept_words(swept)
    sides = (("", False),) if swept is None else ((called.control_level, True), (called.treatment, False))
    for series in series_of(content):
        parts = []
        for name, control in sides:
            means = [
                summary.mean.value * factor
                for condition in series.conditions
                if (condition.control and swept is not None) is control
                and (summary := condition.summary(quantity)) is not None
                and isinstance(summary.mean.value, int | float)
            ]
            if means:
                low, high = min(means), max(means)
                span = general_text(low) if low == high else f"{general_text(low)} to {general_text(high)}"
                parts.append(f"{name} {span} {unit}".strip())
        if parts:
            sentences.append(f"{series.label}: {', '.join(parts)}.")
    return " ".join(sentences)
