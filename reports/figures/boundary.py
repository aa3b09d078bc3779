"""What active damping saves over a box of grounds: the sampled grounds, those apart, and the boundary of failure."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from reports.figures.style import (
    BLACK,
    BLUE,
    GREY,
    SKY,
    TWO_COLUMNS_IN,
    VERMILLION,
    legend_below,
    new_figure,
    publication_style,
)
from simulator.compiled import Row
from simulator.falsify import FAILS, NO_JUMP, SAME, SAME_WITHIN, SAVES, VERDICTS, Counterexample, Question, Searched
from simulator.sweep.design import LOGARITHMIC, at_shares

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PANELS = 6
_LOOKS = {
    SAVES: (BLUE, ".", 5.0),
    SAME: (SKY, ".", 2.0),
    FAILS: (VERMILLION, "D", 9.0),
}
_APART = (("x", GREY), ("+", GREY), ("_", GREY), ("|", GREY), ("1", GREY))
_MEDIUM_SAVING = 0.1


def draw_boundary(question: Question, searched: Searched, examples: Sequence[Counterexample], title: str) -> Figure:
    """Draw each pair of parameters of the box, with its boundary where there are two; against one, the saving."""
    ends = at_shares(question.over, question.scene.effects, searched.shares, 0).axes
    pairs = list(itertools.combinations(range(len(ends)), 2))[:_MOST_PANELS] or [(0, 0)]
    across = min(len(pairs), 3 if len(pairs) > 2 else 2)
    down = -(-len(pairs) // across)
    with publication_style():
        figure = new_figure(TWO_COLUMNS_IN if across > 1 else 4.8, 0.8 + 2.9 * down / (1 if across < 3 else 1.2))
        panels = [figure.add_subplot(down, across, place + 1) for place in range(len(pairs))]
        for axes, (x, y) in zip(panels, pairs, strict=True):
            _draw_panel(axes, question, searched, examples, (x, y))
        figure.suptitle(title, fontsize=8)
        legend_below(figure, panels, 2, handletextpad=0.4)
        return figure


def _draw_panel(
    axes: Axes, question: Question, searched: Searched, examples: Sequence[Counterexample], pair: tuple[int, int]
) -> None:
    own = at_shares(question.over, question.scene.effects, searched.shares, 0).axes
    verdict, saving = searched.judged.verdict, 100.0 * searched.judged.saving
    first, second = (own[place] for place in pair)
    single = pair[0] == pair[1]
    x, y = first.coordinates, saving if single else second.coordinates
    if first.name and question.over[pair[0]].endswith(LOGARITHMIC):
        axes.set_xscale("log")
    if not single and question.over[pair[1]].endswith(LOGARITHMIC):
        axes.set_yscale("log")
    sampled = np.arange(len(verdict)) < searched.sample
    apart = iter(_APART)
    for which, words in VERDICTS.items():
        at = sampled & (verdict == which)
        if which == FAILS:
            at = verdict == FAILS
        if not at.any():
            continue
        if which in _LOOKS:
            colour, mark, size = _LOOKS[which]
        else:
            (mark, colour), size = next(apart), 9.0
        shown = np.zeros(len(y)) if single and which >= NO_JUMP else y
        lines = {} if mark in "x+_|1" else {"linewidths": 0}
        axes.scatter(
            x[at], shown[at], c=colour, marker=mark, s=size, label=words, zorder=3, **({"linewidths": 0.6} | lines)
        )
    if single:
        axes.axhline(0.0, color=BLACK, linewidth=0.8)
        axes.set_ylabel("saving (%)")
    else:
        axes.set_ylabel(_label(second.name, second.unit))
        if len(own) == 2:
            _draw_lines(axes, searched, x, y, saving)
    axes.set_xlabel(_label(first.name, first.unit))
    for number, one in enumerate(examples, 1):
        place = (one.ground[first.name], 100.0 * one.saving if single else one.ground[second.name])
        axes.scatter(
            *place,
            s=42,
            facecolors="none",
            edgecolors=BLACK,
            linewidths=0.8,
            zorder=5,
            label="confirmed" if one.confirmed else "not confirmed",
        )
        axes.annotate(str(number), place, xytext=(5, 4), textcoords="offset points", fontsize=6, zorder=5)


def _draw_lines(axes: Axes, searched: Searched, x: Row, y: Row, saving: Row) -> None:
    """Draw where the saving is nothing and where it is large, between grounds that say something."""
    from matplotlib.tri import Triangulation

    _, one_each = np.unique(searched.shares, axis=0, return_index=True)
    if len(one_each) < 4:
        return
    corners = Triangulation(*searched.shares[one_each].T).triangles
    cut = ~(searched.judged.verdict[one_each] < NO_JUMP)[corners].all(axis=1)
    if cut.all():
        return
    drawn = Triangulation(x[one_each], y[one_each], corners, mask=cut)
    values = np.where(np.isnan(saving[one_each]), 0.0, saving[one_each])
    for level, look in ((-100.0 * SAME_WITHIN, "-"), (100.0 * _MEDIUM_SAVING, "--")):
        if values.min() < level < values.max():
            axes.tricontour(drawn, values, levels=[level], colors=BLACK, linewidths=1.2, linestyles=look, zorder=4)
            name = "boundary: costs more" if level < 0.0 else f"saves {level:g} %"
            axes.plot([], [], look, color=BLACK, linewidth=1.2, label=name)


def _label(name: str, unit: str) -> str:
    return name if unit == "1" else f"{name} ({unit})"
