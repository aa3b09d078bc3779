"""The test that decides a comparison, by the days that hold both sides (docs/statistics.md, "Which test leads")."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

from labbook.scripts.templates.runs import Number, Pair, Run, Runs, Shared, of_conditions, values_of
from labbook.scripts.templates.shared import (
    LEVEL,
    of_mean,
    over_error,
    quantile,
    shared_covariance,
    shared_se,
    two_sided_p,
    weighted_sum,
)

PAIR: Pair = ((), ())
"""The conditions of the control, and those that are compared with it."""
ONE_SIDED = False
"""Whether p is against a saving alone."""
DAYS_AS_UNITS = 4
"""Shared days from which the day is the unit."""


class Means(NamedTuple):
    """Means C of the control and T of the treatment over shared days, with what their errors are made of."""

    control: float
    treated: float
    v_cc: float
    v_ct: float
    v_tt: float
    df: float
    control_shared: Shared
    treated_shared: Shared


def runs_by_day(runs: Runs, pair: Pair) -> dict[str, tuple[list[Run], list[Run]]]:
    """Return the runs of control and treatment of every day that holds both, by day."""
    control, treated = of_conditions(runs, pair[0]), of_conditions(runs, pair[1])
    days = sorted({run.row["day"] for run in control} & {run.row["day"] for run in treated})
    return {
        day: ([run for run in control if run.row["day"] == day], [run for run in treated if run.row["day"] == day])
        for day in days
    }


def mean_of(runs: Runs) -> float:
    """Return the mean of runs."""
    return math.fsum(values_of(runs)) / len(runs)


def squares_of(runs: Runs) -> float:
    """Return the sum of squares of runs about their mean."""
    return float(np.var(values_of(runs))) * len(runs)


def shared_of(runs: Runs) -> Shared:
    """Return what the mean of runs shares with others."""
    return of_mean([run.shared for run in runs])


def paired_means(runs: Runs, pair: Pair) -> Means:
    """Compare day means, from four shared days on: the day is the unit, df = days - 1.

    A paired t with unequal variances is conservative (Bakirov and Szekely 2005; Ibragimov and Mueller 2010).
    """
    days = list(runs_by_day(runs, pair).values())
    k = len(days)
    control, treated = ([mean_of(day[side]) for day in days] for side in (0, 1))
    (v_cc, v_ct), (_, v_tt) = np.cov(control, treated) / k
    of_control, of_treated = (of_mean([shared_of(day[side]) for day in days]) for side in (0, 1))
    means = math.fsum(control) / k, math.fsum(treated) / k
    return Means(*means, float(v_cc), float(v_ct), float(v_tt), k - 1.0, of_control, of_treated)


def day_weights(days: Sequence[tuple[list[Run], list[Run]]]) -> list[float]:
    """Return the weight n m / (n + m) of each day of n control and m treated runs, as least squares has it."""
    weights = [len(control) * len(treated) / (len(control) + len(treated)) for control, treated in days]
    return [weight / math.fsum(weights) for weight in weights]


def side_within_days(sides: Sequence[list[Run]], weights: Sequence[float]) -> tuple[float, float, int, Shared]:
    """Return the weighted mean of a side over days, its variance by the runs within days, its df, its shared errors."""
    df = sum(len(side) - 1 for side in sides)
    of_a_run = math.fsum(map(squares_of, sides)) / max(df, 1)
    variance = of_a_run * math.fsum(weight**2 / len(side) for weight, side in zip(weights, sides, strict=True))
    mean = math.fsum(weight * mean_of(side) for weight, side in zip(weights, sides, strict=True))
    return mean, variance, df, weighted_sum(list(map(shared_of, sides)), weights)


def means_within_days(runs: Runs, pair: Pair) -> Means:
    """Compare runs within days, where fewer days are shared: the run is the unit, df the smaller side's.

    These degrees of freedom bound Welch's (Mickey and Brown 1966). With 0 of them nothing is claimed; the means are of
    all runs where no day is shared.
    """
    days = list(runs_by_day(runs, pair).values())
    if not days:
        control, treated = (mean_of(of_conditions(runs, conditions)) for conditions in pair)
        return Means(control, treated, 0.0, 0.0, 0.0, 0.0, {}, {})
    weights = day_weights(days)
    control, v_cc, df_control, of_control = side_within_days([day[0] for day in days], weights)
    treated, v_tt, df_treated, of_treated = side_within_days([day[1] for day in days], weights)
    return Means(control, treated, v_cc, 0.0, v_tt, float(min(df_control, df_treated)), of_control, of_treated)


def compare(runs: Runs, pair: Pair) -> Means:
    """Compare by the rule that the days decide, whatever was measured."""
    if len(runs_by_day(runs, pair)) >= DAYS_AS_UNITS:
        return paired_means(runs, pair)
    return means_within_days(runs, pair)


def own_variance(means: Means, ratio: float) -> float:
    """Return the variance of T - ratio * C by the scatter alone: V_TT - 2 r V_CT + r^2 V_CC."""
    return means.v_tt - 2.0 * ratio * means.v_ct + ratio**2 * means.v_cc


def shared_difference(means: Means, ratio: float) -> Shared:
    """Return the shared errors of T - ratio * C: where both sides have the same, they cancel."""
    return weighted_sum([means.treated_shared, means.control_shared], [1.0, -ratio])


def error_of(means: Means, ratio: float) -> float:
    """Return the standard error of T - ratio * C, shared errors with it."""
    shared = shared_difference(means, ratio)
    return math.sqrt(own_variance(means, ratio) + shared_covariance(shared, shared, LEVEL, means.df))


def t_of(means: Means) -> float:
    """Return t of the difference T - C."""
    return over_error(means.treated - means.control, error_of(means, 1.0))


def p_of(means: Means) -> float:
    """Return the p of no difference, two-sided or against a saving alone."""
    if ONE_SIDED:
        return float(stats.t.sf(-t_of(means), means.df))
    return two_sided_p(t_of(means), means.df)


def difference_of_means(runs: Runs) -> Number:
    """Return T - C with its interval, and t and p of no difference, where something is claimed of it."""
    means = compare(runs, PAIR)
    value = means.treated - means.control
    if not means.df:
        return {"value": value}
    half = quantile(LEVEL, means.df) * error_of(means, 1.0)
    return {
        "value": value,
        "se": math.sqrt(own_variance(means, 1.0)),
        "shared_se": shared_se(shared_difference(means, 1.0)),
        "ci_low": value - half,
        "ci_high": value + half,
        "df": means.df,
        "t": t_of(means),
        "p": p_of(means),
    }


def fieller(means: Means) -> tuple[float, float] | None:
    """Return Fieller's interval of the saving 100 (1 - T / C) in percent (Fieller 1954); None where it is unbounded.

    It holds the ratios r at which (T - r C)^2 <= q^2 V(r), the roots of a r^2 - 2 b r + g = 0 with a = C^2 - q^2 V_CC;
    written for the saving s = 1 - r, so that nothing cancels.
    """
    q2, control = quantile(LEVEL, means.df) ** 2, means.control
    of_control, of_treated = means.control_shared, means.treated_shared
    v_cc = means.v_cc + shared_covariance(of_control, of_control, LEVEL, means.df)
    v_ct = means.v_ct + shared_covariance(of_control, of_treated, LEVEL, means.df)
    v_tt = means.v_tt + shared_covariance(of_treated, of_treated, LEVEL, means.df)
    a = control**2 - q2 * v_cc
    if a <= 0.0:
        return None
    ratio = means.treated / control
    root = math.sqrt(q2 * (control * error_of(means, ratio)) ** 2 - q2**2 * (v_cc * v_tt - v_ct**2))
    middle = control * (control - means.treated) - q2 * (v_cc - v_ct)
    return 100.0 * (middle - root) / a, 100.0 * (middle + root) / a


def saving_of(means: Means) -> Number:
    """Return the saving 100 (1 - T / C) in percent, with Fieller's interval where something is claimed of it."""
    value = 100.0 * (means.control - means.treated) / means.control
    if not means.df:
        return {"value": value}
    ratio, interval = means.treated / means.control, fieller(means)
    return {
        "value": value,
        "se": 100.0 * math.sqrt(own_variance(means, ratio)) / means.control,
        "shared_se": 100.0 * shared_se(shared_difference(means, ratio)) / means.control,
        "df": means.df,
        **({} if interval is None else {"ci_low": interval[0], "ci_high": interval[1]}),
    }


def savings(runs: Runs) -> Number:
    """Return the saving of the treatment in percent of the control."""
    return saving_of(compare(runs, PAIR))


def t_of_saving(runs: Runs) -> Number:
    """Return t of the test of no difference, positive for a saving, with its degrees of freedom."""
    means = compare(runs, PAIR)
    return {"value": -t_of(means), "df": means.df}


def mean_of_control(runs: Runs) -> Number:
    """Return the mean of the control over shared days."""
    return {"value": compare(runs, PAIR).control}


def run_sd(runs: Runs) -> Number:
    """Return the standard deviation of runs within shared days and conditions, of both sides together."""
    sides = [side for day in runs_by_day(runs, PAIR).values() for side in day]
    df = sum(len(side) - 1 for side in sides)
    return {"value": math.sqrt(math.fsum(map(squares_of, sides)) / df)}
