"""Each outcome against the swept factor, say the active-damping coefficient, as in the thesis's figures 5.3 and 5.4."""

from __future__ import annotations

from data_schema.outcomes import Outcome
from reports.content import ReportContent
from reports.figures.by_damping import draw_by_damping
from reports.figures.damping_words import absent_quantity, coefficient_of, points_text, range_text
from reports.figures.kind import FigureKind


def _kind(outcome: Outcome) -> FigureKind:
    def caption(content: ReportContent) -> str:
        return f"{outcome.heading} against the {coefficient_of(content)}. {points_text(content, outcome)}"

    def alternative(content: ReportContent) -> str:
        return (
            f"Plot of {outcome} against the {coefficient_of(content)}, mean and standard error of each condition. "
            f"{range_text(content, outcome)}"
        )

    return FigureKind(
        f"{outcome.key}_by_damping",
        outcome.heading,
        lambda content, width_in: draw_by_damping(content, outcome, width_in),
        caption,
        alternative,
        lambda content: absent_quantity(content, outcome),
        outcome,
    )


BY_DAMPING = tuple(map(_kind, Outcome))
"""A figure an outcome."""
