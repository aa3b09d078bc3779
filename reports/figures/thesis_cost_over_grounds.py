"""Figure 3.11 of the thesis: cost and efficiency over the ground's stress and drag."""

from __future__ import annotations

from matplotlib.figure import Figure

from reports.figures.style import TWO_COLUMNS_IN
from reports.figures.thesis_over_grounds import draw_over_grounds
from reports.figures.thesis_over_speed import PERCENT, Compared
from reports.thesis_content import OverGrounds

CAPTION = (
    "Cost of one jump (above; Eq. 3.5) and efficiency of the motors (below) over the ground's depth-dependent "
    "stress σ and the scale b_g of its drag, with either controller, and the difference as a share of CE's value: "
    "for the cost that is the saving. Crosses mark poppy seeds."
)


def draw_cost_over_grounds(data: OverGrounds, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw cost and efficiency."""
    cost = Compared("Cost", "Cost (J)", data.ce.cost_j, data.ad.cost_j)
    efficiency = Compared("Efficiency", "Efficiency (%)", PERCENT * data.ce.efficiency, PERCENT * data.ad.efficiency)
    return draw_over_grounds(data, cost, efficiency, width_in)
