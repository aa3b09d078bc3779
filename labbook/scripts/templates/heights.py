"""The apex height of each run: the mean of its jumps that count, and what it takes from a calibration."""

import math

import numpy as np

from labbook.scripts.templates.runs import Row, Rows, Run, Shared, Source


def calibration_errors_m(row: Row) -> Shared:
    """Return what each independent error of a calibrated height makes of a jump's height.

    The calibration errs by slope_i * reading + intercept_i, the reading being (sign * height - zero) / scale.
    """
    if not row.get("calibration"):
        return {}
    sign, scale = float(row["height_sign"]), float(row["height_scale"])
    reading = (sign * float(row["apex_height_m"]) - float(row["height_zero"])) / scale
    df = float(row["calibration_df"])
    errors = zip(row["error_slopes"].split(), row["error_intercepts"].split(), strict=True)
    return {
        Source(row["calibration"], str(number), df): sign
        * scale
        / float(row["calibration_scale"])
        * (float(slope) * reading + float(intercept))
        for number, (slope, intercept) in enumerate(errors, start=1)
    }


def height_of_run(jumps: Rows) -> Run:
    """Return the mean of the jumps' heights, and the mean of each calibration error over them."""
    shared: Shared = {}
    for jump in jumps:
        for source, error_m in calibration_errors_m(jump).items():
            shared[source] = shared.get(source, 0.0) + error_m / len(jumps)
    heights = [float(jump["apex_height_m"]) for jump in jumps]
    return Run(jumps[0], math.fsum(heights) / len(heights), shared)


def jumps_of_runs(rows: Rows) -> dict[str, list[Row]]:
    """Return the jumps of each run, by its name."""
    jumps: dict[str, list[Row]] = {}
    for row in rows:
        jumps.setdefault(row["run"], []).append(row)
    return jumps


def heights_of_runs(rows: Rows) -> list[Run]:
    """Return the mean apex height of every run."""
    return [height_of_run(jumps) for jumps in jumps_of_runs(rows).values()]


def heights_of_jumps(rows: Rows) -> list[Run]:
    """Return every jump with its own height, as if it were a run (the thesis's tests of the bed, 5.2)."""
    heights = np.array([float(row["apex_height_m"]) for row in rows])
    return [Run(row, float(height), {}) for row, height in zip(rows, heights, strict=True)]
