"""Figures 3.8 and 3.9 of the thesis: two quantities of jumps over the speed at touchdown, with either controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures.style import BLACK, GREY, TWO_COLUMNS_IN, is_narrow, light_grid, new_figure, publication_style
from reports.figures.thesis_style import AD_LOOK, CE_LOOK
from simulator.thesis.comparisons import FloatArray, OverVelocity

SHARE_LABEL = "CE − AD (% of CE)"
PERCENT = 100.0
COST_CAPTION = (
    "Cost of one jump (left; Eq. 3.5) and efficiency of the motors (right: mechanical energy over cost) over the "
    "downward speed of body and foot at touchdown; below, the difference of the controllers as a share of CE's "
    "value: for the cost that is the saving. The kinks are where the leg gets so short that its guard ends the "
    "compression."
)
APEX_CAPTION = (
    "Apex height of the body (left) and mechanical energy of the motors (right) over the downward speed of body and"
    " foot at touchdown; below, the difference of the controllers as a share of CE's value: 50 % is twice the "
    "energy. The kinks are where the leg gets so short that its guard ends the compression."
)


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """One quantity with either controller; arrays of one shape, in the unit of the label."""

    title: str
    label: str
    ce: FloatArray
    ad: FloatArray

    @property
    def share_percent(self) -> FloatArray:
        """Difference of the controllers as a share of CE's value, %."""
        return np.asarray(PERCENT * (self.ce - self.ad) / self.ce)


def draw_cost_over_speed(data: OverVelocity, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw cost and efficiency."""
    ce, ad = data.jumps.ce, data.jumps.ad
    cost = Compared("Cost of a jump", "Cost (J)", ce.cost_j, ad.cost_j)
    efficiency = Compared(
        "Efficiency of the motors",
        "Efficiency (%)",
        PERCENT * ce.efficiency,
        PERCENT * ad.efficiency,
    )
    return _draw(data.touchdown_speed_m_s, cost, efficiency, width_in)


def draw_apex_over_speed(data: OverVelocity, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw apex height and mechanical energy."""
    ce, ad = data.jumps.ce, data.jumps.ad
    apex = Compared("Apex height", "Apex height (m)", ce.apex_height_m, ad.apex_height_m)
    mechanical = Compared("Mechanical energy", "Mechanical energy (J)", ce.mechanical_j, ad.mechanical_j)
    return _draw(data.touchdown_speed_m_s, apex, mechanical, width_in)


def _draw(speed_m_s: FloatArray, left: Compared, right: Compared, width_in: float) -> Figure:
    """Draw two quantities side by side, from 0 on, and under each the difference as a share of CE's value."""
    with publication_style():
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 3.6 if narrow else 3.4)
        grid = figure.subplots(2, 2, sharex=True, height_ratios=(5, 4))
        for (above, below), quantity in zip(grid.T, (left, right), strict=True):
            for look, values in ((CE_LOOK, quantity.ce), (AD_LOOK, quantity.ad)):
                above.plot(speed_m_s, values, color=look.colour, linestyle=look.line_style, label=look.label)
            above.set_title(quantity.title, loc="left")
            above.set_ylabel(quantity.label)
            above.set_ylim(0.0, 1.08 * float(np.nanmax([quantity.ce, quantity.ad])))
            _draw_share(below, speed_m_s, quantity.share_percent)
            below.set_xlim(0.0, float(speed_m_s[-1]))
            below.set_xlabel("Touchdown speed (m/s)")
            light_grid(above)
        grid[1, 0].set_ylabel(SHARE_LABEL)
        figure.align_ylabels(grid[:, 0])
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=1 if narrow else 2, handlelength=3.2)
        return figure


def _draw_share(axes: Axes, speed_m_s: FloatArray, share_percent: FloatArray) -> None:
    axes.plot(speed_m_s, share_percent, color=BLACK)
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    low, high = float(np.nanmin(share_percent)), float(np.nanmax(share_percent))
    room = 0.12 * max(high - min(low, 0.0), 1.0)
    axes.set_ylim(min(low - room, -room), max(high + room, room))
    light_grid(axes)
