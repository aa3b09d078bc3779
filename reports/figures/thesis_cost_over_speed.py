"""Figure 3.8 of the thesis: cost and efficiency over the initial velocity."""

from __future__ import annotations

from matplotlib.figure import Figure

from reports.figures.style import TWO_COLUMNS_IN
from reports.figures.thesis_over_speed import PERCENT, Compared, draw_over_speed
from reports.thesis_content import OverSpeed

CAPTION = (
    "Cost of one jump (left; Eq. 3.5) and efficiency of the motors (right: mechanical energy over cost) over the "
    "downward speed of body and foot at touchdown; below, the difference of the controllers as a share of CE's "
    "value: for the cost that is the saving. The kinks are where the leg gets so short that its guard ends the "
    "compression."
)


def draw_cost_over_speed(data: OverSpeed, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw cost and efficiency."""
    cost = Compared("Cost of a jump", "Cost (J)", data.ce.cost_j, data.ad.cost_j)
    efficiency = Compared(
        "Efficiency of the motors", "Efficiency (%)", PERCENT * data.ce.efficiency, PERCENT * data.ad.efficiency
    )
    return draw_over_speed(data.speed_m_s, cost, efficiency, width_in)
