"""The parts of an estimation plot: values with their mean and SD, differences with their intervals, words on axes.

Points of one group side by side, so that every one is seen: the same points lie in the same places each time.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.display import EQUALS
from reports.figures.style import BLACK, GREY, lay_out, plain_ticks
from reports.numbers import Number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDEST = 0.3
"""How far from the middle of its group a point may lie; groups are 1 apart."""
SD_AT = 0.38
"""Where mean and SD stand beside their group; its points end before."""

_MARKERS_PT = ((40, 4.0), (120, 3.0), (400, 2.2))
"""Up to so many values in a group: the size of their marks."""
_SMALLEST_PT = 1.4
_APART = 1.08
"""Distance of neighbours in diameters: marks have an edge."""
_CLEAR_PT = 1.5
"""Between the marks and the middle of the line of the SD, half of which is 0.8 wide."""


def marker_pt(most: int) -> float:
    """Return the diameter of the marks, in points, where the largest group has `most` values."""
    return next((size for count, size in _MARKERS_PT if most <= count), _SMALLEST_PT)


def marker_beside_pt(most: int, axes: Axes) -> float:
    """Return the diameter of the marks of groups that have their SD beside them: smaller where groups are narrow.

    Then two marks find room side by side before that line, unless they were too small to be seen.
    """
    room = SD_AT * _group_pt(axes) - _CLEAR_PT
    return min(marker_pt(most), max(_SMALLEST_PT, room / (_APART + 0.5)))


def widest_beside(diameter_pt: float, axes: Axes) -> float:
    """Return how far from the middle of its group a mark may lie so that its edge stays before the line of the SD."""
    return max(0.0, min(WIDEST, SD_AT - (0.5 * diameter_pt + _CLEAR_PT) / _group_pt(axes)))


def _group_pt(axes: Axes) -> float:
    """Return the points between neighbouring groups."""
    left, right = axes.get_xlim()
    return float(axes.get_window_extent().width * 72.0 / axes.figure.dpi / (right - left))


def swarm(values: Sequence[float], axes: Axes, diameter_pt: float, widest: float = WIDEST) -> list[float]:
    """Return how far right of the middle each value lies, in units of the x axis, so that no mark covers another.

    The axes must have their limits, and their figure its layout. From the lowest value up, each goes to the column
    nearest to the middle that has room above its last mark. Where no column has any, the one whose last mark is
    farthest below takes it. None lies farther from the middle than `widest`.
    """
    box = axes.get_window_extent()
    pt = 72.0 / axes.figure.dpi
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    apart = diameter_pt * _APART
    step = apart * (right - left) / (box.width * pt)
    per_pt = (high - low) / (box.height * pt)
    each_side = max(0, int(widest / step + 1e-9))
    columns = [0.0] + [side * place * step for place in range(1, each_side + 1) for side in (1.0, -1.0)]
    last = [-float("inf")] * len(columns)
    offsets = [0.0] * len(values)
    for index in sorted(range(len(values)), key=values.__getitem__):
        height = (values[index] - low) / per_pt
        free = (place for place, top in enumerate(last) if height - top >= apart)
        place = next(free, min(range(len(last)), key=last.__getitem__))
        offsets[index], last[place] = columns[place], height
    return offsets


MARKS = ("o", "s", "^", "D", "v", "P")
"""Marks of what the values belong to: more than these are not distinguishable."""

MOST_DRAWN = 2000
"""Of larger groups so many values are drawn: more only lie on each other."""

_GAP = 0.012
"""Half of the gap at the mean, as a part of the axis."""
_LABEL_PT = 4.3
"""Width of a letter of the groups' names."""
_BESIDE_PT = 60.0
"""What the axes' own labels take of the width."""
UPRIGHT = 24
"""Letters in a line of a name that stands upright."""
_LINE_PT = 9.0
"""What a line of such a name takes of the width."""
_LYING = 5
"""Letters of an upright name that take the height of two lines."""
_SMALL_PT, _LETTER_PT = 6.5, 3.6
"""Size of the line above a figure, and the width of its letters."""
_MARK_LETTERS = 6
"""Letters that a mark and the space round it take in a legend."""


@dataclass(frozen=True, slots=True)
class DrawnGroup:
    """A group in the unit that is shown; `mean` and `sd` are None where they do not exist."""

    name: str
    values: tuple[float, ...]
    labels: tuple[str, ...]
    mean: float | None
    sd: float | None
    colour: str


def axis_values(number: Number | None) -> list[float]:
    """Return what of a difference takes place on its axis: estimate and finite ends."""
    if number is None:
        return []
    found = (number.value, number.ci_low, number.ci_high)
    return [value for value in found if isinstance(value, int | float) and math.isfinite(value)]


def has_interval(number: Number | None) -> bool:
    """Whether an interval is drawn: a difference that exists, with two finite ends."""
    if number is None or not isinstance(number.value, int | float):
        return False
    low, high = number.ci_low, number.ci_high
    return isinstance(low, int | float) and isinstance(high, int | float) and math.isfinite(low + high)


def set_limits(axes: Axes, values: Sequence[float]) -> None:
    """Let the axis of values hold all of these, with some room."""
    low, high = min(values, default=0.0), max(values, default=1.0)
    room = 0.07 * (high - low) or 0.05 * abs(high) or 1.0
    axes.set_ylim(low - room, high + room)
    axes.yaxis.set_major_locator(plain_ticks())


def draw_groups(figure: Figure, axes: Axes, groups: Sequence[DrawnGroup]) -> None:
    """Draw every value, and beside each group its mean as a gap in the line of its SD.

    This comes last: which points touch follows from the layout of all the rest.
    """
    from matplotlib.lines import Line2D

    marks = _marks(groups)
    if marks:
        handles = [Line2D([], [], linestyle="none", marker=mark, color=GREY, markersize=4) for mark in marks.values()]
        across = columns_of(list(marks), figure.get_figwidth())
        figure.legend(handles, list(marks), loc="outside lower center", ncols=across, handletextpad=0.1)
    lay_out(figure)
    draw_values(axes, groups, marks)


def columns_of(names: Sequence[str], width_in: float) -> int:
    """Return how many columns of a legend of these names a figure has room for."""
    letters = max(map(len, names)) + _MARK_LETTERS
    return min(len(names), max(1, int(72.0 * width_in / _LABEL_PT / letters)))


def draw_values(axes: Axes, groups: Sequence[DrawnGroup], marks: Mapping[str, str]) -> None:
    """Draw values and means of groups on axes that are laid out, with a mark for each label where there are marks."""
    size = marker_beside_pt(max((len(group.values) for group in groups), default=0), axes)
    widest = widest_beside(size, axes)
    for place, group in enumerate(groups):
        _draw_mean(axes, place + SD_AT, group)
        indices = drawn_indices(group.values)
        values = [group.values[index] for index in indices]
        offsets = swarm(values, axes, size, widest)
        labels = [group.labels[index] for index in indices] if marks else [""] * len(values)
        for label in dict.fromkeys(labels):
            chosen = [index for index, own in enumerate(labels) if own == label]
            axes.plot(
                [place + offsets[index] for index in chosen],
                [values[index] for index in chosen],
                marks.get(label, "o"),
                color=group.colour,
                markersize=size,
                markeredgewidth=0,
                alpha=0.75,
                zorder=3,
            )


def drawn_indices(values: Sequence[float]) -> list[int]:
    """Return which values are drawn: all, or of many those at even ranks, both ends among them, in their order."""
    if len(values) <= MOST_DRAWN:
        return list(range(len(values)))
    by_size = sorted(range(len(values)), key=values.__getitem__)
    last = len(values) - 1
    return sorted(by_size[round(place * last / (MOST_DRAWN - 1))] for place in range(MOST_DRAWN))


def part_text(sizes: Iterable[int]) -> str:
    """Say that not every value of groups of these sizes is drawn; "" where each is."""
    if all(size <= MOST_DRAWN for size in sizes):
        return ""
    return f"Of larger groups {MOST_DRAWN} values are drawn, evenly by rank, with the ends."


def put_above(figure: Figure, line: str, width_in: float) -> None:
    """Write a line above the figure."""
    if line:
        letters = int(72.0 * width_in / _LETTER_PT)
        figure.suptitle(textwrap.fill(line, letters), x=0.01, ha="left", fontsize=_SMALL_PT)


def _draw_mean(axes: Axes, x: float, group: DrawnGroup) -> None:
    if group.mean is None:
        return
    if not group.sd:
        axes.plot([x], [group.mean], "_", color=group.colour, markersize=5, zorder=4)
        return
    low, high = axes.get_ylim()
    gap = _GAP * (high - low)
    for side in (-1.0, 1.0):
        ends = [group.mean + side * gap, group.mean + side * max(group.sd, gap)]
        axes.plot([x, x], ends, color=group.colour, linewidth=1.6, solid_capstyle="butt", zorder=4)


def _marks(groups: Sequence[DrawnGroup]) -> dict[str, str]:
    """Return a mark for each label, none where there are no labels, one only, or too many to distinguish."""
    labels = sorted({label for group in groups for label in group.labels})
    complete = all(len(group.labels) == len(group.values) for group in groups)
    return dict(zip(labels, MARKS, strict=False)) if complete and 1 < len(labels) <= len(MARKS) else {}


def draw_difference(axes: Axes, number: Number, x: float, zero: float) -> None:
    """Draw a difference and its interval, from `zero` on; where either does not exist, say so in its place."""
    if not isinstance(number.value, int | float):
        axes.text(x, zero, "undefined", color=GREY, fontsize=6.5, ha="center", va="bottom")
        return
    at, ends = zero + number.value, [zero + end for end in axis_values(number)[1:]]
    if has_interval(number):
        axes.plot([x, x], ends, color=BLACK, linewidth=1.4, solid_capstyle="butt", zorder=5)
    else:
        above = axes.annotate("no interval", (x, at), xytext=(0, 5), textcoords="offset points", ha="center")
        above.set(color=GREY, fontsize=6.5)
    axes.plot([x], [at], "o", color=BLACK, markersize=4.5, zorder=6)


def set_names(axes: Axes, groups: Sequence[DrawnGroup], more: Sequence[str], width_in: float) -> float:
    """Write each group's name with its n below its place, and `more` names after them.

    Names are broken so that neighbours do not touch; where a word is too long for that they stand upright. Returns how
    many inches upright names take of the height beyond what two lines do.
    """
    columns = len(groups) + len(more)
    letters = int((72.0 * width_in - _BESIDE_PT) / columns / _LABEL_PT)
    counts = [f"n{EQUALS}{len(group.values)}" for group in groups]
    upright = any(
        len(word) > letters for name in (*(group.name for group in groups), *counts) for word in name.split(" ")
    )
    names = [
        "\n".join([*textwrap.wrap(group.name, UPRIGHT if upright else letters, break_on_hyphens=False), count])
        for group, count in zip(groups, counts, strict=True)
    ]
    if upright and not more:
        names = _upright_apart(names, (72.0 * width_in - _BESIDE_PT) / columns)
    axes.set_xticks(range(columns), [*names, *more], rotation=90 if upright else 0)
    return height_of_names([*names, *more], upright)


def _upright_apart(names: Sequence[str], each_pt: float) -> list[str]:
    """Write upright names in one line where several do not fit, and of too many only some, at even steps."""
    if each_pt >= _LINE_PT * max(name.count("\n") + 1 for name in names):
        return list(names)
    step = math.ceil(_LINE_PT / each_pt)
    return ["" if place % step else name.replace("\n", ", ") for place, name in enumerate(names)]


def height_of_names(names: Sequence[str], upright: bool) -> float:
    """Return the inches that upright names need below axes, beyond what two lines of a name that lies do."""
    longest = max((len(line) for name in names for line in name.split("\n")), default=0)
    return max(0.0, (longest - _LYING) * _LABEL_PT / 72.0) if upright else 0.0


def named_with_unit(quantity: str, unit: str) -> str:
    """Return what stands at an axis: "Energy (J)"; the unit "1" is not written."""
    return quantity if unit in ("", "1") else f"{quantity} ({unit})"
