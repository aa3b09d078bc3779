"""The flow diagram: how many runs and jumps there were, and how many are left after each step."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from reports.content import ReportContent
from reports.figures.kind import FigureKind
from reports.figures.style import BLACK, BLUE, GREY, is_narrow
from reports.flow_steps import Step, flow_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BOX_IN, _SIDE_IN, _BETWEEN_IN = 1.2, 1.75, 0.32
_LINE_IN, _PAD_IN, _GAP_IN = 0.135, 0.1, 0.16
_SIDE_LETTERS = 31


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw a line of boxes a quantity, beside each other where the page is wide enough."""
    lines = [steps for outcome, steps in flow_lines(content.flow).items() if outcome.of_every_run]
    heights = [_height(steps) for steps in lines]
    narrow = is_narrow(width_in)
    height = sum(heights) + 0.35 if narrow else max(heights)
    # Coordinates are inches from the lower left corner, so that text and boxes fit at any width.
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(0, width_in)
    axes.set_ylim(0, height)
    line_width = _BOX_IN + _BETWEEN_IN + _SIDE_IN
    if narrow:
        left = (width_in - line_width) / 2
        _draw_line(axes, lines[0], left, height)
        _draw_line(axes, lines[1], left, heights[1])
    else:
        margin = (width_in - 2 * line_width) / 3
        _draw_line(axes, lines[0], margin, height)
        _draw_line(axes, lines[1], 2 * margin + line_width, height)
    return figure


def _side_lines(step: Step) -> list[str]:
    return [line for words in step.leaving for line in textwrap.wrap(words, _SIDE_LETTERS, subsequent_indent="  ")]


def _box_height(lines: int) -> float:
    return _PAD_IN * 2 + _LINE_IN * lines


def _between(step: Step) -> float:
    """Height between a box and the one above it: room for what leaves the line there."""
    lines = len(_side_lines(step))
    return _box_height(lines) + 2 * _GAP_IN if lines else 2 * _GAP_IN


def _height(steps: tuple[Step, ...]) -> float:
    return _PAD_IN * 2 + _box_height(2) * len(steps) + sum(_between(step) for step in steps[1:])


def _draw_line(axes: Axes, steps: tuple[Step, ...], left: float, top: float) -> None:
    box, at = _box_height(2), top - _PAD_IN
    for index, step in enumerate(steps):
        if index:
            gap = _between(step)
            middle = left + _BOX_IN / 2
            axes.annotate("", (middle, at - gap), (middle, at), arrowprops=_ARROW)
            side = _side_lines(step)
            if side:
                start = left + _BOX_IN + _BETWEEN_IN
                centre = at - gap / 2
                axes.annotate("", (start, centre), (middle, centre), arrowprops=_ARROW)
                _draw_box(axes, (start, centre - _box_height(len(side)) / 2), (_SIDE_IN, _box_height(len(side))), GREY)
                axes.text(start + 0.08, centre, "\n".join(side), va="center", fontsize=6.5, linespacing=1.25)
            at -= gap
        _draw_box(axes, (left, at - box), (_BOX_IN, box), BLUE)
        axes.text(
            left + _BOX_IN / 2,
            at - box / 2 + 0.075,
            str(step.count),
            ha="center",
            va="center",
            fontsize=8,
            weight="bold",
        )
        axes.text(left + _BOX_IN / 2, at - box / 2 - 0.075, step.name, ha="center", va="center", fontsize=7)
        at -= box


_ARROW = {
    "arrowstyle": "-|>,head_width=0.15,head_length=0.3",
    "color": BLACK,
    "linewidth": 0.7,
    "shrinkA": 0,
    "shrinkB": 0,
}


def _draw_box(axes: Axes, corner: tuple[float, float], size: tuple[float, float], edge: str) -> None:
    from matplotlib.patches import FancyBboxPatch

    style = "round,pad=0,rounding_size=0.04"
    axes.add_patch(FancyBboxPatch(corner, *size, boxstyle=style, facecolor="white", edgecolor=edge, linewidth=0.8))


def caption(content: ReportContent) -> str:
    """Say what is counted."""
    plan = "" if content.flow.runs_planned is not None else " No plan was written for this selection."
    return (
        "Runs and jumps of the selection, from what was made to what is analysed, for joules and for apex heights; "
        f"jumps are those of the runs with apex heights.{plan}"
    )


def alternative(content: ReportContent) -> str:
    """Describe the diagram in words: every box and what left before it."""
    lines = [
        f"for {quantity} {', '.join(map(_step_text, steps))}" for quantity, steps in flow_lines(content.flow).items()
    ]
    return f"Flow diagram: {'; '.join(lines)}."


def _step_text(step: Step) -> str:
    left = f" (after {', '.join(step.leaving)})" if step.leaving else ""
    return f"{step.count} {step.name}{left}"


def absent(content: ReportContent) -> str | None:
    """Give the reason where there is nothing to count."""
    return None if content.flow.runs_done else "No run matches this selection."


def shows(content: ReportContent) -> dict[str, object]:
    """Return what is drawn of a report."""
    return {"flow": content.flow}


FLOW = FigureKind("flow", "Runs and jumps", draw, caption, alternative, absent, shows)
