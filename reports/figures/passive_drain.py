"""The passive-drain fit: idle runs, line with confidence band, and the run's duration that lies outside (5.1.4)."""

from __future__ import annotations

from typing import cast

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_schema.vocabulary import Undefined
from reports.content import DrainFit, ReportContent
from reports.display import general_text, level_text, number_text
from reports.figures.kind import FigureKind
from reports.figures.style import BLACK, BLUE, GREY, SKY, VERMILLION, is_narrow, light_grid, new_figure
from reports.sentences import absence_text, count_text


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw charge over duration: solid line where idle runs were made, dashed where the line is extended.

    The inset enlarges the run's duration, where the band would be too thin to see.
    """
    narrow = is_narrow(width_in)
    figure = new_figure(width_in, 3.0 if narrow else 3.4)
    axes = figure.add_subplot()
    axes.set_xlabel("Time from power on to power off (min)")
    axes.set_ylabel("Charge put back (mAh)")
    light_grid(axes)
    if content.drain is None:
        return figure
    fit = content.drain
    _draw_line(axes, fit)
    points = [(point.duration_min, point.charge_mah) for point in fit.points]
    axes.plot(*zip(*points, strict=True), "o", color=BLACK, markersize=3.5, alpha=0.7, label="idle run", zorder=4)
    _draw_estimate(axes, fit)
    axes.set_xlim(left=min(0.0, *fit.line_min))
    axes.legend(loc="lower right")
    _draw_inset(axes, fit, narrow)
    return figure


def _draw_line(axes: Axes, fit: DrainFit) -> None:
    durations = [point.duration_min for point in fit.points]
    low, high = min(durations), max(durations)
    band = f"{general_text(100 * fit.band_level)} % confidence band"
    axes.fill_between(fit.line_min, fit.band_low_mah, fit.band_high_mah, color=SKY, alpha=0.45, linewidth=0, label=band)
    inside = [(x, y) for x, y in zip(fit.line_min, fit.line_mah, strict=True) if low <= x <= high]
    axes.plot(fit.line_min, fit.line_mah, "--", color=BLUE, linewidth=0.9, label="line, outside the idle runs")
    if inside:
        axes.plot(*zip(*inside, strict=True), color=BLUE, linewidth=1.3, label="line, fitted")


def _draw_estimate(axes: Axes, fit: DrainFit) -> None:
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
        color=VERMILLION,
        markersize=4,
        capsize=3,
        label=f"run of {general_text(fit.run_duration_min)} min",
        zorder=5,
    )


def _draw_inset(axes: Axes, fit: DrainFit, narrow: bool) -> None:
    estimate, at = fit.at_run, fit.run_duration_min
    if not all(isinstance(end, int | float) for end in (estimate.value, estimate.ci_low, estimate.ci_high)):
        return
    inset = axes.inset_axes((0.13, 0.62, 0.36, 0.34) if narrow else (0.08, 0.56, 0.32, 0.4))
    _draw_line(inset, fit)
    _draw_estimate(inset, fit)
    inset.set_xlim(at - 1.5, at + 1.5)
    near = [
        (low, high)
        for x, low, high in zip(fit.line_min, fit.band_low_mah, fit.band_high_mah, strict=True)
        if abs(x - at) <= 1.5
    ]
    near.append((float(cast(float, estimate.ci_low)), float(cast(float, estimate.ci_high))))
    bottom, top = min(low for low, _ in near), max(high for _, high in near)
    inset.set_ylim(bottom - 0.08 * (top - bottom), top + 0.08 * (top - bottom))
    inset.tick_params(labelsize=6, length=2)
    for side in ("top", "right"):
        inset.spines[side].set_visible(True)


def caption(content: ReportContent) -> str:
    """Say what is drawn and that the estimate is extrapolated."""
    fit = content.drain
    if fit is None:
        return ""
    return (
        f"Charge put back after {count_text(len(fit.points), 'idle run')} over the time the robot was on, with the "
        f"fitted line and its {level_text(fit.at_run).removesuffix('CI')}confidence band. "
        f"The diamond, enlarged in the inset, is the passive drain of a run of {general_text(fit.run_duration_min)} "
        "min with its interval."
    )


def alternative(content: ReportContent) -> str:
    """Describe the plot in words."""
    fit = content.drain
    if fit is None:
        return ""
    return (
        "Plot of charge in milliampere hours against time in minutes with a rising straight line: "
        f"slope {number_text(fit.slope)}, intercept {number_text(fit.intercept)}."
    )


def absent(content: ReportContent) -> str | None:
    """Give the reason where nothing was fitted."""
    if content.drain is None or not content.drain.points:
        return absence_text(content, "is no passive-drain fit")
    return None


PASSIVE_DRAIN = FigureKind("passive_drain", "Passive drain", draw, caption, alternative, absent)
