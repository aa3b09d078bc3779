"""One run's log: body height over time with jumps and gaps, and one jump enlarged."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.display import LogJump, RunLog
from reports.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PALE,
    PURPLE,
    TWO_COLUMNS_IN,
    VERMILLION,
    legend_below,
    light_grid,
    paper_figure,
)

_GAP_COLOURS = {"dropped": GREY}
_COLUMNS = 2000
"""Pairs of lowest and highest sample that a long log is drawn with: finer than any printed line."""


def draw_log(log: RunLog) -> Figure:
    """Draw a run's log: overview above, one jump below; gaps are shaded and no line crosses them."""
    chosen = _panel_jump(log)
    ratios = [2.0] if chosen is None else [2.0, 2.0] if log.leg_length_m is None else [2.0, 2.0, 1.0]
    with paper_figure(0.7 + sum(ratios)) as figure:
        panels = figure.subplots(len(ratios), 1, squeeze=False, height_ratios=ratios)[:, 0]
        overview = panels[0]
        overview.set_title(f"Run {log.run}" + (f": {log.title}" if log.title else ""), loc="left")
        _draw_trace(overview, log, log.body_height_m, np.ones(log.time_s.size, dtype=bool))
        _draw_jumps(overview, log, log.jumps, events=False, size=3.8)
        if chosen is not None:
            overview.axvspan(*_window(chosen), color=BLUE, alpha=0.12, linewidth=0, label="enlarged below")
            _draw_panel(panels[1], log, chosen)
        if len(panels) == 3 and chosen is not None and log.leg_length_m is not None:
            panels[2].sharex(panels[1])
            _draw_window(panels[2], log, log.leg_length_m, chosen)
        for axes in panels:
            axes.set_ylabel("Leg length (m)" if axes in panels[2:] else "Body height (m)")
            light_grid(axes)
            axes.xaxis.set_major_formatter(lambda at_s, _place: f"{_since_start(log, at_s):g}")
        several = any(not gap.length_known for gap in log.gaps)
        panels[-1].set_xlabel(f"Time from the start of {'each' if several else 'the'} log (s)")
        if log.jumps or log.gaps:
            legend_below(figure, panels, 4)
        return figure


def draw_logs_overlaid(first: RunLog, second: RunLog) -> Figure:
    """Draw two runs' logs over each other: all of them above, the first jump of each below, where both have one.

    Time 0 is the lift-off of each run's first flight, or where one has none the start of each log. No line crosses a
    gap. A log ends before a gap of unknown length, for when the next one began is not known.
    """
    logs = (first, second)
    flown = [[jump for jump in log.jumps if None not in (jump.lift_off_s, jump.apex_height_m)] for log in logs]
    flights = [jumps[0] for jumps in flown if jumps]
    both_fly = len(flights) == len(logs)
    starts_s = [float(log.time_s[0]) if log.time_s.size else 0.0 for log in logs]
    origins_s = [float(jump.lift_off_s or 0.0) for jump in flights] if both_fly else starts_s
    with paper_figure(5.2 if both_fly else 3.0) as figure:
        panels = figure.subplots(2 if both_fly else 1, 1, squeeze=False)[:, 0]
        panels[0].set_title(f"Runs {first.run} and {second.run}", loc="left")
        for log, origin_s, look in zip(logs, origins_s, _OVERLAID, strict=True):
            for axes in panels:
                _overlay(axes, log, origin_s, look)
        if both_fly:
            windows = [_window(jump) for jump in flights]
            ends = [(end - origin_s) for window, origin_s in zip(windows, origins_s, strict=True) for end in window]
            panels[0].axvspan(min(ends), max(ends), color=PALE, linewidth=0, zorder=0)
            panels[1].set_xlim(min(ends), max(ends))
            panels[1].set_title("First flight of each, shaded above", loc="left")
        for axes in panels:
            axes.set_ylabel("Body height (m)")
            light_grid(axes)
        panels[-1].set_xlabel(f"Time from {'the first lift-off' if both_fly else 'the start of the log'} of each (s)")
        legend_below(figure, panels[:1], 1)
        return figure


_OVERLAID: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "linewidth": 1.2, "zorder": 2},
    {"color": VERMILLION, "linewidth": 0.7, "zorder": 3},
)
"""How two logs are told apart, in grey too: the second is thinner, and lies above."""


def _overlay(axes: Axes, log: RunLog, origin_s: float, look: dict[str, Any]) -> None:
    """Draw a log as far as its times are known, on an axis that begins at an origin."""
    end_s = min((gap.start_s for gap in log.gaps if not gap.length_known), default=math.inf)
    known = log.time_s <= end_s
    label = f"{log.run}: {log.title}{'' if known.all() else ', up to its restart'}"
    for times, heights in _unbroken(log, log.time_s[known], log.body_height_m[known]):
        thin_s, thin_m = envelope(times, heights)
        axes.plot(thin_s - origin_s, thin_m, label=label, **look)
        label = ""


def _panel_jump(log: RunLog) -> LogJump | None:
    numbered = {jump.number: jump for jump in log.jumps}
    if log.panel_jump is not None and log.panel_jump in numbered:
        return numbered[log.panel_jump]
    return next((jump for jump in log.jumps if not jump.excluded), log.jumps[0] if log.jumps else None)


def _window(jump: LogJump) -> tuple[float, float]:
    if jump.apex_height_m is None:  # the stance, and where a flight would have been
        return jump.at_s - 0.3, jump.at_s + 1.2
    first = jump.touchdown_s if jump.touchdown_s is not None else jump.at_s - 0.5
    return first - 0.3, jump.at_s + 0.5


def _since_start(log: RunLog, at_s: float) -> float:
    """Return the time on its log's own clock, as commands take it, of an instant of the axis; logs begin at 0."""
    begins = [gap.end_s for gap in log.gaps if not gap.length_known and gap.end_s <= at_s]
    return at_s - max(begins, default=0.0)


def _draw_panel(axes: Axes, log: RunLog, jump: LogJump) -> None:
    """Draw one jump with those beside it, under a title that says whether it is used."""
    _draw_window(axes, log, log.body_height_m, jump)
    start, end = _window(jump)
    _draw_jumps(axes, log, tuple(j for j in log.jumps if start <= j.at_s <= end), events=True, size=5.0)
    why = "misfire" if jump.misfire else f"not used: {jump.excluded}" if jump.excluded else ""
    title = ", ".join(filter(None, (f"Jump {jump.number} at {_since_start(log, jump.at_s):.2f} s", why)))
    axes.set_title(textwrap.fill(title, int(12 * TWO_COLUMNS_IN)), loc="left")


def _draw_window(axes: Axes, log: RunLog, values_m: NDArray[np.float64], jump: LogJump) -> None:
    """Draw the samples round a jump."""
    start, end = _window(jump)
    _draw_trace(axes, log, values_m, (log.time_s >= start) & (log.time_s <= end), samples=True)
    axes.set_xlim(start, end)


def _draw_trace(
    axes: Axes, log: RunLog, values_m: NDArray[np.float64], inside: NDArray[np.bool_], *, samples: bool = False
) -> None:
    time_s, height_m = log.time_s[inside], values_m[inside]
    for gap in log.gaps:
        kind = f"gap ({gap.kind})"
        known = axes.get_legend_handles_labels()[1]
        shade = _GAP_COLOURS.get(gap.kind, ORANGE)
        axes.axvspan(gap.start_s, gap.end_s, color=shade, alpha=0.35, linewidth=0, label="" if kind in known else kind)
    for times, heights in _unbroken(log, time_s, height_m):
        axes.plot(*envelope(times, heights), color=BLACK, linewidth=0.6, zorder=2)
    if samples:
        axes.plot(time_s, height_m, ".", color=BLACK, markersize=2, markeredgewidth=0, zorder=2)


def _unbroken(
    log: RunLog, time_s: NDArray[np.float64], height_m: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Yield the stretches between gaps, which no line crosses."""
    breaks = [int(np.searchsorted(time_s, gap.start_s, side="right")) for gap in log.gaps]
    yield from zip(np.split(time_s, breaks), np.split(height_m, breaks), strict=True)


def envelope(
    time_s: NDArray[np.float64], height_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Thin a long log for drawing, shape (n,) to at most (4 000,): lowest and highest sample of each stretch."""
    if time_s.size <= 2 * _COLUMNS:
        return time_s, height_m
    chosen = set[int]()
    for stretch in np.array_split(np.arange(time_s.size), _COLUMNS):
        chosen.add(int(stretch[np.argmin(height_m[stretch])]))
        chosen.add(int(stretch[np.argmax(height_m[stretch])]))
    order = np.array(sorted(chosen))
    return time_s[order], height_m[order]


def _draw_jumps(axes: Axes, log: RunLog, jumps: tuple[LogJump, ...], *, events: bool, size: float) -> None:
    for label, marker, colour, scale in (("apex", "o", BLUE, 1.0), ("not used", "X", VERMILLION, 1.6)):
        chosen = [jump for jump in jumps if bool(jump.excluded) is (label == "not used")]
        if chosen:
            axes.plot(
                [jump.at_s for jump in chosen],
                [_height_m(log, jump) for jump in chosen],
                marker,
                color=colour,
                markersize=scale * size,
                label=label,
                zorder=4,
                markeredgewidth=0,
            )
    for attribute, name, colour, style in (
        ("touchdown_s", "touchdown", PURPLE, "--"),
        ("lift_off_s", "lift-off", GREEN, "-."),
    ):
        found = [at for jump in jumps if (at := getattr(jump, attribute)) is not None]
        if not found:
            continue
        if events:
            for index, at in enumerate(found):
                axes.axvline(at, color=colour, linestyle=style, linewidth=1.0, label="" if index else name, zorder=1)
        else:
            # In the overview a jump is a few pixels wide: short strokes along the foot of the plot.
            strokes = axes.get_xaxis_transform()
            axes.vlines(found, 0.0, 0.05, color=colour, linewidth=0.8, transform=strokes, zorder=3, label=name)


def _height_m(log: RunLog, jump: LogJump) -> float:
    """Return where a jump is marked: at its apex, or on the trace where it has none."""
    if jump.apex_height_m is not None:
        return jump.apex_height_m
    return float(np.interp(jump.at_s, log.time_s, log.body_height_m)) if log.time_s.size else 0.0
