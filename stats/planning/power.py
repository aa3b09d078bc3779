"""How likely an experiment finds what is there: t-tests, ANOVA, and the tests by shared days.

Powers come from the noncentral t and F; that of Welch's t at unequal scatter takes the degrees of freedom of the true
standard deviations. Differences and standard deviations have the unit of the values. Values are independent: where days
are compared within, `sd` is the scatter within days; where conditions have days of their own, count days, not values.

By shared days (`stats.days.decision`), runs are normal with one standard deviation about their day's mean; what days
add cancels within a day. Paired on day means, the difference over k days has k - 1 degrees of freedom; where days hold
unequal numbers of runs the noncentral t is an approximation. Within days the critical value is that of the smaller
degrees of freedom of both sides, and the statistic is taken to have Satterthwaite's. Of bounds in percent of the
control's mean each has its own scatter, and both are taken to move together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import special

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import given_text, level_text, number_text
from data_schema.vocabulary import Remark, Undefined
from stats.checks import as_count, as_level, as_number, as_values
from stats.days.decision import LEAST_DAYS
from stats.results import Result
from stats.scatter import Value
from stats.tails import satterthwaite_df, t_upper_quantile


@dataclass(frozen=True, slots=True)
class Power(Result):
    """The chance that a planned test rejects, for the effect and the scatter assumed."""

    test: str
    """The test in words, with its assumptions."""
    group_ns: tuple[int, ...]
    """Number of values of each group, shape (k,)."""
    alpha: float
    """Level of the test."""
    power: Value
    """Chance of rejecting, 0 to 1."""
    never: Remark | None = None
    """Why no number of values brings the chance above alpha; None where enough of them find the effect."""

    def sentence(self) -> str:
        """Return the plan in words: sizes, test, level, chance."""
        sizes = " and ".join(filter(None, (", ".join(map(str, self.group_ns[:-1])), str(self.group_ns[-1]))))
        if isinstance(self.power, Undefined):
            return f"No power for {self.test} with n = {sizes}: {self.power.reason}."
        chance = number_text(100.0 * self.power, 3)
        if chance == "100" and self.power < 1.0:
            chance = "over 99.9"
        level = number_text(self.alpha)
        return f"With n = {sizes}, {self.test} at alpha = {level} has a chance of {chance} % to reject."


def power_t(difference: float, sd: float, n_a: int, n_b: int, alpha: float = 0.05, sides: int = 2) -> Power:
    """Return the power of Student's t for a true difference at one standard deviation; `sides` is 1 (upward) or 2.

    >>> round(power_t(4.0, 3.0, 6, 6).power, 3)
    0.55
    """
    difference, alpha = as_number("difference", difference), as_level("alpha", alpha)
    sd = as_number("sd", sd, above=0.0)
    sizes, sides = _sizes(n_a, n_b), _sides(sides)
    test = f"Student's t-test for {_difference_text(difference, sd)} at sd {number_text(sd)} ({_sided(sides)})"
    df, never = sum(sizes) - 2, _no_difference(difference, sides)
    if df < 1 or min(sizes) < 1:
        return Power(test, sizes, alpha, Undefined(Reason.TOO_FEW_FOR_POOLED_VARIANCE), never)
    ncp = difference / (sd * math.sqrt(1.0 / sizes[0] + 1.0 / sizes[1]))
    return Power(test, sizes, alpha, _beyond(ncp, float(df), float(df), alpha, sides), never)


def power_welch(
    difference: float, sd_a: float, sd_b: float, n_a: int, n_b: int, alpha: float = 0.05, sides: int = 2
) -> Power:
    """Return the power of Welch's t for a true difference at two standard deviations."""
    difference, alpha = as_number("difference", difference), as_level("alpha", alpha)
    sds = as_number("sd of a", sd_a, above=0.0), as_number("sd of b", sd_b, above=0.0)
    sizes, sides = _sizes(n_a, n_b), _sides(sides)
    scatter = " and ".join(map(number_text, sds))
    test = f"Welch's t-test for {_difference_text(difference, min(sds))} at sd {scatter} ({_sided(sides)})"
    never = _no_difference(difference, sides)
    if min(sizes) < 2:
        return Power(test, sizes, alpha, Undefined(Reason.TWO_EACH_FOR_VARIANCE), never)
    errors = [sd / math.sqrt(n) for sd, n in zip(sds, sizes, strict=True)]
    df = satterthwaite_df([((error / max(errors)) ** 2, n - 1.0) for error, n in zip(errors, sizes, strict=True)])
    return Power(test, sizes, alpha, _beyond(difference / math.hypot(*errors), df, df, alpha, sides), never)


def _beyond(ncp: float, critical_df: float, df: float, alpha: float, sides: int = 2) -> float:
    """Return the chance that a noncentral t is beyond the critical value of `critical_df`, on one or both sides."""
    critical = t_upper_quantile(alpha / sides, critical_df)
    upper = _noncentral_upper(critical, df, ncp)
    return min(1.0, upper + _noncentral_upper(critical, df, -ncp)) if sides == 2 else upper


def _noncentral_upper(t: float, df: float, ncp: float) -> float:
    """Return P(T > t) of the noncentral t."""
    below = float(special.nctdtr(df, ncp, t))
    return 0.0 if math.isnan(below) and ncp < t else max(0.0, 1.0 - below)  # scipy's NaN, where it is 1 to 16 digits


def power_anova(means: Sequence[float], sd: float, n: int, alpha: float = 0.05) -> Power:
    """Return the power of one-way ANOVA for true means of groups with `n` values each at one standard deviation."""
    alpha, sd = as_level("alpha", alpha), as_number("sd", sd, above=0.0)
    truth = as_values("means", list(means))
    if truth.size < 2:
        raise InputRefused(f"{truth.size} means were given: give the true means of at least 2 groups.")
    n, k = as_count("n", n), truth.size
    means_text = ", ".join(assumed_text(mean, sd) for mean in truth)
    test = f"one-way ANOVA for means {means_text} at sd {number_text(sd)}"
    sizes = (n,) * k
    never = Remark(Reason.TRUE_MEANS_EQUAL) if truth.min() == truth.max() else None
    if n < 2:
        return Power(test, sizes, alpha, Undefined(Reason.TWO_EACH), never)
    ncp = float(n * np.sum(((truth - truth.mean()) / sd) ** 2))
    df_within = k * (n - 1)
    critical = float(special.fdtri(k - 1, df_within, 1.0 - alpha))
    return Power(test, sizes, alpha, max(0.0, 1.0 - float(special.ncfdtr(k - 1, df_within, ncp, critical))), never)


def alpha_of_equivalence(alpha: float) -> float:
    """Return the level of two one-sided tests, which is below 0.5."""
    if (alpha := as_level("alpha", alpha)) >= 0.5:
        raise InputRefused(f"alpha is {alpha!r}: give a number below 0.5 for an equivalence test.")
    return alpha


def assumed_text(value: float, sd: float) -> str:
    """Write a mean or a difference that is assumed, with the digits that the scatter needs and no zeros at its end."""
    text = number_text(value, error=sd)
    return text.rstrip("0").rstrip(".") if "." in text else text


def _difference_text(difference: float, sd: float) -> str:
    return f"a difference of {assumed_text(difference, sd)}"


def _no_difference(difference: float, sides: int) -> Remark | None:
    if difference == 0.0:
        return Remark(Reason.NO_TRUE_DIFFERENCE)
    if sides == 1 and difference < 0.0:
        return Remark(Reason.DIFFERENCE_ON_OTHER_SIDE, difference=difference)
    return None


def _sizes(n_a: int, n_b: int) -> tuple[int, int]:
    return as_count("n_a", n_a), as_count("n_b", n_b)


def _sides(sides: int) -> int:
    if sides not in (1, 2):
        raise InputRefused(f"sides is {sides!r}: give 1 or 2.")
    return sides


def _sided(sides: int) -> str:
    return "two-sided" if sides == 2 else "one-sided"


@dataclass(frozen=True, slots=True)
class SampleSize(Result):
    """The smallest plan that reaches a power."""

    target: float
    """The chance of rejecting that was asked for, 0 to 1."""
    plan: Power | Undefined
    """The plan, with its power; undefined where no n reaches the target."""
    n: int | Undefined
    """The n that the plan was made with."""

    def sentence(self) -> str:
        """Return the plan in words, or why there is none."""
        if isinstance(self.plan, Undefined):
            return f"No n was found with a chance of {level_text(self.target)} to reject: {self.plan.reason}."
        return self.plan.sentence()


def sample_size(plan: Callable[[int], Power], power: float = 0.8, largest: int = 1_000_000) -> SampleSize:
    """Return the plan with the smallest n, up to `largest`, whose power is at least `power`.

    `plan` makes a plan of n values a group, as `lambda n: power_t(0.5, 1.0, n, n)`; its power must not fall with n.
    Raises `InputRefused` for a largest n below 2.

    >>> sample_size(lambda n: power_t(4.0, 3.0, n, n)).n
    10
    """
    target, largest = as_level("power", power), as_count("largest", largest, least=2)

    plan_of = cache(plan)  # each n is asked about several times

    def enough(n: int) -> bool:
        found = plan_of(n).power
        return not isinstance(found, Undefined) and found >= target

    n = 2
    while not enough(n):
        tried = plan_of(n)
        if tried.never is not None and target > tried.alpha:
            return _no_plan(target, Undefined(tried.never.code, **dict(tried.never.parameters)))
        if n >= largest:
            return _no_plan(target, Undefined(Reason.SEARCH_ENDED, largest=largest))
        n = min(2 * n, largest)
    below = 1 if n == 2 else n // 2
    while n - below > 1:
        middle = (n + below) // 2
        below, n = (below, middle) if enough(middle) else (middle, n)
    return SampleSize(target, plan_of(n), n)


def _no_plan(target: float, why: Undefined) -> SampleSize:
    return SampleSize(target, why, why)


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
    test = f"the test{found.by_days} for a difference of {number_text(difference)} at sd {number_text(sd)}"
    never = _no_difference(difference, 2)
    if found.critical_df < 1.0:
        return Power(test, found.sizes, alpha, Undefined(Reason.NO_GROUP_WITH_CLAIM), never)
    power = _beyond(difference / (sd * found.error(1.0)), found.critical_df, found.df, alpha)
    return Power(test, found.sizes, alpha, power, never)


def power_equivalence(
    sd: float,
    low: float,
    high: float,
    n_control: int,
    n_treated: int,
    alpha: float = 0.05,
    *,
    difference: float = 0.0,
    control_mean: float | None = None,
) -> Power:
    """Return the power of both one-sided tests (TOST) of values as of one day, as `power_equivalence_by_day` does."""
    days = [(as_count("n_control", n_control), as_count("n_treated", n_treated))]
    return power_equivalence_by_day(sd, low, high, days, alpha, difference=difference, control_mean=control_mean)


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
    high, alpha = as_number("high", high, above=low), alpha_of_equivalence(alpha)
    found = _layout(days)
    ratios, ends, of = (1.0, 1.0), (low, high), ""
    if control_mean is not None:
        mean = as_number("the control's mean", control_mean, above=0.0)
        ratios, ends = (1.0 + low / 100.0, 1.0 + high / 100.0), (low / 100.0 * mean, high / 100.0 * mean)
        of = f" % of the control's mean, itself estimated and {assumed_text(mean, sd)} in truth,"
    test = (
        f"the equivalence test (TOST){found.by_days} between {given_text(low)} and {given_text(high)}{of} "
        f"for a difference of {assumed_text(difference, sd)} at sd {number_text(sd)}"
    )
    never = None
    if not ends[0] < difference < ends[1]:
        bounds = " and ".join(f"{end:g}" for end in ends)
        never = Remark(Reason.NOT_BETWEEN_BOUNDS, difference=difference, bounds=bounds)
    if found.critical_df < 1.0:
        return Power(test, found.sizes, alpha, Undefined(Reason.NO_GROUP_WITH_CLAIM), never)
    at_low, at_high = ((end - difference) / (sd * found.error(ratio)) for end, ratio in zip(ends, ratios, strict=True))
    critical = t_upper_quantile(alpha, found.critical_df)
    return Power(test, found.sizes, alpha, _within_both(at_low, at_high, critical, found.df), never)


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(400)


def _within_both(low: float, high: float, critical: float, df: float) -> float:
    """Return P(low + critical U <= Z <= high - critical U) with U = sqrt(chi2_df / df): Owen's Q function."""
    first = math.sqrt(float(special.chdtri(df, 1.0 - _NOTHING)) / df)
    last = min(math.sqrt(float(special.chdtri(df, _NOTHING)) / df), (high - low) / 2.0 / critical)
    if last <= first:
        return 0.0
    u = first + (last - first) * (_NODES + 1.0) / 2.0
    log_density = math.log(2.0) + df / 2.0 * math.log(df / 2.0) - special.gammaln(df / 2.0)
    density = np.exp(log_density + (df - 1.0) * np.log(u) - df / 2.0 * u * u)
    inside = special.ndtr(high - critical * u) - special.ndtr(low + critical * u)
    return min(1.0, (last - first) / 2.0 * float(_WEIGHTS @ (density * inside)))


_NOTHING = 1e-13
"""Chance of what an integral leaves out."""


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

    @property
    def by_days(self) -> str:
        """Say how many days it is by; one day is none."""
        return f" by {self.k} shared days" if self.k != 1 else ""

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
