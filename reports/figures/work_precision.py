"""What accuracy costs: relative error against computing time, both on logarithmic scales, a panel for each output."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from reports.display import plain_number, time_text
from reports.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    PALE,
    SKY,
    TWO_COLUMNS_IN,
    VERMILLION,
    legend_below,
    light_grid,
    paper_figure,
)
from simulator.accuracy.methods import LABBOOK, TITLES
from simulator.accuracy.study import AccuracyStudy, Point, Series

_ACROSS = 2
_LOOKS = ((VERMILLION, "s"), (SKY, "^"), (BLUE, "D"), (GREEN, "v"))
_FLOOR_NAME = "round-off: nothing is claimed"
_LINE = 0.045
"""Height of a setting's text, as a part of that axis."""
_ROOM = 3.0
"""Factor by which the axis of errors reaches past what is drawn."""
_LEFT_OF_MARKS, _RIGHT_OF_MARKS = 0.14, 0.05
"""How far the axis of times reaches past what is drawn, as parts of that: settings stand to the left of their marks."""


Marks = Sequence[tuple[Series, Sequence[tuple[Point, float]]]]
"""By method the points that have an error above 0 in an output, with that error, from coarse to fine."""


def draw_work_precision(study: AccuracyStudy, title: str, notes: Sequence[str] = ()) -> Figure:
    """Draw one panel an output; the further down and to the left a curve lies, the better.

    An output for which nothing is known has none.
    """
    floors = {
        name: floor for name, floor in study.reference.floor.items() if floor is not None and math.isfinite(floor)
    }
    panels = {name: _marks(study, name) for name in floors}
    drawn_points = [found for marks in panels.values() for _series, each in marks for found in each]
    limits = _limits([error for _point, error in drawn_points], list(floors.values()))
    down = -(-len(panels) // _ACROSS)
    notes = [line for note in notes for line in textwrap.wrap(note, int(18 * TWO_COLUMNS_IN))]
    with paper_figure(0.9 + 2.1 * down + 0.13 * len(notes)) as figure:
        axes = figure.subplots(down, _ACROSS, squeeze=False, sharex=True, sharey=True).flatten()
        looks = _looks(study)
        for (name, marks), drawn in zip(panels.items(), axes, strict=False):
            _draw_panel(drawn, marks, looks, limits, floors[name])
            drawn.set_title(TITLES[name], fontsize=7, loc="left")
        axes[0].set_xlim(*_times([point.seconds for point, _error in drawn_points]))  # all panels share it
        for empty in axes[len(panels) :]:
            empty.set_visible(False)
        figure.suptitle(textwrap.fill(title, int(14 * TWO_COLUMNS_IN)), fontsize=8, weight="bold", x=0.01, ha="left")
        for drawn in axes[len(panels) - _ACROSS : len(panels)]:
            drawn.set_xlabel("Time of one run")
            drawn.tick_params(labelbottom=True)
        figure.supylabel("Relative error", fontsize=8)
        floor = {_FLOOR_NAME: Patch(facecolor=PALE)}
        legend = legend_below(figure, axes, 3, floor, title="\n".join(notes) or None, title_fontsize=6)
        legend.get_title().set_multialignment("left")
        return figure


def _marks(study: AccuracyStudy, output: str) -> Marks:
    found = []
    for series in study.series:
        errors = [(point, (point.errors or {}).get(output)) for point in series.points if not point.failure]
        marks = [(point, error) for point, error in errors if error and math.isfinite(error)]
        if marks:
            found.append((series, marks))
    return found


def _looks(study: AccuracyStudy) -> dict[str, tuple[str, str]]:
    """Colour and mark of each method: the own one in black, the others in their order."""
    others = [series.method for series in study.series if series.method != LABBOOK]
    looks = {name: _LOOKS[place % len(_LOOKS)] for place, name in enumerate(others)}
    return {**looks, LABBOOK: (BLACK, "o")}


def _limits(errors: Sequence[float], floors: Sequence[float]) -> tuple[float, float]:
    """Range of the axis of errors, the same for all panels: from under the lowest floor to over the largest error."""
    return min(floors, default=1e-16) / _ROOM, max([*errors, *floors], default=1.0) * _ROOM


def _times(seconds: Sequence[float]) -> tuple[float, float]:
    """Range of the axis of times, with room for the settings beside the leftmost marks."""
    least, most = min(seconds, default=1e-6), max(seconds, default=1.0)
    span = max(most / least, 10.0)
    return least / span**_LEFT_OF_MARKS, most * span**_RIGHT_OF_MARKS


def _draw_panel(
    axes: Axes, marks: Marks, looks: dict[str, tuple[str, str]], limits: tuple[float, float], floor: float
) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.axhspan(limits[0], floor, color=PALE, linewidth=0, zorder=0)
    for series, points in marks:
        own = series.method == LABBOOK
        colour, mark = looks[series.method]
        axes.plot(
            [point.seconds for point, _error in points],
            [error for _point, error in points],
            color=colour,
            marker=mark,
            markersize=3.4 if own else 2.8,
            linewidth=1.4 if own else 0.9,
            label=f"{series.method} (beside its marks: {series.setting})" if own else series.method,
            zorder=3 if own else 2,
        )
        if own:
            _write_settings(axes, points, limits)
    axes.set_ylim(*limits)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: time_text(value)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_locator(LogLocator(base=10.0, numticks=9))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"1e{round(math.log10(value)):d}"))
    axes.yaxis.set_minor_locator(NullLocator())
    light_grid(axes, "both")


def _write_settings(axes: Axes, points: Sequence[tuple[Point, float]], limits: tuple[float, float]) -> None:
    """Write the settings beside their marks, but not one over another."""
    line = _LINE * math.log(limits[1] / limits[0])
    written = [math.inf]
    for point, error in points:
        height = math.log(error)
        if min(abs(height - other) for other in written) < line:
            continue
        written.append(height)
        axes.annotate(
            plain_number(point.setting),
            (point.seconds, error),
            xytext=(-4, -2),
            textcoords="offset points",
            horizontalalignment="right",
            fontsize=5,
            zorder=4,
        )
