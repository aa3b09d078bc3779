"""Each outcome against the swept factor: means with their intervals, every run behind them (thesis figs. 5.3, 5.4)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from data_schema.outcomes import Outcome
from reports.display import as_shown, count_text, general_text, given_text, level_text, sentence_start, shown_unit
from reports.figures.kind import FigureKind, absence_text
from reports.figures.series import Axis, Series, axis_of, drawn_factor, series_lie_apart, series_of
from reports.figures.style import GREY, TWO_COLUMNS_IN, is_narrow, light_grid, new_figure, publication_style, spread
from reports.naming import control_name, swept_words
from reports.results import StudyResults

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure


def has_quantity(results: StudyResults, quantity: Outcome) -> bool:
    """Whether any condition has a mean of the quantity."""
    summaries = (condition.summary(quantity) for condition in results.conditions)
    return any(summary is not None and summary.mean.known is not None for summary in summaries)


def coefficient_of(results: StudyResults) -> str:
    """Return what the swept factor's levels are called."""
    return swept_words(drawn_factor(results)).coefficient


def points_text(results: StudyResults, quantity: Outcome) -> str:
    """Say what the marks are: means, intervals, single runs and how many there are."""
    found = [(c, summary) for c in results.conditions if (summary := c.summary(quantity)) is not None]
    counts = [summary.mean.n for _, summary in found if summary.mean.n is not None]
    sentences = []
    if any(condition.control for condition, _ in found):
        axis = axis_of(results)
        at = f"at {given_text(axis.control_position)}" if axis.continuous else "first"
        sentences.append(f"{sentence_start(control_name(results))} stands {at}.")
    if counts:
        low, high = min(counts), max(counts)
        runs = count_text(low, "run") if low == high else f"{low} to {count_text(high, 'run')}"
        shared = any(isinstance(one.mean.shared_se, float) and one.mean.shared_se > 0.0 for _, one in found)
        error = f", {quantity.common_error} error included" if shared else ""
        sentences.append(f"Circles: means ({runs}); bars: {level_text(found[0][1].mean)}{error}; dots: runs.")
    return " ".join(sentences)


def range_text(results: StudyResults, quantity: Outcome) -> str:
    """Say in words between which values the condition means lie, for a reader who cannot see the plot."""
    unit, factor = shown_unit(quantity.unit)
    sentences = []
    for series in series_of(results):
        summaries = [one for condition in series.conditions if (one := condition.summary(quantity)) is not None]
        means = [factor * one.mean.known for one in summaries if one.mean.known is not None]
        if means:
            span = " to ".join(dict.fromkeys(general_text(end) for end in (min(means), max(means))))
            sentences.append(f"{series.label}: {span} {unit}.")
    return " ".join(sentences)


@dataclass(frozen=True, slots=True)
class _Marks:
    """What is drawn of one series: `(x, mean, below, above)` in the order of x, and `(x, value)` of every run.

    `below` and `above` are the halves of the mean's interval, nan where there is none.
    """

    series: Series
    means: list[tuple[float, float, float, float]]
    runs: list[tuple[float, float]]

    def range(self) -> tuple[float, float]:
        """Return the lowest and the highest of all that is drawn, intervals too."""
        values = [value for _, value in self.runs]
        for _, mean, below, above in self.means:
            values += [mean, *(end for end in (mean - below, mean + above) if math.isfinite(end))]
        return min(values), max(values)


def _draw_by_level(results: StudyResults, quantity: Outcome, width_in: float) -> Figure:
    """Draw one outcome: x is the damping coefficient with CE at 0, y the outcome in the unit it is shown in.

    All series share one panel, side by side, as in the thesis; where they lie so far apart that no difference
    between conditions could be seen, each has a panel, and the axes of all have one span.
    """
    narrow, drawn = is_narrow(width_in), _drawn(results, quantity)
    figure = new_figure(width_in, _height_in(results, quantity, drawn, narrow))
    if not _draw_on(figure, results, quantity, drawn, narrow) and len(drawn) > 1:
        _legend(figure, drawn, 1 if narrow else 2)
    return figure


def draw_side_by_side(results: StudyResults, quantities: Sequence[Outcome]) -> Figure:
    """Draw outcomes beside each other, those that there are, across both columns of a paper."""
    with publication_style():
        shown = {quantity: _drawn(results, quantity) for quantity in quantities if has_quantity(results, quantity)}
        figure = new_figure(TWO_COLUMNS_IN, max(_height_in(results, *each, narrow=True) for each in shown.items()))
        parts = figure.subfigures(1, len(shown), squeeze=False)[0]
        panels = [_draw_on(part, results, *each, True) for part, each in zip(parts, shown.items(), strict=True)]
        drawn = max(shown.values(), key=len)
        if not all(panels) and len(drawn) > 1:
            _legend(figure, drawn, 2)
        return figure


def _drawn(results: StudyResults, quantity: Outcome) -> list[_Marks]:
    every = (_marks(series, axis_of(results), quantity) for series in series_of(results))
    return [marks for marks in every if marks.runs or marks.means]


def _height_in(results: StudyResults, quantity: Outcome, drawn: list[_Marks], narrow: bool) -> float:
    if not series_lie_apart(results, quantity):
        return 3.4 if narrow else 3.9
    across = _panels_across(drawn, narrow)
    return 0.9 + -(-len(drawn) // across) * (1.25 if narrow else 1.6)


def _draw_on(
    figure: Figure | SubFigure, results: StudyResults, quantity: Outcome, drawn: list[_Marks], narrow: bool
) -> bool:
    """Draw an outcome; returns whether in panels, which name their series."""
    axis, y_label = axis_of(results), f"{quantity.heading} ({shown_unit(quantity.unit)[0]})"
    if series_lie_apart(results, quantity):
        _draw_panels(figure, drawn, axis, y_label, narrow)
        return True
    axes = figure.add_subplot()
    for index, marks in enumerate(drawn):
        place = index - (len(drawn) - 1) / 2
        _draw_marks(axes, marks, axis, index, place * min(0.16, 0.64 / len(drawn)) * axis.step, narrow)
    axes.set_ylabel(y_label)
    axes.margins(y=0.06)
    axes.set_xlabel(axis.title)
    _label_above(axes, axis)
    return False


def _legend(figure: Figure, drawn: list[_Marks], columns: int) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            color=series.colour,
            linestyle=series.line_style,
            marker="o",
            markersize=series.marker_pt,
            markerfacecolor=series.colour if series.filled else "white",
            label=series.label,
        )
        for series in (marks.series for marks in drawn)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, handlelength=3.2)


def _marks(series: Series, axis: Axis, quantity: Outcome) -> _Marks:
    factor = shown_unit(quantity.unit)[1]
    means: list[tuple[float, float, float, float]] = []
    runs: list[tuple[float, float]] = []
    for condition in series.conditions:
        summary = condition.summary(quantity)
        if summary is None:
            continue
        at, aside = axis.position(condition), spread(len(summary.runs))
        runs += [
            (at + x * 0.08 * axis.step, value * factor) for x, (_run, value) in zip(aside, summary.runs, strict=True)
        ]
        shown = as_shown(summary.mean)
        if shown.known is not None:
            low, high = shown.interval or (math.nan, math.nan)
            means.append((at, shown.known, max(shown.known - low, 0.0), max(high - shown.known, 0.0)))
    return _Marks(series, sorted(means), runs)


def _panels_across(drawn: list[_Marks], narrow: bool) -> int:
    return 2 if len(drawn) > 2 or not narrow else 1


def _draw_panels(figure: Figure | SubFigure, drawn: list[_Marks], axis: Axis, y_label: str, narrow: bool) -> None:
    across = _panels_across(drawn, narrow)
    down = -(-len(drawn) // across)
    panels = figure.subplots(down, across, squeeze=False, sharex=True)
    half = 0.55 * max(high - low for low, high in (marks.range() for marks in drawn))
    for index, (panel, marks) in enumerate(zip(panels.flatten(), drawn, strict=False)):
        low, high = marks.range()
        _draw_marks(panel, marks, axis, index, 0.0, narrow)
        panel.set_ylim((low + high) / 2 - half, (low + high) / 2 + half)
        title = marks.series.label.replace(", ", ",\n") if narrow and across > 1 else marks.series.label
        panel.set_title(title, fontsize=6 if narrow else 7, loc="left")
    for panel in panels.flatten()[len(drawn) :]:
        panel.set_visible(False)
    figure.supxlabel(axis.title, fontsize=8)
    for panel in panels[0]:
        _label_above(panel, axis)
    figure.supylabel(y_label, fontsize=8)


def _draw_marks(axes: Axes, marks: _Marks, axis: Axis, index: int, shift: float, narrow: bool) -> None:
    series = marks.series
    axes.plot(
        [x + shift for x, _ in marks.runs],
        [value for _, value in marks.runs],
        "o",
        color=series.colour,
        alpha=0.4,
        markersize=2.0 if narrow else 2.6,
        markeredgewidth=0,
        zorder=2,
        gid=f"runs-{index}",  # where `reports.tables.each_run` finds them
    )
    axes.errorbar(
        [x + shift for x, _, _, _ in marks.means],
        [mean for _, mean, _, _ in marks.means],
        yerr=[[below for _, _, below, _ in marks.means], [above for _, _, _, above in marks.means]],
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
    axes.set_xticks(axis.ticks, axis.labels)
    axes.set_xlim(axis.ticks[0] - 0.55 * axis.step, axis.ticks[-1] + 0.55 * axis.step)
    light_grid(axes)


def _label_above(axes: Axes, axis: Axis) -> None:
    """Write the gains that the coefficients belong to along the top."""
    if axis.gains:
        gains = axes.secondary_xaxis("top")
        gains.set_xticks(axis.ticks, axis.gains)
        gains.set_xlabel("gain in the controller", color=GREY)
        gains.tick_params(colors=GREY, length=2)
        gains.spines["top"].set_visible(False)


def caption(results: StudyResults, quantity: Outcome) -> str:
    """Say what is drawn."""
    return f"{quantity.heading} against the {coefficient_of(results)}. {points_text(results, quantity)}"


def alternative(results: StudyResults, quantity: Outcome) -> str:
    """Describe the plot in words."""
    return (
        f"Plot of {quantity} against the {coefficient_of(results)}, mean and interval of each condition. "
        f"{range_text(results, quantity)}"
    )


_BY_LEVEL = "_by_level"


def file_name(name: str, results: StudyResults) -> str:
    """Return what a figure's files are called: `joules_by_level` after the factor of its x axis, `joules_by_foot`."""
    factor = drawn_factor(results)
    return name if factor is None else name.replace(_BY_LEVEL, f"_by_{factor.name}")


def _kind(outcome: Outcome) -> FigureKind:
    return FigureKind(
        f"{outcome.key}{_BY_LEVEL}",
        outcome.heading,
        lambda results, width_in: _draw_by_level(results, outcome, width_in),
        lambda results: caption(results, outcome),
        lambda results: alternative(results, outcome),
        lambda results: None if has_quantity(results, outcome) else absence_text(results, f"are no {outcome.plural}"),
        ("factors", "conditions"),
        outcome,
    )


BY_LEVEL = tuple(map(_kind, Outcome))
"""A figure an outcome."""
