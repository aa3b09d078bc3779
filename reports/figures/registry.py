"""The figures of a report, in the order of the page; a new one is a file and a line here."""

from __future__ import annotations

from reports.content import ReportContent
from reports.figures.by_level import BY_LEVEL
from reports.figures.estimation import ESTIMATIONS
from reports.figures.kind import FigureKind
from reports.figures.limits_of_agreement import LIMITS_OF_AGREEMENT
from reports.figures.order import DAY_ORDER
from reports.figures.passive_drain import PASSIVE_DRAIN
from reports.figures.predictions import PREDICTIONS
from reports.figures.savings import SAVINGS
from reports.figures.sensitivity import SENSITIVITY

FIGURES: dict[str, FigureKind] = {
    kind.name: kind
    for kind in (
        SAVINGS,
        *(kind for of_outcome in zip(BY_LEVEL, ESTIMATIONS, strict=True) for kind in of_outcome),
        PREDICTIONS,
        LIMITS_OF_AGREEMENT,
        PASSIVE_DRAIN,
        DAY_ORDER,
        SENSITIVITY,
    )
}
"""Figure name -> figure; the name is also the file's."""


def figures_of(content: ReportContent) -> list[FigureKind]:
    """Return the figures of a report, those of outcomes that it has not left out."""
    return [kind for kind in FIGURES.values() if kind.outcome is None or kind.outcome in content.outcomes]
