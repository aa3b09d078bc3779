"""Figure 3.9 of the thesis: apex height and mechanical energy over the initial velocity."""

from __future__ import annotations

from matplotlib.figure import Figure

from reports.figures.style import TWO_COLUMNS_IN
from reports.figures.thesis_over_speed import Compared, draw_over_speed
from reports.thesis_content import OverSpeed

CAPTION = (
    "Apex height of the body (left) and mechanical energy of the motors (right) over the downward speed of body and"
    " foot at touchdown; below, the difference of the controllers as a share of CE's value: 50 % is twice the "
    "energy. The kinks are where the leg gets so short that its guard ends the compression."
)


def draw_apex_over_speed(data: OverSpeed, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw apex height and mechanical energy."""
    apex = Compared("Apex height", "Apex height (m)", data.ce.apex_height_m, data.ad.apex_height_m)
    mechanical = Compared("Mechanical energy", "Mechanical energy (J)", data.ce.mechanical_j, data.ad.mechanical_j)
    return draw_over_speed(data.speed_m_s, apex, mechanical, width_in)
