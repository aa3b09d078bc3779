"""Figure 3.4 of the thesis: body and toe of one jump with either controller."""

from __future__ import annotations

from matplotlib.figure import Figure

from reports.figures.style import GREY, TWO_COLUMNS_IN, is_narrow, light_grid, new_figure, publication_style
from reports.figures.thesis_style import AD_LOOK, CE_LOOK, MILLI, mark_instant
from simulator.thesis.motions import Motion, Pair

CAPTION = (
    "Body and toe of one jump. Both controllers are one until the leg switches to its stiff extension; then "
    "compression-extension drives the toe further into the ground than active damping does. Heights are above the "
    "undisturbed ground; dots mark lift-off. After it the toe may dip by up to a millimetre below the print that it "
    "has left: the leg's soft gains press it down for an instant, and contact is looked for only once it has risen."
)


def draw_body_and_toe(paths: Pair[Motion], width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw the body's height above, the toe's below, over one time."""
    with publication_style():
        figure = new_figure(width_in, 3.6)
        body, toe = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        end_s = max(float(path.time_s[-1]) for path in (paths.ce, paths.ad))
        for look, path in ((CE_LOOK, paths.ce), (AD_LOOK, paths.ad)):
            style = {"color": look.colour, "linestyle": look.line_style}
            body.plot(path.time_s, path.body_height_m * MILLI, label=look.label, **style)
            toe.plot(path.time_s, path.foot_height_m * MILLI, **style)
            left = int((path.time_s >= path.liftoff_time_s).argmax())
            for axes, heights in ((body, path.body_height_m), (toe, path.foot_height_m)):
                axes.plot(
                    path.time_s[left], heights[left] * MILLI, "o", color=look.colour, markersize=3.5, clip_on=False
                )
        toe.axhline(0.0, color=GREY, linewidth=0.5)
        for axes, words in ((body, "switch to extension"), (toe, "")):
            mark_instant(axes, paths.ce.switch_time_s, words)
            axes.set_xlim(0.0, end_s)
            light_grid(axes)
        body.set_ylabel("Body (mm)")
        toe.set_ylabel("Toe (mm)")
        toe.set_xlabel("Time since touchdown (s)")
        figure.align_ylabels([body, toe])
        figure.legend(loc="outside lower center", ncols=1 if is_narrow(width_in) else 2, handlelength=3.2)
        return figure
