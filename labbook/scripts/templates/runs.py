"""Runs with their values, read from the table beside the script, and printing what was computed."""

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Row = dict[str, str]
"""A line of the table, by the names of its columns."""
Rows = Sequence[Row]
Number = Mapping[str, float]
"""A value, and by their names what belongs to it: standard errors, ends of its interval, degrees of freedom."""


class Source(NamedTuple):
    """An error that several runs share: the fit that it comes from, which of its terms, its degrees of freedom."""

    fit: str
    term: str
    df: float


Shared = dict[Source, float]
"""Signed standard errors that a value shares with other values, by their source; sources are independent."""


class Run(NamedTuple):
    """A run: its line of the table, its value, and the errors that it shares with other runs."""

    row: Row
    value: float
    shared: Shared


Runs = Sequence[Run]
Pair = tuple[Sequence[str], Sequence[str]]
"""The conditions of a control, and those that are compared with it."""


def read(table: str) -> list[Row]:
    """Read the table that lies beside this script."""
    with (Path(__file__).parent / table).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def of_conditions(runs: Runs, conditions: Sequence[str]) -> list[Run]:
    """Return the runs of some conditions, one condition after the other."""
    return [run for condition in conditions for run in runs if run.row["condition"] == condition]


def values_of(runs: Runs) -> list[float]:
    """Return the values of runs."""
    return [run.value for run in runs]


PICKED = "value"
"""Which of several numbers that were computed together is asked for."""


def picked(found: Number) -> Number:
    """Return the number that is asked for, with the degrees of freedom."""
    return {"value": found[PICKED], **({"df": found["df"]} if "df" in found else {})}


def show(number: Number) -> None:
    """Print the number with all its digits, and below it what belongs to it."""
    for name, value in number.items():
        print(repr(float(value)) if name == "value" else f"{name} = {float(value)!r}")


"""Errors that values share (docs/statistics.md, "The shared passive-drain error"): they do not average out."""

LEVEL = 0.95
"""Of the intervals."""
ENOUGH_DF = 4.0
"""Degrees of freedom of a fit from which its error counts as Welch and Satterthwaite have it."""


def quantile(level: float, df: float) -> float:
    """Return the half width of Student's two-sided interval in standard errors."""
    return float(stats.t.isf((1.0 - level) / 2.0, df))


def student(value: float, se: float, df: float) -> Number:
    """Return a value with its standard error and Student's interval."""
    half = quantile(LEVEL, df) * se
    return {"value": value, "se": se, "ci_low": value - half, "ci_high": value + half, "df": df}


def two_sided_p(t: float, df: float) -> float:
    """Return the chance of a t as far from 0 as this, to either side."""
    return 2.0 * float(stats.t.sf(abs(t), df))


def over_error(value: float, error: float) -> float:
    """Return t, a value over its standard error; infinite where there is none."""
    return value / error if error else math.copysign(math.inf, value)


def one_sided_tests(t_low: float, t_high: float, df: float) -> Number:
    """Return t and p of the tests against a lower and an upper bound, and the larger p; no bound rejects nothing."""
    p_low, p_high = float(stats.t.sf(t_low, df)), float(stats.t.cdf(t_high, df))
    return {"t_low": t_low, "p_low": p_low, "t_high": t_high, "p_high": p_high, "p": max(p_low, p_high)}


def satterthwaite_df(parts: Sequence[tuple[float, float]]) -> float:
    """Return the degrees of freedom of a sum of variances, each with its own (Welch 1938, Satterthwaite 1946)."""
    total = math.fsum(variance for variance, _df in parts)
    doubt = math.fsum((variance / total) ** 2 / df for variance, df in parts) if total > 0.0 else 0.0
    return 1.0 / doubt if doubt > 0.0 else math.inf


def weighted_sum(errors: Sequence[Shared], weights: Sequence[float]) -> Shared:
    """Return the shared errors of a weighted sum of values: the weighted sum of each source."""
    total: Shared = {}
    for error, weight in zip(errors, weights, strict=True):
        for source, size in error.items():
            total[source] = total.get(source, 0.0) + weight * size
    return total


def of_mean(errors: Sequence[Shared]) -> Shared:
    """Return the shared errors of a mean."""
    return weighted_sum(errors, [1.0 / len(errors)] * len(errors))


def shared_se(error: Shared) -> float:
    """Return the standard error of all sources together: they are independent."""
    return math.hypot(*error.values())


def shared_df(error: Shared) -> float:
    """Return the degrees of freedom of the fits behind an error, Satterthwaite's where they are several."""
    variances: dict[tuple[str, float], float] = {}
    for source, size in error.items():
        variances[source.fit, source.df] = variances.get((source.fit, source.df), 0.0) + size * size
    return satterthwaite_df([(variance, df) for (_fit, df), variance in variances.items()])


def weight_of(source: Source, level: float, df: float) -> float:
    """Return by how much a source counts beside a quantile of df: a fit of few degrees of freedom has its own."""
    return 1.0 if source.df >= ENOUGH_DF else (quantile(level, source.df) / quantile(level, df)) ** 2


def shared_covariance(one: Shared, other: Shared, level: float, df: float) -> float:
    """Return the covariance of two values by the errors that they share, as it counts beside a quantile of df."""
    return math.fsum(weight_of(source, level, df) * size * other.get(source, 0.0) for source, size in one.items())


"""Joules a jump of each run, from the charge that was put back after it and the passive drain of idle runs."""

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


"""The apex height of each run: the mean of its jumps that count, and what it takes from a calibration."""


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


"""Outcomes of which the table has one value a run, as the peak force on a plate."""


def measured_of_runs(rows: Rows) -> list[Run]:
    """Return every run with the value that was measured of it."""
    return [Run(row, float(row["value"]), {}) for row in rows]


"""Values as at the mean position of their day: a drift over the day is taken off.

Source: docs/statistics.md, "Order within the day".
"""

GROUPS: Mapping[str, Pair] = {}
"""By group, the conditions of its control and of its treatment."""


def indicators(labels: Sequence[str]) -> NDArray[np.float64]:
    """Return a column of 0 and 1 for each different label."""
    return np.array([[float(label == each) for each in dict.fromkeys(labels)] for label in labels])


def at_mean_position(runs: Runs) -> list[Run]:
    """Take slope * (position - mean position of the group's day) off every value.

    The slope is that of least squares of value on position, with a constant for every side of a group's day and for
    every condition. Its error is one that all values share.
    """
    placed = [
        (run, f"{group} {run.row['day']}", side)
        for group, pair in GROUPS.items()
        for side in (0, 1)
        for run in of_conditions(runs, pair[side])
    ]
    found, days = [run for run, _day, _side in placed], [day for _run, day, _side in placed]
    position, value = np.array([float(run.row["position_in_day"]) for run in found]), np.array(values_of(found))
    sides = indicators([f"{day} {side}" for _run, day, side in placed])
    constants = np.hstack([sides, indicators([run.row["condition"] for run in found])])
    free = position - constants @ np.linalg.lstsq(constants, position)[0]
    squares = float(free @ free)
    slope = float(free @ value) / squares
    left = value - slope * position
    left = left - constants @ np.linalg.lstsq(constants, left)[0]
    df = len(found) - int(np.linalg.matrix_rank(constants)) - 1.0
    slope_se = math.sqrt(float(left @ left) / df / squares)
    of_day = indicators(days)
    away = position - of_day @ (of_day.T @ position / of_day.sum(axis=0))
    return [
        Run(run.row, run.value - slope * off, {**run.shared, Source("position", "slope", df): -slope_se * off})
        for run, off in zip(found, away.tolist(), strict=True)
    ]


"""The numbers of a passive-drain line (thesis 5.1.4): slope, intercept, R squared, and the charge at a duration."""

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


"""Mean and standard deviation of the runs of a condition."""


def half_width(se: float, df: float, shared: Shared) -> float:
    """Return the half width of the interval of a mean with its own standard error and shared errors.

    One quantile over both (Welch, Satterthwaite), no less than the scatter alone has; of a fit with few degrees of
    freedom two half widths in quadrature.
    """
    common, alone = shared_se(shared), quantile(LEVEL, df) * se
    if se == 0.0:
        return quantile(LEVEL, shared_df(shared)) * common
    if shared_df(shared) < ENOUGH_DF:
        return math.hypot(alone, quantile(LEVEL, shared_df(shared)) * common)
    together = satterthwaite_df([(se**2, df), (common**2, shared_df(shared))])
    return max(alone, quantile(LEVEL, together) * math.hypot(se, common))


def condition_mean(runs: Runs) -> Number:
    """Return the mean of the runs, its standard error SD / sqrt(n), the error that runs share, and its interval."""
    n, shared = len(runs), of_mean([run.shared for run in runs])
    value = math.fsum(values_of(runs)) / n
    if n < 2:
        return {"value": value, "shared_se": shared_se(shared), "df": 0.0}
    se = float(np.std(values_of(runs), ddof=1)) / math.sqrt(n)
    half = half_width(se, n - 1.0, shared)
    return {
        "value": value,
        "se": se,
        "shared_se": shared_se(shared),
        "ci_low": value - half,
        "ci_high": value + half,
        "df": n - 1.0,
    }


def condition_sd(runs: Runs) -> Number:
    """Return the standard deviation of the runs, with n - 1."""
    return {"value": float(np.std(values_of(runs), ddof=1))}


"""One-way analysis of variance over the treated conditions of a group (thesis 5.2.1)."""

CONDITIONS: Sequence[str] = ()
"""The conditions whose means are compared."""


def analysis_of_variance(runs: Runs) -> Number:
    """Return F, the mean square between conditions over that within, and the upper tail of F."""
    found = stats.f_oneway(*(values_of(of_conditions(runs, [condition])) for condition in CONDITIONS))
    return {"f": float(found.statistic), "p": float(found.pvalue)}


"""How far the runs of a battery pack lie from the means of their conditions."""

PACK = ""
"""The pack that is asked about."""


def pack_deviation(runs: Runs) -> Number:
    """Return the mean deviation of the pack's runs, with Student's interval."""
    means = {
        condition: float(np.mean(values_of(of_conditions(runs, [condition]))))
        for condition in dict.fromkeys(run.row["condition"] for run in runs)
    }
    away = [run.value - means[run.row["condition"]] for run in runs if run.row["battery"] == PACK]
    n, value = len(away), math.fsum(away) / len(away)
    if n < 2:  # one run has no scatter
        return {"value": value}
    return student(value, float(np.std(away, ddof=1)) / math.sqrt(n), n - 1.0)


"""What the uncertainty of joules a jump is made of (thesis 5.1.4): of one run, and of the mean of a condition's runs.

A charger that counts in steps errs by at most half a step. Where that differs from run to run the scatter holds it
already; where repeats are rounded alike, their mean errs by it, too. The reference voltage counts as known.
"""


def joules_of_mah(runs: Runs) -> float:
    """Return what 1 mAh is worth in joules a jump, the mean over runs."""
    return float(np.mean([COULOMB_PER_MAH * REFERENCE_VOLTAGE_V / float(run.row["jumps_made"]) for run in runs]))


def parted(shared: Shared, *, rounding: bool) -> Shared:
    """Return the errors of rounding among those that runs share, or those of the drain line."""
    return {source: size for source, size in shared.items() if (source.fit == "rounding") is rounding}


def of_one_step(runs: Runs) -> float:
    """Return the standard deviation that the coarsest step of the charger gives one run."""
    return joules_of_mah(runs) * rounding_sd_mah(max(float(run.row["resolution_mah"]) for run in runs))


def rounded_alike(runs: Runs) -> float:
    """Return what rounding gives the mean where repeats are rounded alike; 0 where they are not."""
    return shared_se(of_mean([parted(run.shared, rounding=True) for run in runs]))


def budget(runs: Runs) -> Number:
    """Return what each source gives one run and the mean, all in quadrature, and what 1 mAh is worth."""
    n, alike, step = len(runs), rounded_alike(runs), of_one_step(runs)
    scatter = float(np.std(values_of(runs), ddof=1))
    drains = [parted(run.shared, rounding=False) for run in runs]
    drain = math.sqrt(float(np.mean(np.square([shared_se(each) for each in drains]))))
    drain_of_mean = shared_se(of_mean(drains))  # all runs share it
    return {
        "scatter between runs": scatter,
        "drain fit": drain,
        "charger resolution": step,
        "reference voltage": 0.0,
        "in all": math.hypot(scatter, drain, step if alike else 0.0),
        "scatter between runs, mean": scatter / math.sqrt(n),
        "drain fit, mean": drain_of_mean,
        "charger resolution, mean": alike or step / math.sqrt(n),
        "reference voltage, mean": 0.0,
        "in all, mean": math.hypot(scatter / math.sqrt(n), drain_of_mean, alike),
        "1 mAh": joules_of_mah(runs),
    }
