"""The passive-drain fit: idle runs, line with confidence band, and the run's duration that lies outside (5.1.4)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from data_schema.rounding import level_text as level_in_percent
from data_schema.vocabulary import Undefined
from reports.content import DrainFit, ReportContent
from reports.display import count_text, general_text, level_text, list_text, number_text
from reports.figures.kind import FigureKind
from reports.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    is_narrow,
    light_grid,
    new_figure,
)
from reports.sentences import absence_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

_INSET_MIN = 1.5
"""Minutes that the inset shows on each side of the run's duration."""


@dataclass(frozen=True, slots=True)
class _Look:
    """How one robot is drawn: `line` and `band` colours, the idle runs' colour and marker, the estimate's colour."""

    line: str
    band: str
    points: str
    marker: str
    estimate: str


_ALONE = _Look(BLUE, SKY, BLACK, "o", VERMILLION)
_ROBOTS = tuple(
    _Look(colour, colour, colour, marker, colour)
    for colour, marker in zip((BLUE, VERMILLION, GREEN, PURPLE, ORANGE), "os^vP", strict=True)
)


def _drawn(content: ReportContent) -> tuple[DrainFit, ...]:
    return tuple(fit for fit in content.drains if fit.points)


def _looks(fits: tuple[DrainFit, ...]) -> list[tuple[DrainFit, _Look]]:
    """Give each robot a colour and a marker of its own; a single robot needs none."""
    return [(fits[0], _ALONE)] if len(fits) == 1 else list(zip(fits, itertools.cycle(_ROBOTS), strict=False))


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw charge over duration: solid line where idle runs were made, dashed where the line is extended.

    The inset enlarges the run's duration, where the band would be too thin to see. Several robots have a line each.
    """
    narrow = is_narrow(width_in)
    fits = _looks(_drawn(content))
    figure = new_figure(width_in, 3.0 if narrow else 3.4)
    axes = figure.add_subplot()
    axes.set_xlabel("Time from power on to power off (min)")
    axes.set_ylabel("Charge put back (mAh)")
    light_grid(axes)
    for fit, look in fits:
        _draw_line(axes, fit, look)
        points = [(point.duration_min, point.charge_mah) for point in fit.points]
        axes.plot(
            *zip(*points, strict=True),
            look.marker,
            color=look.points,
            markersize=3.5,
            alpha=0.7,
            label="idle run",
            zorder=4,
        )
        _draw_estimate(axes, fit, look)
    axes.set_xlim(left=min(0.0, *(fit.line_min[0] for fit, _ in fits)))
    if len(fits) == 1:
        axes.legend(loc="lower right")
    else:
        axes.legend(handles=_robot_handles(fits), loc="lower right")
    _draw_inset(axes, fits, narrow)
    return figure


def _draw_line(axes: Axes, fit: DrainFit, look: _Look) -> None:
    durations = [point.duration_min for point in fit.points]
    low, high = min(durations), max(durations)
    band = f"{level_in_percent(fit.band_level)} confidence band"
    axes.fill_between(
        fit.line_min, fit.band_low_mah, fit.band_high_mah, color=look.band, alpha=0.45, linewidth=0, label=band
    )
    inside = [(x, y) for x, y in zip(fit.line_min, fit.line_mah, strict=True) if low <= x <= high]
    axes.plot(fit.line_min, fit.line_mah, "--", color=look.line, linewidth=0.9, label="line, outside the idle runs")
    if inside:
        axes.plot(*zip(*inside, strict=True), color=look.line, linewidth=1.3, label="line, fitted")


def _draw_estimate(axes: Axes, fit: DrainFit, look: _Look) -> None:
    estimate = fit.at_run
    if isinstance(estimate.value, Undefined):
        return
    ends = (estimate.ci_low, estimate.ci_high)
    spans = [[abs(end - estimate.value)] for end in ends if isinstance(end, int | float)]
    axes.vlines(fit.run_duration_min, 0.0, estimate.value, color=GREY, linewidth=0.7, linestyle=":", zorder=1)
    axes.errorbar(
        [fit.run_duration_min],
        [estimate.value],
        yerr=spans if len(spans) == 2 else None,
        fmt="D",
        color=look.estimate,
        markersize=4,
        capsize=3,
        label=f"over {general_text(fit.run_duration_min)} min",
        zorder=5,
    )


def _robot_handles(fits: list[tuple[DrainFit, _Look]]) -> list[Line2D]:
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=look.line, marker=look.marker, markersize=4, linewidth=1.3, label=fit.robot)
        for fit, look in fits
    ]


def _draw_inset(axes: Axes, fits: list[tuple[DrainFit, _Look]], narrow: bool) -> None:
    known = _inset_range([fit for fit, _ in fits])
    if known is None:
        return
    at, (bottom, top) = fits[0][0].run_duration_min, known
    inset = axes.inset_axes((0.13, 0.62, 0.36, 0.34) if narrow else (0.08, 0.56, 0.32, 0.4))
    for fit, look in fits:
        _draw_line(inset, fit, look)
        _draw_estimate(inset, fit, look)
    inset.set_xlim(at - _INSET_MIN, at + _INSET_MIN)
    inset.set_ylim(bottom - 0.08 * (top - bottom), top + 0.08 * (top - bottom))
    inset.tick_params(labelsize=6, length=2)
    for side in ("top", "right"):
        inset.spines[side].set_visible(True)


def _inset_range(fits: Sequence[DrainFit]) -> tuple[float, float] | None:
    """Return the charges that the inset spans; None where it has no place: no intervals, or several durations."""
    known = [ends for fit in fits if (ends := _inset_ends(fit)) is not None]
    if len(known) < len(fits) or len({fit.run_duration_min for fit in fits}) > 1:
        return None
    return min(low for low, _ in known), max(high for _, high in known)


def _inset_ends(fit: DrainFit) -> tuple[float, float] | None:
    """Return the lowest and the highest charge that the inset shows of a line, None without an interval."""
    low, high = fit.at_run.ci_low, fit.at_run.ci_high
    if isinstance(fit.at_run.value, Undefined) or not isinstance(low, int | float) or not isinstance(high, int | float):
        return None
    near = [
        (below, above)
        for x, below, above in zip(fit.line_min, fit.band_low_mah, fit.band_high_mah, strict=True)
        if abs(x - fit.run_duration_min) <= _INSET_MIN
    ]
    return min([low, *(below for below, _ in near)]), max([high, *(above for _, above in near)])


def caption(content: ReportContent) -> str:
    """Say what is drawn and that the estimate is extrapolated."""
    fits = _drawn(content)
    if not fits:
        return ""
    if len(fits) == 1:
        idle, lines, diamonds = count_text(len(fits[0].points), "idle run"), "the fitted line and its", "The diamond"
    else:
        counts = [f"{len(fit.points)} of {fit.robot}" for fit in fits]
        idle, lines, diamonds = f"idle runs ({list_text(counts)})", "each robot's line and its", "A diamond"
    durations = list_text(list(dict.fromkeys(general_text(fit.run_duration_min) for fit in fits)))
    enlarged = ", enlarged in the inset," if _inset_range(fits) is not None else ""
    return (
        f"Charge put back after {idle} over the time the robot was on, with {lines} "
        f"{level_text(fits[0].at_run).removesuffix('CI')}confidence band; the line is dashed where no idle run was "
        f"made. {diamonds}{enlarged} is the passive drain over {durations} min with its interval."
    )


def alternative(content: ReportContent) -> str:
    """Describe the plot in words."""
    several = len(_drawn(content)) > 1
    lines = [
        f"{f'{fit.robot}: ' if several else ''}slope {number_text(fit.slope)}, intercept {number_text(fit.intercept)}"
        for fit in _drawn(content)
    ]
    rising = "rising straight lines" if several else "a rising straight line"
    return f"Plot of charge in milliampere hours against time in minutes with {rising}: {'; '.join(lines)}."


def absent(content: ReportContent) -> str | None:
    """Give the reason where nothing was fitted."""
    return None if _drawn(content) else absence_text(content, "is no passive-drain fit")


def shows(content: ReportContent) -> dict[str, object]:
    """Return what is drawn of a report."""
    return {"drains": _drawn(content)}


PASSIVE_DRAIN = FigureKind("passive_drain", "Passive drain", draw, caption, alternative, absent, shows)
