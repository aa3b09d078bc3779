"""Figure 3.12 of the thesis: apex height and mechanical energy over the ground's stress and drag."""

from __future__ import annotations

from matplotlib.figure import Figure

from reports.figures.style import TWO_COLUMNS_IN
from reports.figures.thesis_over_grounds import draw_over_grounds
from reports.figures.thesis_over_speed import Compared
from reports.thesis_content import OverGrounds

CAPTION = (
    "Apex height of the body (above) and mechanical energy of the motors (below) over the ground's depth-dependent "
    "stress σ and the scale b_g of its drag, with either controller, and the difference as a share of CE's value: "
    "50 % is twice the energy. Crosses mark poppy seeds."
)


def draw_apex_over_grounds(data: OverGrounds, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw apex height and mechanical energy."""
    apex = Compared("Apex", "Apex height (m)", data.ce.apex_height_m, data.ad.apex_height_m)
    mechanical = Compared("Mechanical", "Mechanical (J)", data.ce.mechanical_j, data.ad.mechanical_j)
    return draw_over_grounds(data, apex, mechanical, width_in)
