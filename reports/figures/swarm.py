"""Points of one group side by side, so that every one is seen: the same points lie in the same places each time."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

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
