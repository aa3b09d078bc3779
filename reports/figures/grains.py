"""Figure 3.10 of the thesis: kinetic energy of the grains over time, and the force on the foot."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures.style import BLACK, legend_below, light_grid, paper_figure
from reports.figures.thesis_jumps import MILLI, ControllerLook, mark_instant, with_looks
from simulator.grains.foot import FootMotion, GrainsJump, GrainsStudy

_AFTER_IMPACT_S = 0.01
"""At touchdown the bulk model's force has a spike of a few milliseconds, which would flatten all else."""


def draw_grains(study: GrainsStudy) -> Figure:
    """Draw a column for each size of grains: energy with both controllers, then the force with each; a line a bed."""
    sizes_m = sorted({bed.asked.diameter_m for bed in study.beds})
    motions = study.motions.ce, study.motions.ad
    of_grains = [jump.force_n.max() for bed in study.beds for jump in (bed.jumps.ce, bed.jumps.ad)]
    largest_n = float(max(*of_grains, *(one.reaction_n[one.time_s > _AFTER_IMPACT_S].max() for one in motions)))
    with paper_figure(5.2) as figure:
        grid = figure.subplots(3, len(sizes_m), sharex=True, sharey="row", squeeze=False, height_ratios=(3, 2, 2))
        for (energy, *forces), diameter_m in zip(grid.T, sizes_m, strict=True):
            beds = study.of_diameter(diameter_m)
            count = "1 bed" if len(beds) == 1 else f"{len(beds)} beds"
            energy.set_title(f"Grains of {MILLI * diameter_m:g} mm, {count}", loc="left")
            for bed in beds:
                for look, jump in with_looks(bed.jumps):
                    energy.plot(jump.time_s, jump.kinetic_j * MILLI, label=look.label, alpha=0.8, **look.line)
            for axes, (look, motion), name in zip(forces, with_looks(study.motions), ("ce", "ad"), strict=True):
                _draw_force(axes, look, motion, [getattr(bed.jumps, name) for bed in beds])
            for axes in (energy, *forces):
                mark_instant(axes, study.motions.ce.extension_time_s, "leg shortest" if axes is energy else "")
                light_grid(axes)
            forces[-1].set_xlabel("Time since touchdown (s)")
        for axes, label in zip(
            grid[:, 0], ("Kinetic energy\nof the grains (mJ)", "Force, CE (N)", "Force, AD (N)"), strict=True
        ):
            axes.set_ylabel(label)
        grid[0, 0].set_ylim(bottom=0.0)
        for row in grid[1:]:
            row[0].set_ylim(0.0, 1.05 * largest_n)
        grid[0, 0].set_xlim(0.0, float(max(one.time_s[-1] for one in motions)))
        figure.align_ylabels(grid[:, 0])
        legend_below(figure, grid.ravel(), 3, handlelength=3.2)
        return figure


def _draw_force(axes: Axes, look: ControllerLook, motion: FootMotion, jumps: list[GrainsJump]) -> None:
    for jump in jumps:
        axes.plot(jump.time_s, jump.force_n, alpha=0.8, linewidth=0.7, **look.line)
    axes.plot(motion.time_s, motion.reaction_n, color=BLACK, linestyle=":", label="bulk model")
