"""Joules a jump by active-damping coefficient, as the thesis's figure 5.3."""

from __future__ import annotations

from matplotlib.figure import Figure

from data_schema.outcomes import Outcome
from reports.content import ReportContent
from reports.figures.by_damping import draw_by_damping
from reports.figures.damping_words import absent_quantity, coefficient_of, points_text, range_text
from reports.figures.kind import FigureKind


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw the energy of a jump: circle size by foot radius, line style by extension stiffness, SE bars."""
    return draw_by_damping(content, Outcome.JOULES, "Energy (J a jump)", "J", width_in)


def caption(content: ReportContent) -> str:
    """Say what is drawn."""
    return f"Energy of a jump against the {coefficient_of(content)}. {points_text(content, Outcome.JOULES)}"


def alternative(content: ReportContent) -> str:
    """Describe the plot in words."""
    return (
        f"Plot of joules a jump against the {coefficient_of(content)}, mean and standard error of each "
        f"condition. {range_text(content, Outcome.JOULES)}"
    )


def absent(content: ReportContent) -> str | None:
    """Give the reason where no condition has an energy."""
    return absent_quantity(content, Outcome.JOULES, "joules a jump")


JOULES_BY_DAMPING = FigureKind("joules_by_damping", "Energy of a jump", draw, caption, alternative, absent)
