"""Forest plots: estimates with their intervals, one a row, under each other on one axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.display import as_shown
from reports.figures.style import BLACK, BLUE, GREY, VERMILLION
from reports.numbers import Number

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, slots=True)
class ForestRow:
    """A row: its name and its numbers, close together where there are several; a `heading` is bold and has none.

    What is `strong` is drawn as a diamond; `beside` stands at the right.
    """

    label: str
    numbers: tuple[Number, ...] = ()
    strong: bool = False
    beside: str = ""
    heading: bool = False


def draw_forest(axes: Axes, rows: Sequence[ForestRow], size_pt: float = 7) -> None:
    """Draw the rows from the top, with words in `size_pt`."""
    for place, row in enumerate(rows):
        colour, marker = (VERMILLION, "D") if row.strong else (BLUE, "o")
        for index, number in enumerate(row.numbers):
            shift = 0.0 if len(row.numbers) == 1 else 0.8 * (index / (len(row.numbers) - 1) - 0.5)
            draw_estimate(axes, number, place + shift, colour, marker, 1.0 / len(row.numbers) ** 0.4)
        if row.beside:
            axes.annotate(
                row.beside,
                (1.0, place),
                xycoords=axes.get_yaxis_transform(),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=size_pt,
                annotation_clip=False,
            )
    name_rows(axes, [(row.label, row.heading) for row in rows], size_pt)


def draw_estimate(
    axes: Axes, number: Number, row: float, colour: str = BLACK, marker: str = "o", scale: float = 1.0
) -> None:
    """Draw one number and its interval at a height; where the number does not exist, say so in its place."""
    shown = as_shown(number)
    if shown.known is None:
        axes.text(0.02, row, "undefined", transform=axes.get_yaxis_transform(), color=GREY, fontsize=6.5, va="center")
        return
    if shown.interval is not None:
        axes.plot(shown.interval, [row, row], color=colour, linewidth=1.1 * scale, solid_capstyle="butt", zorder=3)
    axes.plot([shown.known], [row], marker, color=colour, markersize=4.2 * scale, zorder=4)


def name_rows(axes: Axes, names: Sequence[tuple[str, bool]], size_pt: float) -> None:
    """Write the rows' names at the left, headings bold, the first on top."""
    axes.set_yticks(range(len(names)), [name for name, _ in names], fontsize=size_pt)
    for label, (_, is_heading) in zip(axes.get_yticklabels(), names, strict=False):  # one panel of several has them
        label.set_fontweight("bold" if is_heading else "normal")
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
