"""Figure 3.2 of the thesis: the ground's stiffness, drag and added mass over depth."""

from __future__ import annotations

from matplotlib.figure import Figure

from reports.figures.style import BLACK, GREY, TWO_COLUMNS_IN, is_narrow, light_grid, new_figure, publication_style
from reports.figures.thesis_style import MILLI
from simulator.thesis.ground import GroundFunctions

CAPTION = (
    "Stiffness function K, inertial drag D and added mass of the simulated grains over the depth of the foot. The "
    "dotted line is where the cone of grains under the foot is complete: from there on K is linear and D constant."
)


def draw_ground_functions(curves: GroundFunctions, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw the three functions side by side; one above the other in a narrow figure."""
    panels = (
        ("Stiffness function", "K (N)", curves.resistance_n),
        ("Inertial drag", "D (kg/m)", curves.drag_kg_m),
        ("Added mass", "Added mass (g)", curves.added_mass_kg * MILLI),
    )
    with publication_style():
        narrow = is_narrow(width_in)
        figure = new_figure(width_in, 5.2 if narrow else 2.1)
        grid = figure.subplots(3, 1, sharex=True) if narrow else figure.subplots(1, 3)
        for axes, (title, label, values) in zip(grid, panels, strict=True):
            axes.plot(curves.depth_m * MILLI, values, color=BLACK)
            axes.axvline(curves.cone_depth_m * MILLI, color=GREY, linewidth=0.8, linestyle=":")
            axes.set_title(title, loc="left")
            axes.set_ylabel(label)
            axes.set_xlim(0.0, float(curves.depth_m[-1]) * MILLI)
            axes.set_ylim(bottom=0.0)
            light_grid(axes)
            if axes is grid[-1] or not narrow:
                axes.set_xlabel("Depth (mm)")
        grid[0].annotate(
            "cone complete",
            (curves.cone_depth_m * MILLI, 0.04),
            xycoords=grid[0].get_xaxis_transform(),
            xytext=(4, 0),
            textcoords="offset points",
            fontsize=7,
            color=GREY,
        )
        return figure
