"""The passive-drain fit: idle runs, line with confidence band, and the run's duration that lies outside (5.1.4)."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from data_schema.vocabulary import Undefined
from reports.display import count_text, general_text, level_text, list_text, number_text
from reports.figures.kind import FigureKind, absence_text
from reports.figures.style import BLUE, GREEN, ORANGE, PURPLE, VERMILLION, draw_line, is_narrow, light_grid, new_figure
from reports.results import MAH_MIN, Drain, StudyResults

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LINE_POINTS = 61
_LOOKS = tuple(zip((BLUE, VERMILLION, GREEN, PURPLE, ORANGE), "os^vP", strict=True))


def _drawn(results: StudyResults) -> tuple[Drain, ...]:
    return tuple(drain for drain in results.drains if drain.idle)


def draw(results: StudyResults, width_in: float) -> Figure:
    """Draw charge over duration, a line a robot: solid where idle runs were made, dashed where it is extended."""
    fits = _drawn(results)
    figure = new_figure(width_in, 3.0 if is_narrow(width_in) else 3.4)
    axes = figure.add_subplot()
    axes.set_xlabel("Time from power on to power off (min)")
    axes.set_ylabel("Charge put back (mAh)")
    light_grid(axes)
    for fit, (colour, marker) in zip(fits, itertools.cycle(_LOOKS), strict=False):
        _draw_fit(axes, fit, colour, marker, fit.robot if len(fits) > 1 else "idle run")
    axes.set_xlim(left=0.0)
    axes.legend(loc="lower right")
    return figure


def _draw_fit(axes: Axes, drain: Drain, colour: str, marker: str, label: str) -> None:
    """Draw line, band and idle runs, and the estimate at the run's duration with its interval."""
    line, at_run = drain.line, drain.result.at_run
    if isinstance(line, Undefined):
        return
    minutes = np.linspace(0.0, line.duration_max_s * 1.05 / MAH_MIN, _LINE_POINTS).tolist()
    along = [line.at(minute * MAH_MIN) for minute in minutes]
    low = [at.charge_mah if isinstance(at.ci_low, Undefined) else at.ci_low for at in along]
    high = [at.charge_mah if isinstance(at.ci_high, Undefined) else at.ci_high for at in along]
    points = [run.duration_s / MAH_MIN for run in drain.idle], [run.charge_mah for run in drain.idle]
    charges = [at.charge_mah for at in along]
    draw_line(axes, minutes, charges, colour, band=(low, high), points=points, marker=marker, label=label)
    if at_run.known is not None:
        bar = None if at_run.interval is None else [[abs(end - at_run.known)] for end in at_run.interval]
        axes.errorbar(
            [drain.run_duration_min], [at_run.known], yerr=bar, fmt="D", color=colour, markersize=5, capsize=3
        )


def caption(results: StudyResults) -> str:
    """Say what is drawn and that the estimate is extrapolated."""
    fits = _drawn(results)
    idle = count_text(len(fits[0].idle), "idle run")
    if len(fits) > 1:
        idle = f"idle runs ({list_text([f'{len(fit.idle)} of {fit.robot}' for fit in fits])})"
    level = level_text(fits[0].result.at_run).removesuffix("CI")
    durations = list_text(list(dict.fromkeys(general_text(fit.run_duration_min) for fit in fits)))
    return (
        f"Charge put back after {idle} over the time the robot was on, with fitted line and {level}confidence band; "
        f"the line is dashed where no idle run was made. Diamond: the passive drain over {durations} min with its "
        "interval."
    )


def alternative(results: StudyResults) -> str:
    """Describe the plot in words."""
    lines = [
        f"{fit.robot} slope {number_text(fit.result.slope)}, intercept {number_text(fit.result.intercept)}".strip()
        for fit in _drawn(results)
    ]
    return f"Plot of charge in milliampere hours against time in minutes with straight lines: {'; '.join(lines)}."


def absent(results: StudyResults) -> str | None:
    """Give the reason where nothing was fitted."""
    return None if _drawn(results) else absence_text(results, "is no passive-drain fit")


PASSIVE_DRAIN = FigureKind("passive_drain", "Passive drain", draw, caption, alternative, absent, ("drains",))
