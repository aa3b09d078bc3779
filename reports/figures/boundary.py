"""What active damping saves over a box of grounds: the sampled grounds, those apart, and the boundary of failure."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from reports.figures.style import BLACK, BLUE, GREY, SKY, TWO_COLUMNS_IN, VERMILLION, legend_below, paper_figure
from simulator.compiled import Row
from simulator.falsify import FAILS, NO_JUMP, SAME, SAME_WITHIN, SAVES, VERDICTS, Counterexample, Question, Searched
from simulator.sweep.design import LOGARITHMIC, Axis, at_shares

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PANELS = 6
_PANEL_IN = 2.9
_LOOKS = {SAVES: (BLUE, ".", 6.0), SAME: (SKY, ".", 3.0), FAILS: (VERMILLION, "D", 9.0)}
"""Colour, mark and size of grounds that say something; the others are grey strokes."""
_STROKES = "x+_|12"
_MUCH = 0.1
"""A saving whose line is drawn, too."""
_FLAT = 0.05
"""Triangles at the border of the grounds that are flatter are none: their lines would run along it."""


def draw_boundary(question: Question, searched: Searched, examples: Sequence[Counterexample], title: str) -> Figure:
    """Draw each pair of parameters of the box, with its boundary where there are two; against one, the saving."""
    own = at_shares(question.over, question.scene.effects, searched.shares, 0).axes
    pairs = list(itertools.combinations(range(len(own)), 2))[:_MOST_PANELS] or [(0, 0)]
    across = min(len(pairs), 3)
    down = -(-len(pairs) // across)
    width_in, share = (TWO_COLUMNS_IN, 0.8) if across > 1 else (1.6 * _PANEL_IN, 1.0)
    with paper_figure(1.0 + share * _PANEL_IN * down, width_in) as figure:
        panels = [figure.add_subplot(down, across, place) for place in range(1, len(pairs) + 1)]
        for axes, (x, y) in zip(panels, pairs, strict=True):
            across_axis, up_axis = own[x], own[y] if x != y else None
            _draw_grounds(axes, searched, across_axis, up_axis)
            _draw_examples(axes, examples, _in_joules(searched), across_axis, up_axis)
            if len(own) == 2 and up_axis is not None:
                _draw_lines(axes, searched, across_axis.coordinates, up_axis.coordinates)
            _scale(axes, question.over[x], None if up_axis is None else question.over[y])
            axes.margins(0.03)
            axes.use_sticky_edges = False  # contours stick to the outermost grounds, whose marks would be cut
            axes.autoscale(tight=False)
        figure.suptitle(title, fontsize=8)
        legend_below(figure, panels, 2, handletextpad=0.4)
        return figure


def _draw_grounds(axes: Axes, searched: Searched, across: Axis, up: Axis | None) -> None:
    """Draw the sample, and what fails of the search; grounds that are apart have no saving, and lie at 0."""
    verdict, joules = searched.judged.verdict, _in_joules(searched)
    saving = searched.judged.saved_j if joules else 100.0 * searched.judged.saving
    heights = np.nan_to_num(saving) if up is None else up.coordinates
    strokes = iter(_STROKES)
    for which, words in VERDICTS.items():
        at = verdict == which
        if which != FAILS:
            at[searched.sample :] = False
        if at.any():
            colour, mark, size = _LOOKS[which] if which in _LOOKS else (GREY, next(strokes), 9.0)
            wide = 0.0 if which in _LOOKS else 0.6
            axes.scatter(
                across.coordinates[at],
                heights[at],
                s=size,
                c=colour,
                marker=mark,
                linewidths=wide,
                label=words,
                zorder=3,
            )
    axes.set_xlabel(_label(across))
    axes.set_ylabel(f"saving ({'J' if joules else '%'})" if up is None else _label(up))
    if up is None:
        axes.axhline(0.0, color=BLACK, linewidth=0.8)


def _in_joules(searched: Searched) -> bool:
    """Whether savings are drawn as joules, since some have no share of a cost."""
    return bool(np.isnan(searched.judged.saving[searched.judged.verdict < NO_JUMP]).any())


def _draw_examples(axes: Axes, examples: Sequence[Counterexample], joules: bool, across: Axis, up: Axis | None) -> None:
    """Ring the grounds that were simulated again, with their numbers in the table."""
    for number, one in enumerate(examples, 1):
        saving = -one.more_j if joules else 100.0 * one.saving
        at = (one.ground[across.name], saving if up is None else one.ground[up.name])
        colour, words = (BLACK, "confirmed") if one.confirmed else (GREY, "not confirmed")
        axes.scatter(*at, s=42, facecolors="none", edgecolors=colour, linewidths=0.9, label=words, zorder=5)
        axes.annotate(str(number), at, xytext=(5, 4), textcoords="offset points", fontsize=6, zorder=5)


def _draw_lines(axes: Axes, searched: Searched, x: Row, y: Row) -> None:
    """Draw where active damping begins to cost more, and to save much, between grounds that say something.

    Where equal heights begin to ask for a stiffer extension the saving jumps, and a line breaks off; there is none
    where a saving is no share of a cost.
    """
    from matplotlib.tri import TriAnalyzer, Triangulation

    shares, each = np.unique(searched.shares, axis=0, return_index=True)
    if len(each) < 4:
        return
    triangles = Triangulation(*shares.T)
    apart = np.isnan(searched.judged.saving[each])[triangles.triangles].any(axis=1)
    apart |= np.ptp(searched.judged.stiffer[each][triangles.triangles].astype(int), axis=1) > 0
    triangles.set_mask(apart)
    if apart.all():
        return
    mask = TriAnalyzer(triangles).get_flat_tri_mask(_FLAT)
    drawn = Triangulation(x[each], y[each], triangles.triangles, mask=mask)
    percent = np.nan_to_num(100.0 * searched.judged.saving[each])
    lines = ((-100.0 * SAME_WITHIN, "-", "boundary"), (100.0 * _MUCH, "--", f"saves {100.0 * _MUCH:g} %"))
    for level, look, words in lines:
        if percent.min() < level < percent.max():
            axes.tricontour(drawn, percent, levels=[level], colors=BLACK, linewidths=1.2, linestyles=look, zorder=4)
            axes.plot([], [], look, color=BLACK, linewidth=1.2, label=words)


def _scale(axes: Axes, across: str, up: str | None) -> None:
    from matplotlib.ticker import FuncFormatter, NullFormatter

    for word, axis, scale in ((across, axes.xaxis, axes.set_xscale), (up, axes.yaxis, axes.set_yscale)):
        if word is not None and word.endswith(LOGARITHMIC):
            scale("log")
            axis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())


def _label(axis: Axis) -> str:
    return axis.name if axis.unit == "1" else f"{axis.name} ({axis.unit})"
