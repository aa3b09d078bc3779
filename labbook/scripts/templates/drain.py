"""The numbers of a passive-drain line (thesis 5.1.4): slope, intercept, R squared, and the charge at a duration."""

import math

from labbook.scripts.templates.joules import DrainLine, drain_line, line_errors_mah, passive_charge_mah
from labbook.scripts.templates.runs import Number, Rows
from labbook.scripts.templates.shared import student

RUN_DURATION_S = 720.0
"""Of a run of jumps, from power on to power off, at which the line is read."""
SECONDS_PER_MINUTE = 60.0


def slope(rows: Rows) -> Number:
    """Return the slope in mAh/min."""
    line = drain_line(rows)
    return student(line.slope_mah_s * SECONDS_PER_MINUTE, line.slope_se_mah_s * SECONDS_PER_MINUTE, line.n - 2.0)


def intercept(rows: Rows) -> Number:
    """Return the charge at duration 0 in mAh."""
    return charge_at(drain_line(rows), 0.0)


def at_run(rows: Rows) -> Number:
    """Return the passive charge of a run in mAh."""
    return charge_at(drain_line(rows), RUN_DURATION_S)


def charge_at(line: DrainLine, duration_s: float) -> Number:
    """Return the line at a duration in mAh, with n - 2 degrees of freedom."""
    se = math.hypot(*line_errors_mah(line, duration_s).values())
    return student(passive_charge_mah(line, duration_s), se, line.n - 2.0)


def r_squared(rows: Rows) -> Number:
    """Return the share of the charges' scatter that the line explains."""
    return {"value": drain_line(rows).r_squared}
