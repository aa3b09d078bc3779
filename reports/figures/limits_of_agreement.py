"""Differences of predictions from measurements over their mean, with limits of agreement (Bland and Altman)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.content import POOLED, Judged, Limits, ReportContent
from reports.display import as_shown, number_text
from reports.figures.kind import FigureKind
from reports.figures.style import BLACK, BLUE, PALE, is_narrow, light_grid, new_figure, plain_ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_ROW_IN, _COLUMNS = 2.4, 2


def _judged(content: ReportContent) -> list[tuple[Judged, Limits]]:
    return [(one, one.limits) for one in content.predictions.judged if one.limits is not None]


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw a panel a quantity: a dot a condition, the mean difference and both limits with their intervals."""
    found = _judged(content)
    columns = 1 if is_narrow(width_in) else min(len(found), _COLUMNS)
    rows = -(-len(found) // columns)
    figure = new_figure(width_in, _ROW_IN * rows)
    for place, (one, limits) in enumerate(found, start=1):
        _draw_panel(figure.add_subplot(rows, columns, place), content, one, limits)
    return figure


def _draw_panel(axes: Axes, content: ReportContent, one: Judged, limits: Limits) -> None:
    for number, style in ((limits.mean_difference, "-"), (limits.lower_limit, "--"), (limits.upper_limit, "--")):
        shown = as_shown(number)
        if shown.interval is not None:
            axes.axhspan(*shown.interval, color=PALE, alpha=0.5, linewidth=0)
        axes.axhline(shown.known or 0.0, color=BLACK, linestyle=style, linewidth=0.8)
    items = [item for item in content.predictions.of(one.quantity) if item.level != POOLED]
    both = [(as_shown(item.measured).known, as_shown(item.check.predicted).known) for item in items]
    pairs = [(one, other) for one, other in both if one is not None and other is not None]
    axes.plot(
        [(measured + predicted) / 2.0 for measured, predicted in pairs],
        [predicted - measured for measured, predicted in pairs],
        "o",
        color=BLUE,
        markersize=3.2,
        markeredgewidth=0,
    )
    unit = as_shown(limits.mean_difference).unit
    axes.set_xlabel(f"Mean of both, {one.quantity} ({unit})")
    axes.set_ylabel(f"Predicted less measured ({unit})")
    axes.xaxis.set_major_locator(plain_ticks())
    light_grid(axes)


def caption(_content: ReportContent) -> str:
    """Say what is drawn."""
    return (
        "Predicted less measured over the mean of both, a dot a condition (Bland and Altman): mean difference (line) "
        "and limits of agreement (dashed), each with its 95 % CI."
    )


def alternative(content: ReportContent) -> str:
    """Describe the plot in words: of each quantity the mean difference and its limits."""
    sentences = []
    for one, limits in _judged(content):
        mean, low, high = map(number_text, (limits.mean_difference, limits.lower_limit, limits.upper_limit))
        sentences.append(f"{one.quantity}: mean {mean}, limits {low} and {high}.")
    return f"Differences of predictions from measurements. {' '.join(sentences)}"


def absent(content: ReportContent) -> str | None:
    """Give the reason where there are no limits."""
    if _judged(content):
        return None
    return "No limits of agreement: fewer than three conditions were predicted."


LIMITS_OF_AGREEMENT = FigureKind(
    "limits_of_agreement", "Limits of agreement", draw, caption, alternative, absent, ("predictions",)
)
