"""The force-plate study: as sentences and a table, as data, and as what its figure draws."""

from __future__ import annotations

from typing import Any

import numpy as np

from data_schema.outcomes import Outcome
from data_schema.rounding import error_of, interval_text, number_text
from data_schema.vocabulary import Undefined
from labbook.analysis.studies.force_plate import ForcePlateStudy, RunEstimate, odd_runs
from labbook.presenting.numbers import value_data
from reports.display import BESIDE, true_minus
from reports.figures.force_plate import HopsOfCondition, WindowChoice
from simulator.steady.published_results import published_numbers
from stats.results import plural

HEAD = ("run", "day", "condition", "measured J", "estimated J", "hops", "offset s", "drift ppm", "ms")


def sentences(study: ForcePlateStudy) -> list[str]:
    """Say the slope, then what it was computed from: runs, clocks, window, and what was left out."""
    published = published_numbers()
    lines = [
        f"Estimated joules are {_slope_text(study)} times the measured ones ({_unit_text(study)}); the thesis found "
        f"{published['plate.slope']:g} (3.2.2)."
    ]
    ratio = "undefined" if isinstance(study.rmse.ratio, Undefined) else number_text(study.rmse.ratio, 2)
    lines.append(
        f"RMSE/IQR of the hops about this line: {ratio} (n = {study.rmse.n} hops); the thesis "
        f"{published['plate.rmse_iqr']:g}."
    )
    by_condition = ", ".join(f"{number_text(ratio, 3)} at {condition}" for condition, ratio in study.ratios.items())
    lines.append(f"Estimated over measured: {by_condition}.")
    lines.append(
        "The plate carries the foot's weight too, the leg does not: less that, the slope is "
        f"{number_text(study.slope_without_foot, 3)}."
    )
    lines += [_window_text(study), _clocks_text(study)]
    left = sum(one.stances - len(one.hops_j) for one in study.runs)
    if left:
        lines.append(f"{plural(left, 'hop')} with samples missing in the log {'is' if left == 1 else 'are'} left out.")
    other = [f"{one.name} ({one.stances} of {one.hops_made})" for one in study.runs if one.stances != one.hops_made]
    if other:
        lines.append(
            f"The plate saw other stances than hops were made in {', '.join(other)}: check jumps_made, and samples "
            "that are missing."
        )
    if odd := odd_runs(study.runs):
        named = ", ".join(f"{one.name} ({number_text(one.ratio, 2)})" for one in odd)
        lines.append(
            f"Estimated over measured is far from that of the other runs in {named}: check the charge and the log."
        )
    if study.left_out:
        named = ", ".join(f"{name} ({why.reason})" for name, why in study.left_out.items())
        lines.append(f"Left out: {named}.")
    if study.simulated is not None and study.simulated.why_not:
        lines.append(f"Not simulated: {study.simulated.why_not}")
    if len({one.day for one in study.runs}) == 1:
        lines.append("All runs are of one day, and the interval says nothing of other days.")
    return lines


def comparison_rows(study: ForcePlateStudy) -> list[tuple[str, ...]]:
    """Return what was measured beside what the simulator gives and what the thesis says (3.2.2)."""
    ratio = "–" if isinstance(study.rmse.ratio, Undefined) else number_text(study.rmse.ratio, 2)
    slope, rmse, window = (f"{published_numbers()[f'plate.{of}']:g}" for of in ("slope", "rmse_iqr", "window"))
    found: list[tuple[str, ...]] = [
        ("slope, estimated over measured joules", _slope_text(study), "–", slope),
        ("RMSE/IQR about it", ratio, "–", rmse),
        ("moving average (samples)", str(study.window), "–", window),
    ]
    for condition in study.ratios:
        of_it = [one.measured_j for one in study.runs if one.condition == condition]
        simulated = None if study.simulated is None else study.simulated.value(condition, Outcome.JOULES)
        cells = f"{np.mean(of_it):.2f}", "–" if simulated is None else f"{simulated:.2f}"
        found.append((f"joules a hop at {study.titles[condition]}", *cells, "–"))
    return found


def _slope_text(study: ForcePlateStudy) -> str:
    slope = study.slope
    number = number_text(slope.slope, error=error_of(slope.ci))
    if isinstance(slope.ci, Undefined):
        return f"{number} (no interval: {slope.ci.reason})"
    return f"{number} ({interval_text(slope.ci, slope.level)})"


def _unit_text(study: ForcePlateStudy) -> str:
    runs = f"{plural(study.slope.n, 'run')} of {plural(len(study.ratios), 'condition')}"
    days = len({one.day for one in study.runs})
    return f"over {plural(days, 'day')}, {runs}" if days > 1 else f"over {runs}"


def _window_text(study: ForcePlateStudy) -> str:
    how = "the corner of what the next window changes" if study.by_corner else "as given"
    windows, slopes = study.windows, study.slopes
    place = windows.index(study.window)
    low, high = max(place - 1, 0), min(place + 1, len(windows) - 1)
    steep = (slopes[high] - slopes[low]) / (windows[high] - windows[low])
    equal = [
        window for window, before, after in zip(windows[1:], slopes, slopes[1:], strict=False) if before > 1 >= after
    ]
    at_1 = f", and to 1 at {equal[0]}" if equal else ""
    return (
        f"The force is smoothed over {plural(study.window, 'sample')} "
        f"({1e3 * study.sample_s * study.window:.3g} ms; {how}). One sample more changes the slope by "
        f"{true_minus(number_text(steep, 2))} there: from {number_text(slopes[0], 3)} without smoothing to "
        f"{number_text(slopes[-1], 3)} over {windows[-1]} samples{at_1}."
    )


def _clocks_text(study: ForcePlateStudy) -> str:
    drifts = [1e6 * one.clocks.drift for one in study.runs]
    spreads = [1e3 * one.clocks.residual_sd_s for one in study.runs]
    between = true_minus(f"{min(drifts):.0f} to {max(drifts):.0f}")
    return (
        f"The log's clock drifts by {between} ppm against the plate's; touchdowns lie {max(spreads):.2g} ms or less "
        "from one line (standard deviation, by run)."
    )


def rows(study: ForcePlateStudy) -> list[tuple[str, ...]]:
    """Return the table of the runs; the last column is the standard deviation of the touchdowns in ms."""
    return [
        (
            one.name,
            one.day,
            one.condition,
            f"{one.measured_j:.2f}",
            f"{one.estimated_j:.2f}",
            f"{len(one.hops_j)} of {one.hops_made}",
            true_minus(f"{one.clocks.at_zero_s:.4f}"),
            true_minus(f"{1e6 * one.clocks.drift:.1f}"),
            f"{1e3 * one.clocks.residual_sd_s:.2f}",
        )
        for one in study.runs
    ]


def as_data(study: ForcePlateStudy) -> dict[str, Any]:
    """Return all numbers for JSON."""
    slope = study.slope
    return {
        "slope": slope.slope,
        "se": value_data(slope.se),
        "df": value_data(slope.df),
        "shared_se": slope.shared_se,
        "slope_without_foot": study.slope_without_foot,
        "ci": value_data(slope.ci),
        "level": slope.level,
        "groups": slope.groups,
        "n": slope.n,
        "rmse": study.rmse.to_dict(),
        "ratios": dict(study.ratios),
        "beside": [dict(zip(BESIDE, one, strict=True)) for one in comparison_rows(study)],
        "window": study.window,
        "window_by_corner": study.by_corner,
        "sample_s": study.sample_s,
        "windows": [
            {"window": window, "difference_n": difference, "slope": slope_there}
            for window, difference, slope_there in zip(
                study.windows, (None, *study.differences), study.slopes, strict=True
            )
        ],
        "runs": [_run(one) for one in study.runs],
        "left_out": {name: why.reason for name, why in study.left_out.items()},
    }


def _run(one: RunEstimate) -> dict[str, Any]:
    clocks = one.clocks
    return {
        "run": one.name,
        "day": one.day,
        "condition": one.condition,
        "measured_j": one.measured_j,
        "estimated_j": one.estimated_j,
        "hops_j": list(one.hops_j),
        "hops_made": one.hops_made,
        "stances": one.stances,
        "clocks": {
            "offset_s": clocks.at_zero_s,
            "offset_ci": value_data(one.offset_ci),
            "drift": clocks.drift,
            "drift_ci": value_data(clocks.drift_ci),
            "residual_sd_s": clocks.residual_sd_s,
            "touchdowns": clocks.n,
            "misread": clocks.left_out,
        },
    }


def figure_data(study: ForcePlateStudy) -> tuple[list[HopsOfCondition], float, str, WindowChoice]:
    """Return what the figure shows."""
    hops = [
        HopsOfCondition(
            label=study.titles[traces.condition],
            first=traces.first,
            time_s=traces.time_s.tolist(),
            force_n=traces.force_n.tolist(),
            length_m=traces.length_m.tolist(),
            measured_j=[one.measured_j for one in study.runs if one.condition == traces.condition],
            hops_j=[
                (one.hops_j[: one.first], one.hops_j[one.first :])
                for one in study.runs
                if one.condition == traces.condition
            ],
        )
        for traces in study.traces
    ]
    relative = (np.array(study.differences) / study.differences[0]).tolist()
    choice = WindowChoice(study.windows[1:], relative, study.slopes[1:], study.window, study.by_corner)
    return hops, study.slope.slope, f"slope {_slope_text(study)}", choice
