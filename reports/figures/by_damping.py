"""A quantity against the active-damping coefficient: means with SE, every run behind them (thesis figs. 5.3, 5.4)."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from reports.content import ReportContent
from reports.display import shown_unit
from reports.figures.series import Axis, Series, axis_of, series_of
from reports.figures.style import GREY, is_narrow, light_grid, new_figure
from reports.numbers import Quantity
from reports.sentences import count_text, swept_factor

_GOLDEN_STEP = (math.sqrt(5.0) - 1.0) / 2.0


def has_quantity(content: ReportContent, quantity: Quantity) -> bool:
    """Whether any condition has a mean of the quantity."""
    summaries = (condition.summary(quantity) for condition in content.conditions)
    return any(summary is not None and isinstance(summary.mean.value, int | float) for summary in summaries)


def draw_by_damping(content: ReportContent, quantity: Quantity, y_label: str, unit: str, width_in: float) -> Figure:
    """Draw one quantity: x is the damping coefficient with CE at 0, y the quantity in the unit it is shown in."""
    narrow = is_narrow(width_in)
    figure = new_figure(width_in, 3.4 if narrow else 3.9)
    axes = figure.add_subplot()
    axis, all_series = axis_of(content), series_of(content)
    factor = shown_unit(unit)[1]
    step = _tick_distance(axis)
    for index, series in enumerate(all_series):
        shift = (index - (len(all_series) - 1) / 2) * min(0.16, 0.64 / len(all_series)) * step
        _draw_series(axes, content, series, axis, quantity, factor, (shift, step, narrow))
    axes.set_xticks(axis.ticks, axis.labels)
    axes.set_xlim(axis.ticks[0] - 0.55 * step, axis.ticks[-1] + 0.55 * step)
    axes.set_xlabel(axis.title)
    axes.set_ylabel(y_label)
    axes.margins(y=0.06)
    light_grid(axes)
    if axis.gains:
        gains = axes.secondary_xaxis("top")
        gains.set_xticks(axis.ticks, axis.gains)
        gains.set_xlabel("gain in the controller", color=GREY)
        gains.tick_params(colors=GREY, length=2)
        gains.spines["top"].set_visible(False)
    if len(all_series) > 1:
        figure.legend(
            handles=[_handle(series) for series in all_series],
            loc="outside lower center",
            ncols=1 if narrow else 2,
            handlelength=3.2,
        )
    return figure


def _tick_distance(axis: Axis) -> float:
    gaps = [after - before for before, after in zip(axis.ticks, axis.ticks[1:], strict=False)]
    return min(gaps) if gaps else 1.0


def _draw_series(
    axes: Axes,
    content: ReportContent,
    series: Series,
    axis: Axis,
    quantity: Quantity,
    factor: float,
    placing: tuple[float, float, bool],
) -> None:
    shift, step, narrow = placing
    swept = swept_factor(content)
    xs, means, errors = [], [], []
    for condition in series.conditions:
        summary = condition.summary(quantity)
        if summary is None:
            continue
        at = axis.position(condition, swept) + shift
        values = [run.value * factor for run in summary.runs]
        # A fixed spread by the golden ratio: points apart, and the same file each time.
        spread = [at + ((i * _GOLDEN_STEP) % 1.0 - 0.5) * 0.08 * step for i in range(len(values))]
        size = 2.0 if narrow else 2.6
        axes.plot(spread, values, "o", color=series.colour, alpha=0.4, markersize=size, markeredgewidth=0, zorder=2)
        if not isinstance(summary.mean.value, int | float):
            continue
        se = summary.mean.se
        xs.append(at)
        means.append(summary.mean.value * factor)
        errors.append(se * factor if isinstance(se, int | float) else math.nan)
    drawn = sorted(zip(xs, means, errors, strict=True))
    if not drawn:
        return
    axes.errorbar(
        [x for x, _, _ in drawn],
        [mean for _, mean, _ in drawn],
        yerr=[error for _, _, error in drawn],
        color=series.colour,
        linestyle=series.line_style if axis.continuous else "none",
        linewidth=0.9,
        marker="o",
        markersize=series.marker_pt * (0.75 if narrow else 1.0),
        markerfacecolor=series.colour if series.filled else "white",
        markeredgewidth=1.0,
        elinewidth=1.0,
        capsize=2.0,
        zorder=4,
    )


def _handle(series: Series) -> Line2D:
    return Line2D(
        [],
        [],
        color=series.colour,
        linestyle=series.line_style,
        marker="o",
        markersize=series.marker_pt,
        markerfacecolor=series.colour if series.filled else "white",
        label=series.label,
    )


def points_text(content: ReportContent, quantity: Quantity) -> str:
    """Say what the marks are: means, SE, single runs and how many there are, and what the bars leave out."""
    found = [(c, summary) for c in content.conditions if (summary := c.summary(quantity)) is not None]
    counts = [summary.mean.n for _, summary in found if summary.mean.n is not None]
    sentences = []
    if any(condition.control for condition, _ in found):
        sentences.append("The control, compression-extension (CE), stands at 0.")
    sentences.append("The vertical axis does not start at zero.")
    if counts:
        low, high = min(counts), max(counts)
        runs = count_text(low, "run") if low == high else f"{low} to {count_text(high, 'run')}"
        sentences.append(f"Circles: means of {runs} a condition; bars: ± 1 standard error; dots: single runs.")
    if any(summary.mean.shared_se is not None for _, summary in found):
        sentences.append("The bars leave out the uncertainty that all runs share.")
    if len(series_of(content)) > 1:
        sentences.append("Conditions at one coefficient are drawn side by side.")
    return " ".join(sentences)


def range_text(content: ReportContent, quantity: Quantity) -> str:
    """Say in words between which values the condition means lie, for a reader who cannot see the plot."""
    stored = "J" if quantity is Quantity.JOULES else "m"
    unit, factor = shown_unit(stored)
    sentences = []
    for series in series_of(content):
        parts = []
        for name, control in (("CE", True), ("active damping", False)):
            means = [
                summary.mean.value * factor
                for condition in series.conditions
                if condition.control is control
                and (summary := condition.summary(quantity)) is not None
                and isinstance(summary.mean.value, int | float)
            ]
            if means:
                low, high = min(means), max(means)
                span = f"{low:.1f}" if low == high else f"{low:.1f} to {high:.1f}"
                parts.append(f"{name} {span} {unit}")
        if parts:
            sentences.append(f"{series.label}: {', '.join(parts)}.")
    return " ".join(sentences)
