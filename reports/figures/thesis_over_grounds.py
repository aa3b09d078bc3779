"""Figures 3.11 and 3.12 of the thesis: two quantities of jumps as maps over the ground's stress and drag."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from reports.figures.style import BLACK, TWO_COLUMNS_IN, is_narrow, new_figure, publication_style
from reports.figures.thesis_over_speed import PERCENT, SHARE_LABEL, Compared
from simulator.thesis.comparisons import FloatArray, OverGround

_STRESS_UNIT_N_M3 = 1e5
_VALUES, _DIFFERENCES = "cividis", "PuOr"
"""Colour maps that the colour-blind can read: values from dark to light, differences of either sign from white."""
COST_CAPTION = (
    "Cost of one jump (above; Eq. 3.5) and efficiency of the motors (below) over the ground's depth-dependent "
    "stress σ and the scale b_g of its drag, with either controller, and the difference as a share of CE's value: "
    "for the cost that is the saving. Crosses mark poppy seeds."
)
APEX_CAPTION = (
    "Apex height of the body (above) and mechanical energy of the motors (below) over the ground's depth-dependent "
    "stress σ and the scale b_g of its drag, with either controller, and the difference as a share of CE's value: "
    "50 % is twice the energy. Crosses mark poppy seeds."
)


def draw_cost_over_grounds(data: OverGround, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw cost and efficiency."""
    ce, ad = data.jumps.ce, data.jumps.ad
    cost = Compared("Cost", "Cost (J)", ce.cost_j, ad.cost_j)
    efficiency = Compared("Efficiency", "Efficiency (%)", PERCENT * ce.efficiency, PERCENT * ad.efficiency)
    return _draw(data, cost, efficiency, width_in)


def draw_apex_over_grounds(data: OverGround, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw apex height and mechanical energy."""
    ce, ad = data.jumps.ce, data.jumps.ad
    apex = Compared("Apex", "Apex height (m)", ce.apex_height_m, ad.apex_height_m)
    mechanical = Compared("Mechanical", "Mechanical (J)", ce.mechanical_j, ad.mechanical_j)
    return _draw(data, apex, mechanical, width_in)


def _draw(grounds: OverGround, above: Compared, below: Compared, width_in: float) -> Figure:
    """Draw CE, AD and their relative difference for either quantity; CE and AD have one scale of colours.

    A narrow figure has the differences below the values.
    """
    with publication_style():
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 5.6 if narrow else 4.0)
        shape = (4, 2) if narrow else (2, 3)
        grid = figure.subplots(*shape, sharex=True, sharey=True, squeeze=False)
        for number, quantity in enumerate((above, below)):
            values = list(grid[2 * number] if narrow else grid[number, :2])
            difference = grid[2 * number + 1, 0] if narrow else grid[number, 2]
            _draw_quantity(figure, grounds, quantity, values, difference)
        for axes in grid[:, 0]:
            axes.set_ylabel("Drag scale b_g")
        for axes in grid[-1]:
            axes.set_xlabel("Stress σ (10⁵ N/m³)")
        if narrow:
            for axes in grid[1::2, 1]:
                axes.set_visible(False)
        return figure


def _draw_quantity(
    figure: Figure, grounds: OverGround, quantity: Compared, values: list[Axes], difference: Axes
) -> None:
    both = (quantity.ce, quantity.ad)
    scale = Normalize(float(np.nanmin(both)), float(np.nanmax(both)))
    drawn = [_draw_map(axes, grounds, part, _VALUES, scale) for axes, part in zip(values, both, strict=True)]
    figure.colorbar(drawn[0], ax=values, label=quantity.label, aspect=15, pad=0.02)
    share = quantity.share_percent
    low, high = float(np.nanmin(share)), float(np.nanmax(share))
    most = max(-low, high)
    either_way = low < 0.0 < high
    map_scale = TwoSlopeNorm(0.0, -most, most) if either_way else Normalize(low, high)
    mesh = _draw_map(difference, grounds, share, _DIFFERENCES if either_way else _VALUES, map_scale)
    bar = figure.colorbar(mesh, ax=difference, label=SHARE_LABEL, aspect=15, pad=0.02)
    bar.ax.set_ylim(low, high)
    for axes, words in zip((*values, difference), ("CE", "AD", "difference"), strict=True):
        axes.set_title(f"{quantity.title}: {words}", loc="left", fontsize=7)


def _draw_map(axes: Axes, grounds: OverGround, values: FloatArray, colours: str, scale: Normalize) -> QuadMesh:
    stress, drag = grounds.sigma_n_m3 / _STRESS_UNIT_N_M3, grounds.drag_scale
    mesh = axes.pcolormesh(stress, drag, values.T, cmap=colours, norm=scale, shading="nearest")
    mesh.set_edgecolor("face")  # no seams between the cells in a PDF
    nominal = grounds.nominal_sigma_n_m3 / _STRESS_UNIT_N_M3, grounds.nominal_drag_scale
    axes.plot(*nominal, "+", color=BLACK, markersize=7, markeredgewidth=1.2)
    axes.plot(*nominal, "+", color="white", markersize=5.5, markeredgewidth=0.5)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis, ends, middle in ((axes.xaxis, stress, nominal[0]), (axes.yaxis, drag, nominal[1])):
        ticks = [float(ends[0]), middle, float(ends[-1])]
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(lambda value, _place: f"{value:.3g}")
    return mesh
