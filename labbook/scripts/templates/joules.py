"""Joules a jump of each run, from the charge that was put back after it and the passive drain of idle runs."""

import math
from typing import NamedTuple

import numpy as np

from labbook.scripts.templates.runs import Number, Row, Rows, Run, Shared, Source

REFERENCE_VOLTAGE_V = 15.4
"""Of the pack, at which charge is counted as energy (thesis 5.1.4)."""
COULOMB_PER_MAH = 3.6


class DrainLine(NamedTuple):
    """The least-squares line of charge over duration through idle runs, and its errors (thesis 5.1.4)."""

    slope_mah_s: float
    mean_duration_s: float
    mean_charge_mah: float
    residual_sd_mah: float
    slope_se_mah_s: float
    r_squared: float
    n: int


def rounding_sd_mah(resolution_mah: float) -> float:
    """Return the standard deviation of rounding to a step: step / sqrt(12), that of a uniform error."""
    return resolution_mah / math.sqrt(12.0)


def drain_line(idle: Rows) -> DrainLine:
    """Fit charge = intercept + slope * duration; the scatter about it is at least that of the charger's rounding."""
    durations = np.array([float(row["duration_s"]) for row in idle])
    charges = np.array([float(row["charge_mah"]) for row in idle])
    away, n = durations - durations.mean(), len(idle)
    squares = float(away @ away)
    slope = float(away @ (charges - charges.mean())) / squares
    residuals = charges - charges.mean() - slope * away
    residual_sd = math.sqrt(float(residuals @ residuals) / (n - 2))
    residual_sd = max(residual_sd, rounding_sd_mah(max(float(row["resolution_mah"]) for row in idle)))
    about_mean = charges - charges.mean()
    return DrainLine(
        slope,
        float(durations.mean()),
        float(charges.mean()),
        residual_sd,
        residual_sd / math.sqrt(squares),
        1.0 - float(residuals @ residuals) / float(about_mean @ about_mean),
        n,
    )


def passive_charge_mah(line: DrainLine, duration_s: float) -> float:
    """Return the line at a duration, counted from the point of the means."""
    return line.mean_charge_mah + line.slope_mah_s * (duration_s - line.mean_duration_s)


def line_errors_mah(line: DrainLine, duration_s: float) -> Number:
    """Return both independent errors of the line at a duration: of its level s / sqrt(n), and of its slope."""
    return {
        "level": line.residual_sd_mah / math.sqrt(line.n),
        "slope": line.slope_se_mah_s * (duration_s - line.mean_duration_s),
    }


def joules_of_run(row: Row, line: DrainLine) -> Run:
    """Return 3.6 * voltage * (charge - passive charge) / jumps made (thesis 5.1.4), and the errors of the line in it.

    Where repeats of a condition are rounded alike by the charger, they share that error, too.
    """
    duration_s = float(row["duration_s"])
    joules_per_mah = COULOMB_PER_MAH * REFERENCE_VOLTAGE_V / float(row["jumps_made"])
    joules = joules_per_mah * (float(row["charge_mah"]) - passive_charge_mah(line, duration_s))
    shared: Shared = {
        Source(row["robot"], term, line.n - 2.0): -joules_per_mah * error_mah
        for term, error_mah in line_errors_mah(line, duration_s).items()
    }
    if row["rounded_alike"] == "yes":
        reading = f"{row['charge_mah']} mAh, {row['condition']}"
        shared[Source("rounding", reading, math.inf)] = joules_per_mah * rounding_sd_mah(float(row["resolution_mah"]))
    return Run(row, joules, shared)


def joules_of_runs(rows: Rows) -> list[Run]:
    """Return the joules a jump of every run of jumps, by the line of its robot's idle runs."""
    idle = [row for row in rows if row["kind"] == "idle"]
    lines = {
        robot: drain_line([row for row in idle if row["robot"] == robot])
        for robot in dict.fromkeys(row["robot"] for row in idle)
    }
    return [joules_of_run(row, lines[row["robot"]]) for row in rows if row["kind"] == "jumps"]
