"""Power of the test that decides by shared days (`stats.days.decision`), for a layout of runs over days.

Runs are normal with one standard deviation about their day's mean; what days add cancels within a day. Paired on day
means, the difference over k days has k - 1 degrees of freedom; where days hold unequal numbers of runs the noncentral t
is an approximation. Within days the critical value is that of the smaller degrees of freedom of both sides, and the
statistic is taken to have Satterthwaite's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import number_text
from data_schema.vocabulary import Remark, Undefined
from stats.checks import as_level, as_number
from stats.days.decision import LEAST_DAYS
from stats.exact.tails import t_tails, t_upper_quantile
from stats.planning.power import Power


def power_by_day(difference: float, sd: float, days: Sequence[tuple[int, int]], alpha: float = 0.05) -> Power:
    """Return the power for a true difference; `days` has the runs of both sides of each day, the control's first.

    Days without both enter nothing, as in the test. The power is undefined where the days can claim nothing. Raises
    `InputRefused` for negative counts.

    >>> round(power_by_day(11.0, 10.0, [(5, 8)] * 5).power, 2)
    0.89
    """
    difference, alpha = as_number("difference", difference), as_level("alpha", alpha)
    sd = as_number("sd", sd, above=0.0)
    if any(control < 0 or treated < 0 for control, treated in days):
        raise InputRefused(f"the days hold {list(days)!r} runs: give counts of 0 or more.")
    shared = [(control, treated) for control, treated in days if control and treated]
    k, sizes = len(shared), (sum(control for control, _ in shared), sum(treated for _, treated in shared))
    test = f"the test by {k} shared days for a difference of {number_text(difference)} at sd {number_text(sd)}"
    never = Remark(Reason.NO_TRUE_DIFFERENCE) if difference == 0.0 else None
    if k >= LEAST_DAYS:
        variance = math.fsum(1.0 / control + 1.0 / treated for control, treated in shared) / k**2
        df = critical_df = float(k - 1)
    else:
        dfs = tuple(total - k for total in sizes)
        if not shared or min(dfs) < 1:
            return Power(test, sizes, alpha, Undefined(Reason.NO_GROUP_WITH_CLAIM), never)
        sums = [control * treated / (control + treated) for control, treated in shared]
        weights = [each / math.fsum(sums) for each in sums]
        of_side = [
            math.fsum(weight**2 / day[side] for weight, day in zip(weights, shared, strict=True)) for side in (0, 1)
        ]
        variance, critical_df = math.fsum(of_side), float(min(dfs))
        df = variance**2 / math.fsum(each**2 / own for each, own in zip(of_side, dfs, strict=True))
    ncp = difference / (sd * math.sqrt(variance))
    critical = t_upper_quantile(Fraction(alpha) / 2, critical_df)
    power = t_tails(critical, df, ncp)[1] + t_tails(critical, df, -ncp)[1]
    return Power(test, sizes, alpha, min(1.0, power), never)
