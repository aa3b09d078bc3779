"""Figures 3.8, 3.9 and 3.11 to 3.13 of the thesis: jumps over touchdown speed, grounds and active damping."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullLocator

from reports.display import general_text, given_text
from reports.figures.series import LineStyle
from reports.figures.style import BLACK, BLUE, GREEN, GREY, VERMILLION, legend_below, light_grid, paper_figure
from reports.figures.thesis_jumps import AD_LOOK, CE_LOOK, MILLI
from simulator.thesis.figures import BoolArray, FloatArray, Jumps, OverDamping, OverGround, OverVelocity, Pair

SHARE_LABEL = "CE − AD (% of CE)"
PERCENT = 100.0
_FLAGGED: dict[str, Any] = {"marker": "o", "markersize": 3.0, "markerfacecolor": "white", "linestyle": "none"}
"""How jumps are marked that hang on a decision or let errors grow."""
COST_OVER_SPEED_CAPTION = (
    "Cost of one jump (left; Eq. 3.5) and efficiency of the motors (right: mechanical energy over cost) over the "
    "downward speed of body and foot at touchdown; below, the difference of the controllers as a share of CE's "
    "value: for the cost that is the saving. The kinks are where the leg gets so short that its guard ends the "
    "compression."
)
APEX_OVER_SPEED_CAPTION = (
    "Apex height of the body (left) and mechanical energy of the motors (right) over the downward speed of body and"
    " foot at touchdown; below, the difference of the controllers as a share of CE's value: 50 % is twice the "
    "energy. The kinks are where the leg gets so short that its guard ends the compression."
)


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """One quantity with either controller; arrays of one shape, in the unit of the label, and which hang on little."""

    title: str
    label: str
    ce: FloatArray
    ad: FloatArray
    ce_flagged: BoolArray
    ad_flagged: BoolArray

    @property
    def share_percent(self) -> FloatArray:
        """Difference of the controllers as a share of CE's value, %."""
        return np.asarray(PERCENT * (self.ce - self.ad) / self.ce)


Quantity = tuple[str, str, Callable[[Jumps], FloatArray]]
"""A quantity of jumps: its title, its label with the unit, its values."""
COST: tuple[Quantity, Quantity] = (
    ("Cost", "Cost (J)", lambda jumps: jumps.cost_j),
    ("Efficiency", "Efficiency (%)", lambda jumps: PERCENT * jumps.efficiency),
)
"""What a jump costs, and the mechanical energy as a share of that."""
APEX: tuple[Quantity, Quantity] = (
    ("Apex", "Apex height (m)", lambda jumps: jumps.apex_height_m),
    ("Mechanical", "Mechanical (J)", lambda jumps: jumps.mechanical_j),
)
"""How high a jump gets, and the mechanical energy for it."""


def _compared(quantity: Quantity, jumps: Pair[Jumps]) -> Compared:
    (title, label, values), ce, ad = quantity, jumps.ce, jumps.ad
    return Compared(title, label, values(ce), values(ad), ce.ill_conditioned, ad.ill_conditioned)


def draw_over_speed(data: OverVelocity, quantities: tuple[Quantity, Quantity]) -> Figure:
    """Draw two quantities side by side, from 0 on, and under each the difference as a share of CE's value."""
    speed_m_s = data.touchdown_speed_m_s
    with paper_figure(3.4) as figure:
        grid = figure.subplots(2, 2, sharex=True, height_ratios=(5, 4))
        for (above, below), each in zip(grid.T, quantities, strict=True):
            quantity = _compared(each, data.jumps)
            either = (CE_LOOK, quantity.ce, quantity.ce_flagged), (AD_LOOK, quantity.ad, quantity.ad_flagged)
            for look, values, flagged in either:
                above.plot(speed_m_s, values, label=look.label, **look.line)
                above.plot(speed_m_s[flagged], values[flagged], color=look.colour, **_FLAGGED)
            above.set_title(quantity.title, loc="left")
            above.set_ylabel(quantity.label)
            above.set_ylim(0.0, 1.08 * float(np.nanmax([quantity.ce, quantity.ad])))
            _draw_share(below, speed_m_s, quantity.share_percent)
            below.set_xlim(0.0, float(speed_m_s[-1]))
            below.set_xlabel("Touchdown speed (m/s)")
            light_grid(above)
        grid[1, 0].set_ylabel(SHARE_LABEL)
        figure.align_ylabels(grid[:, 0])
        hanging = {"ill-conditioned": Line2D([], [], color=BLACK, **_FLAGGED)}
        legend_below(figure, [grid[0, 0]], 3, hanging, handlelength=3.2)
        return figure


def _draw_share(axes: Axes, speed_m_s: FloatArray, share_percent: FloatArray) -> None:
    axes.plot(speed_m_s, share_percent, color=BLACK)
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    low, high = float(np.nanmin(share_percent)), float(np.nanmax(share_percent))
    room = 0.12 * max(high - min(low, 0.0), 1.0)
    axes.set_ylim(min(low - room, -room), max(high + room, room))
    light_grid(axes)


_STRESS_UNIT_N_M3 = 1e5
_VALUES, _DIFFERENCES = "viridis", "PuOr"
"""Colour maps that the colour-blind can read: values from dark to light, differences of either sign from white."""
COST_OVER_GROUNDS_CAPTION = (
    "Cost of one jump (above; Eq. 3.5) and efficiency of the motors (below) over the ground's depth-dependent "
    "stress σ and the scale b_g of its drag, with either controller, and the difference as a share of CE's value: "
    "for the cost that is the saving. Crosses mark poppy seeds, dots ill-conditioned jumps."
)
APEX_OVER_GROUNDS_CAPTION = (
    "Apex height of the body (above) and mechanical energy of the motors (below) over the ground's depth-dependent "
    "stress σ and the scale b_g of its drag, with either controller, and the difference as a share of CE's value: "
    "50 % is twice the energy. Crosses mark poppy seeds, dots ill-conditioned jumps."
)


def draw_over_grounds(grounds: OverGround, quantities: tuple[Quantity, Quantity]) -> Figure:
    """Draw CE, AD and their relative difference for either quantity; CE and AD have one scale of colours."""
    with paper_figure(4.0) as figure:
        grid = figure.subplots(2, 3, sharex=True, sharey=True)
        for (*values, difference), each in zip(grid, quantities, strict=True):
            _draw_quantity(figure, grounds, _compared(each, grounds.jumps), values, difference)
        for axes in grid[:, 0]:
            axes.set_ylabel("Drag scale b_g")
        for axes in grid[-1]:
            axes.set_xlabel("Stress σ (10⁵ N/m³)")
        return figure


def _draw_quantity(
    figure: Figure, grounds: OverGround, quantity: Compared, values: list[Axes], difference: Axes
) -> None:
    both = (quantity.ce, quantity.ad)
    scale = Normalize(float(np.nanmin(both)), float(np.nanmax(both)))
    drawn = [_draw_map(axes, grounds, part, _VALUES, scale) for axes, part in zip(values, both, strict=True)]
    for axes, flagged in zip(values, (quantity.ce_flagged, quantity.ad_flagged), strict=True):
        place, drag = np.nonzero(flagged)
        stress = grounds.sigma_n_m3[place] / _STRESS_UNIT_N_M3
        axes.plot(stress, grounds.drag_scale[drag], ".", color="white", markersize=1.5, markeredgewidth=0.0)
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


JOULES_BY_DAMPING_CAPTION = (
    "Cost of one jump over the coefficient of active damping (0: compression-extension, dots), for feet of three "
    "radii, a soft (dashed) and a stiff (solid) extension, on grounds of half, of all and of twice the stiffness. "
    "Lines have the ground's own drag; the bands reach from half to twice of it."
)
_FOOT_COLOURS = (BLUE, GREEN, VERMILLION)
_GAIN_STYLES: tuple[LineStyle, ...] = ("--", "-")


def draw_joules_by_damping(costs: OverDamping) -> Figure:
    """Draw a panel for each stiffness of the ground, all on one scale, with bands over its drag."""
    with paper_figure(2.9) as figure:
        panels = figure.subplots(1, len(costs.stiffness_factors), sharex=True, sharey=True)
        own = costs.drag_factors.index(1.0)
        for row, axes in enumerate(panels):
            for gain, foot in itertools.product(range(len(costs.extension_gains)), range(len(costs.foot_radii_m))):
                over_drag_j = costs.jumps.cost_j[row, :, gain, foot]
                cost_j, colour = over_drag_j[own], _FOOT_COLOURS[foot % len(_FOOT_COLOURS)]
                style = _GAIN_STYLES[gain % len(_GAIN_STYLES)]
                band = over_drag_j.min(axis=0), over_drag_j.max(axis=0)
                axes.fill_between(costs.active_damping_kg_m, *band, color=colour, alpha=0.15, linewidth=0.0)
                axes.plot(costs.active_damping_kg_m, cost_j, color=colour, linestyle=style)
                axes.plot(costs.active_damping_kg_m[0], cost_j[0], "o", color=colour, markersize=2.5, clip_on=False)
            axes.set_title(f"stiffness × {given_text(costs.stiffness_factors[row])}", loc="left")
            axes.set_xlim(0.0, float(costs.active_damping_kg_m[-1]))
            light_grid(axes)
            axes.set_xlabel("b_AD (kg/m)")
        panels[0].set_ylabel("Cost (J)")
        panels[0].set_ylim(0.0, 1.05 * float(np.nanmax(costs.jumps.cost_j)))
        figure.legend(handles=_handles(costs), loc="outside lower center", ncols=5, handlelength=2.2)
        return figure


def _handles(costs: OverDamping) -> list[Line2D]:
    feet = [
        Line2D([], [], color=_FOOT_COLOURS[place % len(_FOOT_COLOURS)], label=f"foot radius {radius_m * MILLI:.0f} mm")
        for place, radius_m in enumerate(costs.foot_radii_m)
    ]
    gains = [
        Line2D(
            [],
            [],
            color=BLACK,
            linestyle=_GAIN_STYLES[place % len(_GAIN_STYLES)],
            label=f"gain {given_text(gain)} ({general_text(stiffness)} N/m)",
        )
        for place, (gain, stiffness) in enumerate(
            zip(costs.extension_gains, costs.extension_stiffnesses_n_m, strict=True)
        )
    ]
    return [*feet, *gains]
