"""Passive drain: the charge that the electronics take while the robot does nothing (thesis 5.1.4).

Idle runs of several durations give a straight line, charge over duration; its value at a run's own duration
(power on to power off) is taken off the recharged charge. The line's uncertainty is that of its mean response: one
error, common to every run corrected with it, and not part of the scatter between runs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_number, as_values
from stats.lines.regression import EXACT, fit_linear
from stats.results import Result, bounded_texts, share_text
from stats.scatter import Floats, Interval, Value, as_interval
from stats.tails import t_quantile

MINIMUM_RUNS = 3
"""Two fix a line and leave nothing to measure its uncertainty with."""


@dataclass(frozen=True, slots=True)
class DrainEstimate(Result):
    """Passive charge over one duration, read off the fitted line."""

    duration_s: float
    """Where the line was read, in seconds."""
    charge_mah: float
    """The line there, in mAh."""
    se: float
    """Standard error of the line at this duration, mAh: shared by all runs corrected with this fit."""
    ci_low: Value
    """Lower end of Student's interval of the line there, mAh; undefined where the line is exact."""
    ci_high: Value
    """Its upper end."""
    level: float
    """Level of the interval."""
    df: int
    """Number of idle runs minus 2."""
    extrapolated: bool
    """Whether the duration lies outside those of the idle runs."""

    def texts(self) -> tuple[str, str]:
        """Return the charge and its interval in words."""
        return bounded_texts(self.charge_mah, as_interval(self.ci_low, self.ci_high), self.se, self.level, "mAh")


@dataclass(frozen=True, slots=True)
class PassiveDrain(Result):
    """Straight line through the idle runs: charge_mah = intercept_mah + slope_mah_s * duration_s."""

    slope_mah_s: float
    """Charge per second, in mAh/s."""
    intercept_mah: float
    """Charge at duration 0, in mAh: what switching on and off takes."""
    covariance: tuple[tuple[float, float], tuple[float, float]]
    """Covariance of (intercept_mah, slope_mah_s), shape (2, 2), in mAh^2, mAh^2/s and mAh^2/s^2."""
    residual_sd_mah: float
    """Standard deviation of the runs about the line, mAh, with n - 2; at least that of rounding to the resolution."""
    r_squared: Value
    """About the mean."""
    df: int
    """n - 2."""
    n: int
    """Number of idle runs."""
    duration_min_s: float
    """Shortest idle run, in seconds."""
    duration_max_s: float
    """Longest idle run, in seconds."""
    duration_mean_s: float
    """Mean duration of the idle runs, in seconds."""
    charge_mean_mah: float
    """The line goes through the means; it is evaluated from there, where intercept and slope do not cancel."""

    @property
    def slope_se_mah_s(self) -> float:
        """Standard error of the slope."""
        return math.sqrt(self.covariance[1][1])

    @property
    def intercept_se_mah(self) -> float:
        """Standard error of the intercept."""
        return math.sqrt(self.covariance[0][0])

    def slope_ci_mah_s(self, level: float = 0.95) -> Interval | Undefined:
        """Student's interval of the slope."""
        return self._interval(self.slope_mah_s, self.slope_se_mah_s, level)

    def intercept_ci_mah(self, level: float = 0.95) -> Interval | Undefined:
        """Student's interval of the intercept."""
        return self._interval(self.intercept_mah, self.intercept_se_mah, level)

    def _interval(self, middle: float, se: float, level: float) -> Interval | Undefined:
        half = t_quantile(as_level("level", level), self.df) * se
        return (middle - half, middle + half) if self.residual_sd_mah else EXACT

    def error_terms_mah(self, duration_s: float) -> dict[str, float]:
        """Return the two independent errors of the line at a duration: signed standard errors of level and slope."""
        from_mean = as_number("the duration", duration_s, low=0.0) - self.duration_mean_s
        return {"level": self.residual_sd_mah / math.sqrt(self.n), "slope": self.slope_se_mah_s * from_mean}

    def charge_at(self, duration_s: float) -> float:
        """Return the passive charge over `duration_s`, in mAh."""
        return self.charge_mean_mah + self.slope_mah_s * (duration_s - self.duration_mean_s)

    def at(self, duration_s: float, level: float = 0.95) -> DrainEstimate:
        """Return the passive charge over `duration_s` with the uncertainty of the line there.

        Raises `InputRefused` for a duration that is negative or not finite.
        """
        se = math.hypot(*self.error_terms_mah(duration_s).values())
        charge = self.charge_at(duration_s)
        ends = self._interval(charge, se, level)
        low, high = (ends, ends) if isinstance(ends, Undefined) else ends
        return DrainEstimate(
            duration_s=duration_s,
            charge_mah=charge,
            se=se,
            ci_low=low,
            ci_high=high,
            level=level,
            df=self.df,
            extrapolated=not self.duration_min_s <= duration_s <= self.duration_max_s,
        )

    def sentence(self, duration_s: float | None = None) -> str:
        """Return the charge at one duration (by default the mean) in words, and whether that is an extrapolation."""
        duration_s = self.duration_mean_s if duration_s is None else duration_s
        estimate = self.at(duration_s)
        charge, interval = estimate.texts()
        text = (
            f"The electronics draw {charge} mAh in {number_text(duration_s / 60.0)} min ({interval}; "
            f"n = {self.n} idle runs, R squared {share_text(self.r_squared)})"
        )
        if estimate.extrapolated:
            text += (
                f"; {number_text(duration_s / 60.0)} min lies outside the "
                f"{number_text(self.duration_min_s / 60.0)} to {number_text(self.duration_max_s / 60.0)} min "
                "that were measured"
            )
        of_slope = self.slope_ci_mah_s()
        if (self.slope_mah_s if isinstance(of_slope, Undefined) else of_slope[1]) < 0.0:
            text += "; the line falls with time, which no drain does: check durations and charges"
        return f"{text}."


def rounding_sd_mah(resolution_mah: float) -> float:
    """Return the standard deviation of rounding to steps of so many mAh; raises `InputRefused` for a negative one."""
    return as_number("the charger's resolution", resolution_mah, low=0.0) / math.sqrt(12.0)


def why_no_line(durations_s: Sequence[float] | Floats) -> Undefined | None:
    """Return why idle runs of these durations, shape (n,), give no line with its uncertainty; None where they do."""
    if len(durations_s) < MINIMUM_RUNS:
        return Undefined(Reason.TOO_FEW_IDLE_RUNS, needed=MINIMUM_RUNS, n=len(durations_s))
    if min(durations_s) == max(durations_s):
        return Undefined(Reason.ONE_DURATION)
    return None


def fit_passive_drain(duration_s: ArrayLike, charge_mah: ArrayLike, resolution_mah: float = 0.0) -> PassiveDrain:
    """Fit charge over duration on idle runs, both of shape (n,), by least squares.

    A charger that counts in steps of `resolution_mah` rounds every charge, standard deviation step / sqrt(12): runs
    that happen to lie closer to the line than that do not make the line better known.

    Raises `InputRefused` for fewer than 3 runs, a single duration, values that are missing or infinite, lengths that
    differ and negative durations.

    >>> line = fit_passive_drain([60, 120, 240, 480], [8, 15, 30, 58])
    >>> round(line.at(300).charge_mah, 2)
    36.7
    """
    durations, charges = as_values("the durations", duration_s), as_values("the charges", charge_mah)
    if durations.size != charges.size:
        raise InputRefused(
            f"there are {durations.size} durations and {charges.size} charges: give one charge for each duration."
        )
    if durations.size and float(durations.min()) < 0.0:
        raise InputRefused(f"a duration is {float(durations.min()):g} s: durations are 0 or more.")
    none = why_no_line(durations)
    if none is not None:
        raise InputRefused(f"{none.reason}: give more (`fit_linear` gives the bare line of two).")
    n = durations.size
    fit = fit_linear(charges, {"duration": durations})
    residual_sd_mah = max(fit.spread("the drain line")[1], rounding_sd_mah(resolution_mah))
    mean = fit.means[0]
    away = durations - mean
    of_slope = residual_sd_mah**2 / float(away @ away)
    of_intercept, of_both = residual_sd_mah**2 / n + mean * mean * of_slope, -mean * of_slope
    return PassiveDrain(
        slope_mah_s=fit.coefficients[1],
        intercept_mah=fit.coefficients[0],
        covariance=((of_intercept, of_both), (of_both, of_slope)),
        residual_sd_mah=residual_sd_mah,
        r_squared=Undefined(Reason.ALL_CHARGES_EQUAL) if np.ptp(charges) == 0.0 else fit.r_squared,
        df=fit.df,
        n=n,
        duration_min_s=float(np.min(durations)),
        duration_max_s=float(np.max(durations)),
        duration_mean_s=mean,
        charge_mean_mah=fit.response_mean,
    )
