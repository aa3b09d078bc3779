"""One effect for a campaign: the mean of its groups' savings, each counted once (docs/statistics.md)."""

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from labbook.scripts.templates.days import (
    DAYS_AS_UNITS,
    Means,
    compare,
    mean_of,
    own_variance,
    runs_by_day,
    shared_difference,
)
from labbook.scripts.templates.runs import Number, Pair, Runs, Shared
from labbook.scripts.templates.shared import (
    LEVEL,
    of_mean,
    one_sided_tests,
    over_error,
    quantile,
    satterthwaite_df,
    shared_covariance,
    shared_se,
    two_sided_p,
    weighted_sum,
)

CLAIMED: Mapping[str, Pair] = {}
"""By group, the conditions of its control and of its treatment; groups without a test of their own are left out."""
ONE_SIDED_OVERALL = False
"""Whether p is against a saving alone."""
LOWEST_CHANGE = -5.0
"""The lower bound of the mean change, in percent of each control; infinite where there is none."""
HIGHEST_CHANGE = 5.0
"""The upper bound."""


class Saving(NamedTuple):
    """The saving of a group as a share of its control, S = 1 - T / C, and its errors, with the sign of T."""

    saved: float
    variance: float
    df: float
    by_day: dict[str, float]
    shared: Shared


class Overall(NamedTuple):
    """The mean of the savings, its standard error, what is of shared errors and what not, and its df."""

    saved: float
    error: float
    own_se: float
    shared_se: float
    df: float


def saving_of_group(runs: Runs, pair: Pair) -> Saving:
    """Return a group's saving; of four days or more also what each day departs by, over sqrt(k (k - 1))."""
    means, days = compare(runs, pair), runs_by_day(runs, pair)
    ratio, k, by_day = means.treated / means.control, len(days), {}
    if k >= DAYS_AS_UNITS:
        by_day = {
            day: departure(means, ratio, control, treated) / math.sqrt(k * (k - 1))
            for day, (control, treated) in days.items()
        }
    shared = weighted_sum([shared_difference(means, ratio)], [1.0 / means.control])
    return Saving(1.0 - ratio, own_variance(means, ratio) / means.control**2, means.df, by_day, shared)


def departure(means: Means, ratio: float, control: Runs, treated: Runs) -> float:
    """Return by how much T - ratio C of a day departs from its mean over the days, as a share of C."""
    return ((mean_of(treated) - means.treated) - ratio * (mean_of(control) - means.control)) / means.control


def savings_of_groups(runs: Runs) -> list[Saving]:
    """Return the saving of every group."""
    return [saving_of_group(runs, pair) for pair in CLAIMED.values()]


def over_groups(savings: Sequence[Saving]) -> Overall:
    """Return the mean saving: what a day does to all groups is added up before it is squared."""
    n, days = len(savings), sorted({day for saving in savings for day in saving.by_day})
    shares = [math.fsum(saving.by_day.get(day, 0.0) for saving in savings) / n for day in days]
    within = math.fsum(saving.variance for saving in savings if not saving.by_day) / n**2
    variance = math.fsum(share**2 for share in shares) + within
    df = satterthwaite_df([(saving.variance, saving.df) for saving in savings])
    df = min(df, len(days) - 1.0) if days else df
    shared = of_mean([saving.shared for saving in savings])
    error = math.sqrt(variance + shared_covariance(shared, shared, LEVEL, df))
    saved = math.fsum(saving.saved for saving in savings) / n
    return Overall(saved, error, math.sqrt(variance), shared_se(shared), df)


def overall_savings(runs: Runs) -> Number:
    """Return the mean saving over groups in percent, with its interval, t, and p: two-sided, or of a saving alone."""
    found = over_groups(savings_of_groups(runs))
    value, half = 100.0 * found.saved, 100.0 * quantile(LEVEL, found.df) * found.error
    t = over_error(found.saved, found.error)
    return {
        "value": value,
        "se": 100.0 * found.own_se,
        "shared_se": 100.0 * found.shared_se,
        "ci_low": value - half,
        "ci_high": value + half,
        "df": found.df,
        "t": t,
        "p": float(stats.t.sf(t, found.df)) if ONE_SIDED_OVERALL else two_sided_p(t, found.df),
    }


def spread(runs: Runs) -> Number:
    """Return the standard deviation of the groups' savings in percent."""
    return {"value": statistics.stdev(100.0 * saving.saved for saving in savings_of_groups(runs))}


def centred(columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Take the mean off every column."""
    return np.asarray(columns - columns.mean(axis=0))


def covariance_of_savings(savings: Sequence[Saving]) -> NDArray[np.float64]:
    """Return the covariance of the groups' savings: by days, within days, and by shared errors."""
    days = sorted({day for saving in savings for day in saving.by_day})
    by_day = np.array([[saving.by_day.get(day, 0.0) for day in days] for saving in savings])
    within = np.diag([0.0 if saving.by_day else saving.variance for saving in savings])
    df = satterthwaite_df([(saving.variance, saving.df) for saving in savings])
    common = [[shared_covariance(one.shared, other.shared, LEVEL, df) for other in savings] for one in savings]
    return np.asarray(by_day @ by_day.T + within + np.array(common))


def heterogeneity_p(runs: Runs) -> Number:
    """Return the p of equal savings: F = S'MS / tr(MV) with Box's degrees of freedom tr(MV)^2 / tr(MVMV) (Box 1954).

    V is the covariance of the savings S, and M takes off their mean.
    """
    savings = savings_of_groups(runs)
    covariance = centred(centred(covariance_of_savings(savings)).T)
    trace = float(np.trace(covariance))
    box = trace**2 / float(np.sum(covariance * covariance))
    away = centred(np.array([[saving.saved] for saving in savings]))
    days = {day for saving in savings for day in saving.by_day}
    df = satterthwaite_df([(saving.variance, saving.df) for saving in savings])
    df_within = min(df, box * (len(days) - 1)) if days else df
    return {"value": float(stats.f.sf(float(np.sum(away * away)) / trace, box, df_within))}


def overall_equivalence(runs: Runs) -> Number:
    """Return the mean change in percent of each control, with its interval of level 1 - 2 alpha, and both tests."""
    found = over_groups(savings_of_groups(runs))
    change, error, df = -100.0 * found.saved, 100.0 * found.error, found.df
    half = quantile(LEVEL, df) * error
    tests = one_sided_tests(over_error(change - LOWEST_CHANGE, error), over_error(change - HIGHEST_CHANGE, error), df)
    return {"value": change, "ci_low": change - half, "ci_high": change + half, "df": df, **tests}
