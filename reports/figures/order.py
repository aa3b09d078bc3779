"""Joules a jump by position in the day: does a drift show in the numbers?"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from data_schema.outcomes import Outcome
from reports.content import ReportContent, Run, joule_deviations
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
    points = _points(content)
    called = treatment_label(content), swept_words(swept_factor(content)).control_level
    figure = new_figure(width_in, (4.6 if narrow else 2.7))
    axes = figure.subplots(*((2, 1) if narrow else (1, 2)), squeeze=False, sharex=True).flatten()
    _scatter(axes[0], called, points, [point.joules for point in points])
    axes[0].set_ylabel("Energy (J a jump)")
    axes[1].axhline(0.0, color=GREY, linewidth=0.7, zorder=1)
    _scatter(axes[1], called, points, [point.deviation_j for point in points])
    axes[1].set_ylabel("Difference from the\ncondition's mean (J a jump)")
    for panel in axes if not narrow else axes[-1:]:
        panel.set_xlabel("Position in the day")
    for panel, letter in zip(axes, "ab", strict=True):
        panel.set_title(letter, loc="left")
    handles, labels = axes[0].get_legend_handles_labels()
    if len(labels) > 1:
        figure.legend(handles, labels, loc="outside lower center", ncols=2, markerscale=1.6)
    return figure


class _Point(NamedTuple):
    """A run with its joules a jump, and these less the mean of its condition."""

    run: Run
    control: bool
    joules: float
    deviation_j: float


def _points(content: ReportContent) -> list[_Point]:
    return [
        _Point(content.runs[run], condition.control, joules, deviations[run])
        for condition in content.conditions
        for deviations in [joule_deviations(condition)]
        if (summary := condition.summary(Outcome.JOULES)) is not None
        for run, joules in summary.runs
    ]


def _scatter(axes: Axes, called: tuple[str, str], points: list[_Point], values: list[float]) -> None:
    from matplotlib.ticker import MaxNLocator

    days = {day: index for index, day in enumerate(sorted({point.run.day for point in points}))}
    for control, name, colour, marker, shift in (
        (False, called[0], BLUE, "o", 0.1),
        (True, called[1], VERMILLION, "s", -0.1),
    ):
        chosen = [
            (point.run.position + shift + 0.3 * (days[point.run.day] / max(1, len(days) - 1) - 0.5), value)
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
    count = len(_points(content))
    runs = "one run" if count == 1 else f"each of {count_text(count, 'run')}"
    return (
        f"Energy of a jump in {runs} by its position in the day; days are spread within a position. Panel a: as "
        "measured; panel b: less the mean of the run's condition."
    )


def _days_alternative(content: ReportContent) -> str:
    """Describe the plot in words."""
    return f"Dots of joules a jump by position in the day. {' '.join(content.confounded)}".strip()


def _days_absent(content: ReportContent) -> str | None:
    """Give the reason where no run has a position and an energy."""
    return None if _points(content) else "No run with both a position in its day and joules a jump."


DAY_ORDER = FigureKind(
    "day_order",
    "Order in the day",
    _draw_days,
    _days_caption,
    _days_alternative,
    _days_absent,
    ("factors", "conditions", "runs"),
    Outcome.JOULES,
)
