"""The figures of a report, in the order of the page; a new one is a file and a line here."""

from __future__ import annotations

from reports.figures.apex_heights import APEX_HEIGHTS
from reports.figures.day_order import DAY_ORDER
from reports.figures.estimation_of_report import ESTIMATION_APEX, ESTIMATION_JOULES
from reports.figures.flow import FLOW
from reports.figures.joules_by_damping import JOULES_BY_DAMPING
from reports.figures.kind import FigureKind
from reports.figures.packs import PACKS
from reports.figures.passive_drain import PASSIVE_DRAIN
from reports.figures.predictions import PREDICTIONS
from reports.figures.savings import SAVINGS
from reports.figures.sensitivity import SENSITIVITY

FIGURES: dict[str, FigureKind] = {
    kind.name: kind
    for kind in (
        SAVINGS,
        JOULES_BY_DAMPING,
        ESTIMATION_JOULES,
        APEX_HEIGHTS,
        ESTIMATION_APEX,
        PREDICTIONS,
        FLOW,
        PASSIVE_DRAIN,
        DAY_ORDER,
        PACKS,
        SENSITIVITY,
    )
}
"""Figure name -> figure; the name is also the file's."""
