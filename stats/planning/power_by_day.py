"""Power of the tests that decide by shared days (`stats.days.decision`), for a layout of runs over days.

Runs are normal with one standard deviation about their day's mean; what days add cancels within a day. Paired on day
means, the difference over k days has k - 1 degrees of freedom; where days hold unequal numbers of runs the noncentral t
is an approximation. Within days the critical value is that of the smaller degrees of freedom of both sides, and the
statistic is taken to have Satterthwaite's. Of bounds in percent of the control's mean each has its own scatter, and
both are taken to move together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import number_text, stated_text
from data_schema.vocabulary import Remark, Undefined
from stats.checks import as_level, as_number
from stats.days.decision import LEAST_DAYS
from stats.exact.tails import t_tails, t_upper_quantile
from stats.planning.power import Power, assumed_text, within_both


def power_by_day(difference: float, sd: float, days: Sequence[tuple[int, int]], alpha: float = 0.05) -> Power:
    """Return the power for a true difference; `days` has the runs of both sides of each day, the control's first.

    Days without both enter nothing, as in the test. The power is undefined where the days can claim nothing. Raises
    `InputRefused` for negative counts.

    >>> round(power_by_day(11.0, 10.0, [(5, 8)] * 5).power, 2)
    0.89
    """
    difference, alpha = as_number("difference", difference), as_level("alpha", alpha)
    sd = as_number("sd", sd, above=0.0)
    found = _layout(days)
    test = f"the test by {found.k} shared days for a difference of {number_text(difference)} at sd {number_text(sd)}"
    never = Remark(Reason.NO_TRUE_DIFFERENCE) if difference == 0.0 else None
    if found.critical_df < 1.0:
        return Power(test, found.sizes, alpha, Undefined(Reason.NO_GROUP_WITH_CLAIM), never)
    ncp = difference / (sd * found.error(1.0))
    critical = t_upper_quantile(Fraction(alpha) / 2, found.critical_df)
    power = t_tails(critical, found.df, ncp)[1] + t_tails(critical, found.df, -ncp)[1]
    return Power(test, found.sizes, alpha, min(1.0, power), never)


def power_equivalence_by_day(
    sd: float,
    low: float,
    high: float,
    days: Sequence[tuple[int, int]],
    alpha: float = 0.05,
    *,
    difference: float = 0.0,
    control_mean: float | None = None,
) -> Power:
    """Return the power of both one-sided tests (TOST) that a true difference lies between bounds, by shared days.

    With `control_mean` the bounds are in percent of that mean, which the study estimates; else in the unit of the
    values. Raises `InputRefused` for numbers that no study has.

    >>> round(power_equivalence_by_day(4.0, -5.0, 5.0, [(3, 10)] * 5).power, 2)
    0.93
    """
    sd, difference = as_number("sd", sd, above=0.0), as_number("difference", difference)
    low = as_number("low", low, above=-math.inf if control_mean is None else -100.0)
    high, alpha = as_number("high", high, above=low), as_level("alpha", alpha)
    if alpha >= 0.5:
        raise InputRefused(f"alpha is {alpha!r}: give a number below 0.5 for an equivalence test.")
    found = _layout(days)
    ratios, ends, of = (1.0, 1.0), (low, high), ""
    if control_mean is not None:
        mean = as_number("the control's mean", control_mean, above=0.0)
        ratios, ends = (1.0 + low / 100.0, 1.0 + high / 100.0), (low / 100.0 * mean, high / 100.0 * mean)
        of = f" % of the control's mean, itself estimated and {assumed_text(mean, sd)} in truth,"
    test = (
        f"the equivalence test (TOST) by {found.k} shared days between {stated_text(low)} and {stated_text(high)}{of} "
        f"for a difference of {assumed_text(difference, sd)} at sd {number_text(sd)}"
    )
    never = None
    if not ends[0] < difference < ends[1]:
        bounds = " and ".join(f"{end:g}" for end in ends)
        never = Remark(Reason.NOT_BETWEEN_BOUNDS, difference=difference, bounds=bounds)
    if found.critical_df < 1.0:
        return Power(test, found.sizes, alpha, Undefined(Reason.NO_GROUP_WITH_CLAIM), never)
    at_low, at_high = ((end - difference) / (sd * found.error(ratio)) for end, ratio in zip(ends, ratios, strict=True))
    critical = np.array([t_upper_quantile(Fraction(alpha), found.critical_df)])
    return Power(test, found.sizes, alpha, min(1.0, float(within_both(at_low, at_high, critical, found.df)[0])), never)


@dataclass(frozen=True, slots=True)
class _Layout:
    """What a layout makes of one standard deviation of runs: variances of both means, and degrees of freedom.

    `critical_df` are those of the critical value, 0 where nothing is claimed; `df` those of the statistic.
    """

    k: int
    sizes: tuple[int, int]
    variances: tuple[float, float]
    df: float
    critical_df: float

    def error(self, ratio: float) -> float:
        """Return the standard error of T - ratio C in standard deviations of runs."""
        return math.sqrt(self.variances[1] + ratio * ratio * self.variances[0])


def _layout(days: Sequence[tuple[int, int]]) -> _Layout:
    """Return what the rule that fits the days makes of them; raises `InputRefused` for negative counts."""
    if any(control < 0 or treated < 0 for control, treated in days):
        raise InputRefused(f"the days hold {list(days)!r} runs: give counts of 0 or more.")
    shared = [(control, treated) for control, treated in days if control and treated]
    k, sizes = len(shared), (sum(control for control, _ in shared), sum(treated for _, treated in shared))
    if k >= LEAST_DAYS:
        v_c, v_t = (math.fsum(1.0 / day[side] for day in shared) / k**2 for side in (0, 1))
        return _Layout(k, sizes, (v_c, v_t), k - 1.0, k - 1.0)
    df_c, df_t = (total - k for total in sizes)
    if not shared or min(df_c, df_t) < 1:
        return _Layout(k, sizes, (0.0, 0.0), 0.0, 0.0)
    sums = [control * treated / (control + treated) for control, treated in shared]
    weights = [each / math.fsum(sums) for each in sums]
    v_c, v_t = (
        math.fsum(weight**2 / day[side] for weight, day in zip(weights, shared, strict=True)) for side in (0, 1)
    )
    df = (v_c + v_t) ** 2 / (v_c**2 / df_c + v_t**2 / df_t)
    return _Layout(k, sizes, (v_c, v_t), df, float(min(df_c, df_t)))
