"""The test that decides a comparison, by the days that hold both sides (docs/statistics.md, "Which test leads")."""

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from labbook.scripts.templates.runs import (
    LEVEL,
    Number,
    Pair,
    Run,
    Runs,
    Shared,
    of_conditions,
    of_mean,
    one_sided_tests,
    over_error,
    quantile,
    satterthwaite_df,
    shared_covariance,
    shared_se,
    two_sided_p,
    values_of,
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


"""Two one-sided tests that a difference lies within bounds (TOST, Schuirmann 1987), by the contrast that decides."""

LOW = -5.0
"""The lower bound, in percent of the control's mean or in the unit of the values; infinite where there is none."""
HIGH = 5.0
"""The upper bound."""
IN_PERCENT = True
"""Whether the bounds are in percent of the control's mean."""


def t_at(means: Means, bound: float) -> float:
    """Return t of T - (1 + bound / 100) C, or of T - C - bound where the bound is no percentage."""
    if math.isinf(bound):
        return -bound
    ratio, shift = (1.0 + bound / 100.0, 0.0) if IN_PERCENT else (1.0, bound)
    return over_error(means.treated - ratio * means.control - shift, error_of(means, ratio))


def ends_of_change(means: Means) -> tuple[float, float] | None:
    """Return the interval of level 1 - 2 alpha of the change: Fieller's in percent, else Student's."""
    if IN_PERCENT:
        saved = fieller(means)
        return None if saved is None else (-saved[1], -saved[0])
    half = quantile(LEVEL, means.df) * error_of(means, 1.0)
    return means.treated - means.control - half, means.treated - means.control + half


def equivalence(runs: Runs) -> Number:
    """Return the change from the control with its interval of level 1 - 2 alpha, and the tests against both bounds."""
    means = compare(runs, PAIR)
    change, ends = means.treated - means.control, ends_of_change(means)
    return {
        "value": 100.0 * change / means.control if IN_PERCENT else change,
        **({} if ends is None else {"ci_low": ends[0], "ci_high": ends[1]}),
        "df": means.df,
        **one_sided_tests(t_at(means, LOW), t_at(means, HIGH), means.df),
    }


"""The thesis's own tests (5.2.1): F of two variances, and Student's or Welch's t as F decides, over runs or jumps."""

ALPHA = 0.05
"""Of the F-test that chooses the t-test; the interval has level 1 - alpha."""


def thesis_route(runs: Runs) -> Number:
    """Return the treatment less the control with its interval, t, p: Student's where F rejects nothing, else Welch's.

    F is the variance of the treatment over that of the control, and its p twice the smaller tail, as R's `var.test`.
    """
    treated, control = (values_of(of_conditions(runs, conditions)) for conditions in (PAIR[1], PAIR[0]))
    n, m, value = len(treated), len(control), float(np.mean(treated) - np.mean(control))
    if min(n, m) < 2:  # one value has no scatter
        return {"value": value}
    of_treated, of_control = float(np.var(treated, ddof=1)), float(np.var(control, ddof=1))
    f = over_error(of_treated, of_control)
    f_p = min(1.0, 2.0 * float(min(stats.f.sf(f, n - 1, m - 1), stats.f.cdf(f, n - 1, m - 1))))
    se, df = math.sqrt(of_treated / n + of_control / m), n + m - 2.0
    if f_p >= ALPHA:
        se = math.sqrt(((n - 1) * of_treated + (m - 1) * of_control) / df * (1.0 / n + 1.0 / m))
    else:
        df = satterthwaite_df([(of_treated / n, n - 1.0), (of_control / m, m - 1.0)])
    t, half = over_error(value, se), quantile(1.0 - ALPHA, df) * se
    ends = {"ci_low": value - half, "ci_high": value + half}
    return {"value": value, **ends, "df": df, "t": t, "p": two_sided_p(t, df), "f": f, "f_p": f_p}


"""Weighted sums of effects on shared days: differences of levels, interactions, trends.

Source: docs/statistics.md, "What the saving depends on"; savings by the delta method.
"""

Effect = tuple[float, Pair]
"""A weight, and the conditions of a reference and of what is compared with it."""
Variance = tuple[float, float]
"""With its degrees of freedom."""
EFFECTS: Sequence[Effect] = ()
"""The contrast L is the sum of weight * effect."""
PERCENT = True
"""Whether an effect is the saving 100 (1 - T / C), in percent of the reference, or the difference T - C."""


class Term(NamedTuple):
    """An effect: its value, what L gains for each unit of C and of T, the means, and its shared days."""

    pair: Pair
    gain: float
    of_control: float
    of_treated: float
    means: Means
    days: dict[str, tuple[list[Run], list[Run]]]
    shared: Shared


def days_are_units(runs: Runs, effects: Sequence[Effect]) -> dict[Pair, bool]:
    """Return of each effect whether its days are its units: four or more, and no condition is in one of fewer."""
    by_days = {pair: len(runs_by_day(runs, pair)) >= DAYS_AS_UNITS for _weight, pair in effects}
    paired, within = (
        {conditions for pair, many in by_days.items() if many is side for conditions in pair} for side in (True, False)
    )
    return dict.fromkeys(by_days, False) if paired & within else by_days


def term_of(runs: Runs, weight: float, pair: Pair, *, paired: bool, percent: bool) -> Term:
    """Return an effect; savings enter by their derivatives -100 / C of T and 100 T / C^2 of C."""
    means = paired_means(runs, pair) if paired else means_within_days(runs, pair)
    control, treated = means.control, means.treated
    value, of_control, of_treated = treated - control, -weight, weight
    if percent:
        value, of_control = 100.0 * (control - treated) / control, 100.0 * weight * treated / control**2
        of_treated = -100.0 * weight / control
    shared = weighted_sum([means.control_shared, means.treated_shared], [of_control, of_treated])
    return Term(pair, weight * value, of_control, of_treated, means, runs_by_day(runs, pair), shared)


def variance_by_days(terms: Sequence[Term]) -> Variance:
    """Return the variance of L by days: what a day gives to all effects is added up before it is squared."""
    by_day: dict[str, float] = {}
    squares, dfs = [], []
    for term in terms:
        k = len(term.days)
        gains = {
            day: term.of_control * (mean_of(control) - term.means.control)
            + term.of_treated * (mean_of(treated) - term.means.treated)
            for day, (control, treated) in term.days.items()
        }
        for day, gain in gains.items():
            by_day[day] = by_day.get(day, 0.0) + gain / math.sqrt(k * (k - 1))
        squares.append(math.fsum(gain**2 for gain in gains.values()) / (k * (k - 1)))
        dfs.append(k - 1)
    if not terms:
        return 0.0, math.inf
    df = math.fsum(squares) ** 2 / math.fsum(square**2 / df for square, df in zip(squares, dfs, strict=True))
    return math.fsum(gain**2 for gain in by_day.values()), min(df, len(by_day) - 1.0)


def variance_within_days(terms: Sequence[Term]) -> Variance:
    """Return the variance of L by runs within days: a condition enters once, with all that it has in the effects."""
    gains: dict[tuple[Sequence[str], str], float] = {}
    found: dict[tuple[Sequence[str], str], list[Run]] = {}
    for term in terms:
        weights = day_weights(list(term.days.values()))
        for weight, (day, both) in zip(weights, term.days.items(), strict=True):
            for conditions, gain, of_day in zip(term.pair, (term.of_control, term.of_treated), both, strict=True):
                gains[conditions, day] = gains.get((conditions, day), 0.0) + weight * gain
                found[conditions, day] = of_day
    variances, dfs = [], []
    for conditions in dict.fromkeys(conditions for conditions, _day in gains):
        blocks = {day: of_day for (of, day), of_day in found.items() if of == conditions}
        df = sum(len(of_day) - 1 for of_day in blocks.values())
        of_a_run = math.fsum(map(squares_of, blocks.values())) / df
        variances.append(
            of_a_run * math.fsum(gains[conditions, day] ** 2 / len(of_day) for day, of_day in blocks.items())
        )
        dfs.append(df)
    return math.fsum(variances), float(min(dfs, default=math.inf))


def contrast_of(runs: Runs, effects: Sequence[Effect], *, percent: bool) -> Number:
    """Return L with its interval, t and p; the degrees of freedom are Satterthwaite's over both kinds of effects.

    Nothing is claimed where the days of an effect allow no test, or where a saving has no bounds.
    """
    rules = days_are_units(runs, effects)
    terms = [term_of(runs, weight, pair, paired=rules[pair], percent=percent) for weight, pair in effects]
    value = math.fsum(term.gain for term in terms)
    if any(not term.means.df or (percent and fieller(term.means) is None) for term in terms):
        return {"value": value}
    parts = [
        variance_by_days([term for term in terms if rules[term.pair]]),
        variance_within_days([term for term in terms if not rules[term.pair]]),
    ]
    variance = math.fsum(part for part, _df in parts)
    df = satterthwaite_df([part for part in parts if part[0] > 0.0])
    shared = weighted_sum([term.shared for term in terms], [1.0] * len(terms))
    error = math.sqrt(variance + shared_covariance(shared, shared, LEVEL, df))
    half = quantile(LEVEL, df) * error
    return {
        "value": value,
        "se": math.sqrt(variance),
        "shared_se": shared_se(shared),
        "ci_low": value - half,
        "ci_high": value + half,
        "df": df,
        "t": value / error,
        "p": two_sided_p(value / error, df),
    }


def contrast(runs: Runs) -> Number:
    """Return the contrast."""
    return contrast_of(runs, EFFECTS, percent=PERCENT)


"""What was measured of a hypothesis: the change of a mean in percent of another, or of a saving in points."""


def as_change(saving: Mapping[str, float]) -> Number:
    """Return a change, which is less a saving, with its interval where there is one."""
    if "ci_low" not in saving:
        return {"value": -saving["value"]}
    return {
        **saving,
        "value": -saving["value"],
        "ci_low": -saving["ci_high"],
        "ci_high": -saving["ci_low"],
    }


def change(runs: Runs) -> Number:
    """Return the change of the second mean in percent of the first."""
    return as_change(saving_of(compare(runs, PAIR)))


def change_of_saving(runs: Runs) -> Number:
    """Return the last saving less the first in percentage points."""
    found = contrast_of(runs, EFFECTS, percent=True)
    return as_change({name: found[name] for name in ("value", "se", "shared_se", "ci_low", "ci_high", "df")})


"""Holm's adjusted p (Holm 1979) of one test among those of its family."""

TESTS: Mapping[str, Pair] = {}
"""By test, the conditions of its control and of its treatment."""
CONTRASTS: Mapping[str, tuple[bool, Sequence[Effect]]] = {}
"""By test, whether its effects are savings in percent, and its effects."""
ASKED = ""
"""The test whose p is adjusted."""
WITHOUT_P = 0
"""Tests of the family that have no p; they count all the same."""


def holm(p_values: Mapping[str, float], tests: int) -> Number:
    """Multiply the smallest of m p-values by m, the next by m - 1 and so on; none is less than one before it."""
    adjusted, largest = {}, 0.0
    for place, name in enumerate(sorted(p_values, key=lambda name: p_values[name])):
        largest = adjusted[name] = max(largest, min(1.0, (tests - place) * p_values[name]))
    return adjusted


def adjusted_p(runs: Runs) -> Number:
    """Return Holm's p of the test among all comparisons with a control."""
    p_values = {name: p_of(compare(runs, pair)) for name, pair in TESTS.items()}
    return {"value": holm(p_values, len(p_values) + WITHOUT_P)[ASKED]}


def adjusted_p_of_contrast(runs: Runs) -> Number:
    """Return Holm's p of the contrast among all contrasts of means."""
    p_values = {
        name: contrast_of(runs, effects, percent=percent)["p"] for name, (percent, effects) in CONTRASTS.items()
    }
    return {"value": holm(p_values, len(p_values) + WITHOUT_P)[ASKED]}


"""One effect for a campaign: the mean of its groups' savings, each counted once (docs/statistics.md)."""

CLAIMED: Mapping[str, Pair] = {}
"""By group, the conditions of its control and of its treatment; groups without a test of their own are left out."""
ONE_SIDED_OVERALL = False
"""Whether p is against a saving alone."""
LOWEST_CHANGE = -5.0
"""The lower bound of the mean change, in percent of each control; infinite where there is none."""
HIGHEST_CHANGE = 5.0
"""The upper bound."""
NO_SCATTER = 1e-24
"""Variance, as a share of the control squared, that the last digits of equal values make."""


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


def df_of_scatter(savings: Sequence[Saving]) -> float:
    """Return Satterthwaite's degrees of freedom; the fewest of any group where nothing scatters but by rounding."""
    if all(saving.variance <= NO_SCATTER for saving in savings):
        return float(min(saving.df for saving in savings))
    return satterthwaite_df([(saving.variance, saving.df) for saving in savings])


def over_groups(savings: Sequence[Saving]) -> Overall:
    """Return the mean saving: what a day does to all groups is added up before it is squared."""
    n, days = len(savings), sorted({day for saving in savings for day in saving.by_day})
    shares = [math.fsum(saving.by_day.get(day, 0.0) for saving in savings) / n for day in days]
    within = math.fsum(saving.variance for saving in savings if not saving.by_day) / n**2
    variance = math.fsum(share**2 for share in shares) + within
    df = df_of_scatter(savings)
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
    df = df_of_scatter(savings)
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
    df = df_of_scatter(savings)
    df_within = min(df, box * (len(days) - 1)) if days else df
    return {"value": float(stats.f.sf(float(np.sum(away * away)) / trace, box, df_within))}


def overall_equivalence(runs: Runs) -> Number:
    """Return the mean change in percent of each control, with its interval of level 1 - 2 alpha, and both tests."""
    found = over_groups(savings_of_groups(runs))
    change, error, df = -100.0 * found.saved, 100.0 * found.error, found.df
    half = quantile(LEVEL, df) * error
    tests = one_sided_tests(over_error(change - LOWEST_CHANGE, error), over_error(change - HIGHEST_CHANGE, error), df)
    return {"value": change, "ci_low": change - half, "ci_high": change + half, "df": df, **tests}
