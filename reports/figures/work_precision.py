"""What accuracy costs: relative error against computing time, both on logarithmic scales, a panel for each output."""

from __future__ import annotations

import math
import textwrap

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from reports.display import time_text
from reports.drawn import Curve, Panel, WorkPrecision
from reports.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    PALE,
    SKY,
    TWO_COLUMNS_IN,
    VERMILLION,
    light_grid,
    new_figure,
    publication_style,
)

OWN_METHOD = "labbook"
_ACROSS = 2
_LOOKS = ((VERMILLION, "s"), (SKY, "^"), (BLUE, "D"), (GREEN, "v"))
_FLOOR_NAME = "round-off: nothing is claimed"
_LINE = 0.045
"""Height of a setting's text, as a part of that axis."""
_ROOM = 3.0
"""Factor by which the axis of errors reaches past what is drawn."""
_LEFT_OF_MARKS, _RIGHT_OF_MARKS = 0.14, 0.05
"""How far the axis of times reaches past what is drawn, as parts of that: settings stand to the left of their marks."""


def draw_work_precision(study: WorkPrecision) -> Figure:
    """Draw one panel an output; the further down and to the left a curve lies, the better."""
    down = -(-len(study.panels) // _ACROSS)
    with publication_style():
        notes = [line for note in study.notes for line in textwrap.wrap(note, int(18 * TWO_COLUMNS_IN))]
        figure = new_figure(TWO_COLUMNS_IN, 0.9 + 2.1 * down + 0.13 * len(notes))
        axes = figure.subplots(down, _ACROSS, squeeze=False, sharex=True, sharey=True).flatten()
        looks, limits, times = _looks(study), _limits(study), _times(study)
        for panel, drawn in zip(study.panels, axes, strict=False):
            _draw_panel(drawn, panel, looks, limits)
        axes[0].set_xlim(*times)  # all panels share it
        for empty in axes[len(study.panels) :]:
            empty.set_visible(False)
        figure.suptitle(
            textwrap.fill(study.title, int(14 * TWO_COLUMNS_IN)), fontsize=8, weight="bold", x=0.01, ha="left"
        )
        for drawn in axes[len(study.panels) - _ACROSS : len(study.panels)]:
            drawn.set_xlabel("Time of one run")
            drawn.tick_params(labelbottom=True)
        figure.supylabel("Relative error", fontsize=8)
        handles: dict[str, Artist] = {}
        for drawn in axes:
            handles |= {str(name): artist for artist, name in zip(*drawn.get_legend_handles_labels(), strict=True)}
        handles[_FLOOR_NAME] = Patch(facecolor=PALE)
        legend = figure.legend(
            list(handles.values()),
            list(handles),
            loc="outside lower center",
            ncols=3,
            title="\n".join(notes) or None,
            title_fontsize=6,
        )
        legend.get_title().set_multialignment("left")
        return figure


def _looks(study: WorkPrecision) -> dict[str, tuple[str, str]]:
    """Colour and mark of each method: the own one in black, the others in their order."""
    others = [name for name in study.methods if name != OWN_METHOD]
    looks = {name: _LOOKS[place % len(_LOOKS)] for place, name in enumerate(others)}
    return {**looks, OWN_METHOD: (BLACK, "o")}


def _limits(study: WorkPrecision) -> tuple[float, float]:
    """Range of the axis of errors, the same for all panels: from under the lowest floor to over the largest error."""
    errors = [mark.error for panel in study.panels for curve in panel.curves for mark in curve.marks]
    floors = [panel.floor for panel in study.panels]
    return min(floors, default=1e-16) / _ROOM, max([*errors, *floors], default=1.0) * _ROOM


def _times(study: WorkPrecision) -> tuple[float, float]:
    """Range of the axis of times, with room for the settings beside the leftmost marks."""
    seconds = [mark.seconds for panel in study.panels for curve in panel.curves for mark in curve.marks]
    least, most = min(seconds, default=1e-6), max(seconds, default=1.0)
    span = max(most / least, 10.0)
    return least / span**_LEFT_OF_MARKS, most * span**_RIGHT_OF_MARKS


def _draw_panel(axes: Axes, panel: Panel, looks: dict[str, tuple[str, str]], limits: tuple[float, float]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.axhspan(limits[0], panel.floor, color=PALE, linewidth=0, zorder=0)
    for curve in panel.curves:
        _draw_curve(axes, curve, *looks[curve.method])
        if curve.method == OWN_METHOD:
            _write_settings(axes, curve, limits)
    axes.set_ylim(*limits)
    axes.set_title(panel.output, fontsize=7, loc="left")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: time_text(value)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_locator(LogLocator(base=10.0, numticks=9))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"1e{round(math.log10(value)):d}"))
    axes.yaxis.set_minor_locator(NullLocator())
    light_grid(axes, "both")


def _draw_curve(axes: Axes, curve: Curve, colour: str, mark: str) -> None:
    own = curve.method == OWN_METHOD
    axes.plot(
        [found.seconds for found in curve.marks],
        [found.error for found in curve.marks],
        color=colour,
        marker=mark,
        markersize=3.4 if own else 2.8,
        linewidth=1.4 if own else 0.9,
        label=f"{curve.method} (beside its marks: {curve.setting})" if own else curve.method,
        zorder=3 if own else 2,
    )


def _write_settings(axes: Axes, curve: Curve, limits: tuple[float, float]) -> None:
    """Write the settings beside their marks, but not one over another."""
    line = _LINE * math.log(limits[1] / limits[0])
    written = [math.inf]
    for found in curve.marks:
        height = math.log(found.error)
        if min(abs(height - other) for other in written) < line:
            continue
        written.append(height)
        axes.annotate(
            found.setting,
            (found.seconds, found.error),
            xytext=(-4, -2),
            textcoords="offset points",
            horizontalalignment="right",
            fontsize=5,
            zorder=4,
        )
