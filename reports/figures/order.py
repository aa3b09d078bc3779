"""Joules a jump by position in the day: does a drift show in the numbers?"""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.content import ReportContent, RunPoint
from reports.display import count_text
from reports.figures.kind import FigureKind
from reports.figures.style import BLUE, GREY, VERMILLION, is_narrow, light_grid, new_figure
from reports.naming import swept_factor, swept_words, treatment_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def _draw_days(content: ReportContent, width_in: float) -> Figure:
    """Draw every run at its position in the day: joules, and joules less the mean of its condition."""
    narrow = is_narrow(width_in)
    points = content.order.points
    called = treatment_label(content), swept_words(swept_factor(content)).control_level
    with_deviation = [point for point in points if point.deviation_j is not None]
    panels = 2 if with_deviation else 1
    figure = new_figure(width_in, (2.3 * panels if narrow else 2.7))
    grid = (panels, 1) if narrow else (1, panels)
    axes = figure.subplots(*grid, squeeze=False, sharex=True).flatten()
    _scatter(axes[0], called, points, [point.joules for point in points])
    axes[0].set_ylabel("Energy (J a jump)")
    if with_deviation:
        axes[1].axhline(0.0, color=GREY, linewidth=0.7, zorder=1)
        _scatter(axes[1], called, with_deviation, [point.deviation_j or 0.0 for point in with_deviation])
        axes[1].set_ylabel("Difference from the\ncondition's mean (J a jump)")
    for panel in axes if not narrow else axes[-1:]:
        panel.set_xlabel("Position in the day")
    if panels == 2:
        for panel, letter in zip(axes, "ab", strict=True):
            panel.set_title(letter, loc="left")
    handles, labels = axes[0].get_legend_handles_labels()
    if len(labels) > 1:
        figure.legend(handles, labels, loc="outside lower center", ncols=2, markerscale=1.6)
    return figure


def _scatter(
    axes: Axes, called: tuple[str, str], points: tuple[RunPoint, ...] | list[RunPoint], values: list[float]
) -> None:
    from matplotlib.ticker import MaxNLocator

    days = {day: index for index, day in enumerate(sorted({point.day for point in points}))}
    for control, name, colour, marker, shift in (
        (False, called[0], BLUE, "o", 0.1),
        (True, called[1], VERMILLION, "s", -0.1),
    ):
        chosen = [
            (point.position + shift + 0.3 * (days[point.day] / max(1, len(days) - 1) - 0.5), value)
            for point, value in zip(points, values, strict=True)
            if point.control is control
        ]
        if chosen:
            axes.plot(
                [x for x, _ in chosen],
                [y for _, y in chosen],
                marker,
                color=colour,
                markersize=2.8,
                alpha=0.6,
                markeredgewidth=0,
                label=name,
            )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    light_grid(axes)


def _days_caption(content: ReportContent) -> str:
    """Say what is drawn."""
    order = content.order
    count = len(order.points)
    runs = "one run" if count == 1 else f"each of {count_text(count, 'run')}"
    text = f"Energy of a jump in {runs} by its position in the day; days are spread within a position."
    if any(point.deviation_j is not None for point in order.points):
        text += " Panel a: as measured; panel b: less the mean of the run's condition."
    return text


def _days_alternative(content: ReportContent) -> str:
    """Describe the plot in words."""
    return f"Dots of joules a jump by position in the day. {' '.join(content.order.sentences)}".strip()


def _days_absent(content: ReportContent) -> str | None:
    """Give the reason where no run has a position and an energy."""
    return None if content.order.points else "No run with both a position in its day and joules a jump."


DAY_ORDER = FigureKind(
    "day_order", "Order in the day", _draw_days, _days_caption, _days_alternative, _days_absent, ("factors", "order")
)
