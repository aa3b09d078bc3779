"""Apex heights by active-damping coefficient, as the thesis's figure 5.4."""

from __future__ import annotations

from matplotlib.figure import Figure

from data_schema.outcomes import Outcome
from reports.content import ReportContent
from reports.figures.by_damping import draw_by_damping
from reports.figures.damping_words import absent_quantity, coefficient_of, points_text, range_text
from reports.figures.kind import FigureKind


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw the mean apex of the body in each condition: same marks as the energy of a jump."""
    return draw_by_damping(content, Outcome.APEX, "Apex height (mm)", "m", width_in)


def caption(content: ReportContent) -> str:
    """Say what is drawn."""
    return (
        f"Height of the body at the apex of a jump against the {coefficient_of(content)}. "
        f"{points_text(content, Outcome.APEX)}"
    )


def alternative(content: ReportContent) -> str:
    """Describe the plot in words."""
    return (
        f"Plot of apex height against the {coefficient_of(content)}, mean and standard error of each "
        f"condition. {range_text(content, Outcome.APEX)}"
    )


def absent(content: ReportContent) -> str | None:
    """Give the reason where no condition has an apex."""
    return absent_quantity(content, Outcome.APEX, "apex heights")


APEX_HEIGHTS = FigureKind("apex_heights", "Apex height", draw, caption, alternative, absent)
