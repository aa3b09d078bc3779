"""One decision test between a control and a treatment whose runs belong to days, and savings and equivalence by it.

Only days that hold runs of both ("shared days") enter. Which rule applies is fixed by which runs there are, never by
what they measured:

- four shared days or more: *paired* on day means, the day being the unit; the claim holds for days like these;
- one to three, with at least two runs of each condition on one of them: a contrast *within* days, the run being the
  unit; the claim holds for the days measured;
- otherwise no claim, no interval and no p.

Where levels of another factor are pooled (strata), both conditions are compared within a day and a level, and a day is
one day however many levels it holds: its means are those of its levels, weighted as days are within days, n m / (n + m)
of n control and m treated runs.

With C and T the means of the control and of the treatment over the shared days, T - r C has the variance
V(r) = V_TT - 2 r V_CT + r^2 V_CC plus the square of what it takes from errors in common. The test of no difference is
(T - C) / sqrt V(1). The interval of the savings 100 (1 - T / C) is Fieller's by the same variance and degrees of
freedom, so that it leaves out 0 just where the test rejects. Equivalence within delta tests T - (1 + delta) C.

Source: paired t with unequal variances is conservative (Bakirov and Szekely 2005; Ibragimov and Mueller 2010); within
days the smaller degrees of freedom bound Welch's (Mickey and Brown 1966). Coverage, size and power by layout stand in
docs/statistics.md.

The difference of means within days is weighted as least squares with day effects weights it, n m / (n + m) for each
day of n control and m treated runs. Runs carry errors in common with others.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.grouping import grouped
from data_schema.reasons import Reason
from data_schema.vocabulary import Rule, Undefined
from stats.checks import Labels, as_labels, as_level, as_number, as_values
from stats.compare.shared_error import SharedError, joined_variance, shared_of_mean, weighted_sum
from stats.results import plural
from stats.scatter import Interval, Scale, Value, group_of, scale_of, times_power
from stats.tails import t_quantile, t_two_sided, t_upper


@dataclass(frozen=True, slots=True)
class Estimate:
    """An estimate with its interval and the test that it is 0, in the unit of the values or in percent."""

    value: Value
    se: Value
    """Without errors in common."""
    shared_se: Value
    """What it takes from errors in common with others."""
    ci: Interval | Undefined
    level: float
    t: Value
    df: Value
    p: Value
    """Two-sided."""


@dataclass(frozen=True, slots=True)
class Bounded:
    """Two one-sided tests that an estimate lies above `low` and below `high`, and its interval of level 1 - 2 alpha."""

    value: Value
    low: float
    high: float
    """Infinite where there is no such bound."""
    ci: Interval | Undefined
    alpha: float
    t_low: Value
    p_low: Value
    t_high: Value
    p_high: Value
    df: Value
    p: Value
    """The larger of both."""
    equivalent: bool | Undefined
    """Whether p is at most alpha; the interval lies within the bounds just then."""


_NO_LOW, _NO_HIGH = Undefined(Reason.NO_LOWER_BOUND), Undefined(Reason.NO_UPPER_BOUND)


def bounds_tests(
    value: Value,
    bounds: Interval,
    ci: Interval | Undefined,
    alpha: float,
    t: tuple[float, float],
    df: float,
) -> Bounded:
    """Return two one-sided tests from their t at the lower and the upper bound, or the one of a single bound."""
    (t_low, p_low), (t_high, p_high) = (
        (at, t_upper(sign * at, df)) if math.isfinite(bound) else (none, none)
        for at, sign, bound, none in zip(t, (1.0, -1.0), bounds, (_NO_LOW, _NO_HIGH), strict=True)
    )
    p = max(each for each in (p_low, p_high) if isinstance(each, float))
    equivalent = p <= alpha and not isinstance(ci, Undefined)
    return Bounded(value, *bounds, ci, alpha, t_low, p_low, t_high, p_high, df, p, equivalent)


def undefined_estimate(why: Undefined, level: float, value: Value) -> Estimate:
    """Return an estimate without interval and test."""
    return Estimate(value, why, why, why, level, why, why, why)


def undefined_bounds(why: Undefined, bounds: Interval, alpha: float, value: Value) -> Bounded:
    """Return what there is where nothing is tested against bounds."""
    return Bounded(value, *bounds, why, alpha, why, why, why, why, why, why, why)


LEAST_DAYS = 4
"""Shared days from which the day is the unit."""
CONTROL, TREATED = "the control", "the treatment"
"""What reasons call both sides."""
_ROUNDING = 8.0 * sys.float_info.epsilon


@dataclass(frozen=True, slots=True)
class Contrast:
    """Means over the shared days with the variances of their errors, in the scale.

    Under `Rule.NONE` there are no variances; the means are weighted as within days, of all runs where no day is shared.
    """

    rule: Rule
    why: Undefined | None
    """Why nothing is claimed."""
    scale: Scale
    shared_days: tuple[SharedDay, ...]
    control: Value
    treated: Value
    control_variance: float
    covariance: float
    treated_variance: float
    df: int
    control_shared: SharedError
    treated_shared: SharedError
    counts: Counts
    runs: RunsByDay

    def without(self, day: str) -> Contrast:
        """Return the contrast of the runs of the other days, by the rule that fits these."""
        return contrast_of_runs(self.runs.without(day))

    @property
    def days(self) -> tuple[str, ...]:
        """The shared days."""
        return tuple(dict.fromkeys(each.day for each in self.shared_days))

    @property
    def control_mean(self) -> Value:
        """C in the unit of the values."""
        return self.control if isinstance(self.control, Undefined) else self.scale.place(self.control)

    @property
    def treated_mean(self) -> Value:
        """T in the unit of the values."""
        return self.treated if isinstance(self.treated, Undefined) else self.scale.place(self.treated)

    @property
    def run_sd(self) -> Value:
        """The standard deviation of runs within shared days, of both conditions together, in the unit of the values."""
        sides = [side for day in self.shared_days for side in (day.control, day.treated)]
        df = sum(side.n - 1 for side in sides)
        if not df:
            return Undefined(Reason.ONE_VALUE_A_DAY)
        return self.scale.length(math.sqrt(math.fsum(side.squares for side in sides) / df), "the standard deviation")

    def difference(self, level: float = 0.95) -> Estimate:
        """Return treatment less control and the test that it is 0."""
        value = self._difference()
        if isinstance(value, Undefined):
            return undefined_estimate(value, level, value)
        if self.why is not None:
            return undefined_estimate(self.why, level, self._sized(value))
        test = self._test(1.0, level)
        half = t_quantile(level, self.df) * test.error
        ci = self.scale.interval(value - half, value + half) if test.error > 0.0 else self._no_scatter
        se, shared_se = (self.scale.length(each, "the standard error") for each in (test.se, test.shared_se))
        return Estimate(self._sized(value), se, shared_se, ci, level, *self._tested(value, test))

    def savings(self, level: float = 0.95) -> Estimate:
        """Return 100 (1 - T / C) with Fieller's interval; its test is that of no difference, positive for a saving."""
        value = self._percent()
        if isinstance(value, Undefined):
            return undefined_estimate(value if self.why is None else self.why, level, value)
        if self.why is not None:
            return undefined_estimate(self.why, level, -value)
        control, test = self._level, self._test(1.0, level)
        at_ratio = self._test(self.ratio, level)
        ci = self._fieller(level) if test.error > 0.0 else self._no_scatter
        return Estimate(
            -value,
            100.0 * at_ratio.se / control,
            100.0 * at_ratio.shared_se / control,
            ci,
            level,
            *self._tested(self._control - self._treated, test),
        )

    def equivalence(
        self, low: float | None, high: float | None, alpha: float = 0.05, *, percent: bool = True
    ) -> Bounded:
        """Test that treatment less control lies within bounds, in percent of the control's mean or in its unit.

        `low` alone is non-inferiority, `high` alone its mirror image. Raises `InputRefused` for no bound at all, bounds
        in the wrong order or at most -100 percent, and alpha from 0.5.
        """
        if low is None and high is None:
            raise InputRefused("Neither bound is given: give low, high or both.")
        lowest = -100.0 if percent else -math.inf
        low = -math.inf if low is None else as_number("low", low, above=lowest)
        high = math.inf if high is None else as_number("high", high, above=lowest)
        if as_level("alpha", alpha) >= 0.5:
            raise InputRefused(f"alpha is {alpha!r}: give a number below 0.5, for example 0.05.")
        if low >= high:
            raise InputRefused(f"the bounds are {low!r} to {high!r}: give the lower one first.")
        level = 1.0 - 2.0 * alpha
        value = self._percent() if percent else self._sized(self._difference())
        if self.why is not None:
            return undefined_bounds(self.why, (low, high), alpha, value)
        if isinstance(value, Undefined):
            why = Undefined(Reason.CONTROL_MEAN_NOT_POSITIVE) if percent else value
            return undefined_bounds(why, (low, high), alpha, value)
        ratios = [1.0 + bound / 100.0 if percent and math.isfinite(bound) else 1.0 for bound in (low, high)]
        shifts = [0.0, 0.0] if percent else [times_power(bound, -self.scale.exponent) for bound in (low, high)]
        errors = [self._test(ratio, level).error for ratio in ratios]
        if min(errors) == 0.0:
            return undefined_bounds(Undefined(Reason.NO_SCATTER_AT_BOUND), (low, high), alpha, value)
        below, above = (
            ((self._treated - self._control) + (1.0 - ratio) * self._level - shift) / error
            for ratio, shift, error in zip(ratios, shifts, errors, strict=True)
        )
        ci = self._fieller(level) if percent else self.difference(level).ci
        if percent and not isinstance(ci, Undefined):
            ci = -ci[1], -ci[0]  # of a change, not of a saving
        return bounds_tests(value, (low, high), ci, alpha, (below, above), float(self.df))

    def variance(self, ratio: float) -> float:
        """Return the variance of T - ratio C without errors in common, in the scale, squared."""
        if self.rule is not Rule.PAIRED:
            return self.treated_variance - 2.0 * ratio * self.covariance + ratio * ratio * self.control_variance
        # what days do to both sides is taken out first, or its digits would be lost
        left = [departs for _day, departs in self.departures(ratio)]
        return math.fsum(each * each for each in left) / (len(left) - 1) / len(left)

    def departures(self, ratio: float) -> list[tuple[str, float]]:
        """Return by how much T - ratio C of each shared day departs from its mean; 0 where all are rounding."""
        pairs = [(day.day, day.control.mean, day.treated.mean) for day in self.shared_days]
        left = [(day, (treated - self._treated) - ratio * (control - self._control)) for day, control, treated in pairs]
        largest = max(abs(self.scale.offset + mean) for _day, *means in pairs for mean in means)
        if max(abs(departs) for _day, departs in left) <= _ROUNDING * largest * (1.0 + abs(ratio)):
            return [(day, 0.0) for day, _departs in left]
        return left

    def shared(self, ratio: float) -> SharedError:
        """Return what T - ratio C takes from errors in common, in the scale."""
        return self.treated_shared.minus(self.control_shared.times(ratio))

    @property
    def relative_variance(self) -> float:
        """The variance of the saving as a share, without errors in common."""
        return self.variance(self.ratio) / self._level**2

    @property
    def relative_shared(self) -> SharedError:
        """What the saving, as a share, takes from errors in common, with the sign of T."""
        return self.shared(self.ratio).times(1.0 / self._level)

    @property
    def relative_departures(self) -> list[tuple[str, float]]:
        """By day what a paired saving, as a share, departs from its mean by, with the sign of T."""
        return [(day, departs / self._level) for day, departs in self.departures(self.ratio)]

    @property
    def ratio(self) -> float:
        """T / C, where something is claimed and C is positive."""
        return 1.0 + (self._treated - self._control) / self._level

    @property
    def _control(self) -> float:
        assert isinstance(self.control, float)  # noqa: S101 - where something is claimed there are runs
        return self.control

    @property
    def _treated(self) -> float:
        assert isinstance(self.treated, float)  # noqa: S101
        return self.treated

    @property
    def _level(self) -> float:
        """C, counted from 0."""
        return self.scale.offset + self._control

    def _difference(self) -> Value:
        for mean in (self.control, self.treated):
            if isinstance(mean, Undefined):
                return mean
        return self._treated - self._control

    def _percent(self) -> Value:
        """Return what T is more than C, in percent of C."""
        difference = self._difference()
        if isinstance(difference, Undefined):
            return difference
        return 100.0 * difference / self._level if self._level > 0.0 else Undefined(Reason.NOTHING_TO_SAVE)

    def _sized(self, scaled: Value) -> Value:
        return scaled if isinstance(scaled, Undefined) else self.scale.length(scaled)

    @property
    def n(self) -> tuple[int, int]:
        """Runs of the control and of the treatment that the means are of: all of them where no day is shared."""
        counts = self.counts
        if not self.shared_days:
            return counts.control + counts.other_control, counts.treated + counts.other_treated
        return counts.control, counts.treated

    @property
    def _no_scatter(self) -> Undefined:
        if self.rule is Rule.PAIRED:
            return Undefined(Reason.SAME_ON_EVERY_DAY, a=TREATED, b=CONTROL)
        return Undefined(Reason.GROUPS_WITHOUT_SCATTER)

    def _tested(self, value: float, test: _Error) -> tuple[Value, float, Value]:
        """Return t, its degrees of freedom and the two-sided p."""
        if test.error == 0.0:
            return self._no_scatter, float(self.df), self._no_scatter
        return value / test.error, float(self.df), t_two_sided(value / test.error, self.df)

    def _test(self, ratio: float, level: float) -> _Error:
        shared = self.shared(ratio)
        variance = max(0.0, self.variance(ratio))
        more = joined_variance(shared, shared, level, self.df)
        return _Error(math.sqrt(variance), shared.se, math.sqrt(variance + more))

    def _fieller(self, level: float) -> Interval | Undefined:
        squared = t_quantile(level, self.df) ** 2
        control, difference = self._level, self._treated - self._control
        of_control, of_treated = self.control_shared, self.treated_shared
        v_cc, v_ct, v_tt = (
            own + joined_variance(one, other, level, self.df)
            for own, one, other in (
                (self.control_variance, of_control, of_control),
                (self.covariance, of_control, of_treated),
                (self.treated_variance, of_treated, of_treated),
            )
        )
        a = control * control - squared * v_cc
        if a <= 0.0:
            return Undefined(Reason.CONTROL_NEAR_ZERO)
        # b^2 - a g and a - b, written so that nothing cancels where the errors are small
        error = self._test(self.ratio, level).error
        root = math.sqrt(max(0.0, squared * (control * error) ** 2 - squared * squared * (v_cc * v_tt - v_ct * v_ct)))
        middle = -control * difference - squared * (v_cc - v_ct)
        return 100.0 * (middle - root) / a, 100.0 * (middle + root) / a


@dataclass(frozen=True, slots=True)
class _Error:
    """The standard error of an estimate: of its own, in common with others, and of both together."""

    se: float
    shared_se: float
    error: float


def rule_of_days(days_treated: Iterable[str], days_control: Iterable[str]) -> Rule:
    """Return the rule by which runs of these days are compared, each run by its day, whatever they measured."""
    treated, control = Counter(days_treated), Counter(days_control)
    shared = treated.keys() & control.keys()
    return _rule(len(shared), *(sum(side[day] for day in shared) - len(shared) for side in (control, treated)))


def _rule(days: int, df_control: int, df_treated: int) -> Rule:
    """Return the rule by the number of shared days, and by how many runs of each side they have beyond one a block."""
    if days >= LEAST_DAYS:
        return Rule.PAIRED
    return Rule.WITHIN if days and min(df_control, df_treated) >= 1 else Rule.NONE


def contrast_by_day(
    treated: ArrayLike,
    control: ArrayLike,
    *,
    days_treated: Labels | None = None,
    days_control: Labels | None = None,
    shared_treated: Sequence[SharedError] | None = None,
    shared_control: Sequence[SharedError] | None = None,
    strata_treated: Labels | None = None,
    strata_control: Labels | None = None,
) -> Contrast:
    """Return the contrast of treated runs, shape (n_t,), with control runs, shape (n_c,), by the rule that fits them.

    `days_treated` and `days_control` label the day of each value; without them all runs are of one day.
    `strata_treated` and `strata_control` label the levels that are pooled, within which both are compared. The shared
    errors are each value's own. Raises `InputRefused` for values that are missing or infinite, for labels or errors of
    another length, and for days or strata of one condition only.
    """
    for what, one, other in (("days", days_treated, days_control), ("strata", strata_treated, strata_control)):
        if (one is None) != (other is None):
            raise InputRefused(f"{what} are given for one condition only: give them for both or for none.")
    return contrast_of_runs(
        RunsByDay(
            blocks_of_runs("control", control, days_control, strata_control, shared_control),
            blocks_of_runs("treated", treated, days_treated, strata_treated, shared_treated),
        )
    )


def contrast_of_runs(runs: RunsByDay, *, scale: Scale | None = None, paired: bool = True) -> Contrast:
    """Return the contrast of runs by the rule that fits them; without `paired` within days, however many there are.

    Contrasts that are added up have one `scale`.
    """
    scale = scale_of_runs((runs.control, runs.treated)) if scale is None else scale
    days, counts = runs.shared_days(scale), runs.counts()
    df_control, df_treated = (total - len(days) for total in (counts.control, counts.treated))
    by_day = grouped(days, [day.day for day in days])
    rule, why = _rule(len(by_day) if paired else min(len(by_day), 1), df_control, df_treated), None
    if rule is Rule.NONE:
        why = Undefined(Reason.NO_DAY_WITH_TWO, n=len(by_day), of=CONTROL if df_control < 1 else TREATED)
    if not days:
        sides = ((runs.control, CONTROL), (runs.treated, TREATED))
        control, treated = (_mean_of_all(side, name, scale) for side, name in sides)
        why = next((mean for mean in (control, treated) if isinstance(mean, Undefined)), runs.why_no_day_is_shared())
        none = SharedError()
        return Contrast(rule, why, scale, days, control, treated, 0.0, 0.0, 0.0, 0, none, none, counts, runs)
    if rule is Rule.PAIRED:
        days = tuple(map(one_day, by_day.values()))
    k = len(days)
    weights = [1.0 / k] * k if rule is Rule.PAIRED else weights_of(days)
    together = one_day(days, weights)
    of_control, of_treated, df = together.control, together.treated, min(df_control, df_treated)
    means, v_cc, v_ct, v_tt = (of_control.mean, of_treated.mean), 0.0, 0.0, 0.0
    if rule is Rule.PAIRED:
        by_day_means = np.array([(day.control.mean, day.treated.mean) for day in days])
        means = math.fsum(by_day_means[:, 0]) / k, math.fsum(by_day_means[:, 1]) / k
        about = by_day_means - means
        (v_cc, v_ct), (_, v_tt) = (about.T @ about / (k - 1) / k).tolist()
        df = k - 1
    elif rule is Rule.WITHIN:
        v_cc, v_tt = (
            side.squares / of_side * math.fsum(weight * weight / n for weight, n in zip(weights, ns, strict=True))
            for side, of_side, ns in (
                (of_control, df_control, [day.control.n for day in days]),
                (of_treated, df_treated, [day.treated.n for day in days]),
            )
        )
    return Contrast(
        rule, why, scale, days, *means, v_cc, v_ct, v_tt, df, of_control.shared, of_treated.shared, counts, runs
    )


def _mean_of_all(side: RunsOfCondition, name: str, scale: Scale) -> Value:
    """Return the mean of all runs of a side in a scale."""
    if not side:
        return Undefined(Reason.GROUP_EMPTY, group=name)
    return means_of(Runs(tuple(value for each in side.values() for value in each.values), SharedError()), scale).mean


Block = tuple[str, str]
"""A day and a stratum."""


@dataclass(frozen=True, slots=True)
class Runs:
    """The values of the runs of one condition on one day, and the error that their mean has in common with others."""

    values: tuple[float, ...]
    shared: SharedError

    @property
    def n(self) -> int:
        """Their number."""
        return len(self.values)


RunsOfCondition = Mapping[Block, Runs]
"""The runs of a condition by day, as `blocks_of_runs` gathers them."""


@dataclass(frozen=True, slots=True)
class Means:
    """The mean of runs and the squares about it, in a `stats.scatter.Scale`."""

    n: int
    mean: float
    squares: float
    shared: SharedError


def scale_of_runs(conditions: Iterable[RunsOfCondition]) -> Scale:
    """Return the one scale of the runs of conditions that are compared."""
    return scale_of(*(np.array(each.values) for condition in conditions for each in condition.values()))


def means_of(runs: Runs, scale: Scale) -> Means:
    """Return the mean of runs and the squares about it, and their error in common, in a scale."""
    found, shared = group_of("", scale.scaled(np.array(runs.values))), runs.shared
    if shared.terms:
        shared = shared.times(times_power(1.0, -scale.exponent))
    return Means(found.n, found.mean, found.squares, shared)


@dataclass(frozen=True, slots=True)
class Counts:
    """Runs on shared days, and runs on other days, which enter nothing."""

    control: int
    treated: int
    other_control: int
    other_treated: int


@dataclass(frozen=True, slots=True)
class SharedDay:
    """A day with runs of both conditions; within days, of one stratum."""

    day: str
    control: Means
    treated: Means

    @property
    def weight(self) -> float:
        """The inverse variance of the contrast, in units of that of a run."""
        return self.control.n * self.treated.n / (self.control.n + self.treated.n)


@dataclass(frozen=True, slots=True)
class RunsByDay:
    """The runs of a control and of a treatment, by day and stratum."""

    control: RunsOfCondition
    treated: RunsOfCondition

    def without(self, day: str) -> RunsByDay:
        """Return the runs of the other days."""
        control, treated = (
            {block: runs for block, runs in side.items() if block[0] != day} for side in (self.control, self.treated)
        )
        return RunsByDay(control, treated)

    def shared_days(self, scale: Scale) -> tuple[SharedDay, ...]:
        """Return the days that hold runs of both, stratum by stratum."""
        both = sorted(self.control.keys() & self.treated.keys())
        return tuple(
            SharedDay(block[0], means_of(self.control[block], scale), means_of(self.treated[block], scale))
            for block in both
        )

    def why_no_day_is_shared(self) -> Undefined:
        """Return that no day holds both, or that none does within one stratum."""
        control, treated = ({day for day, _stratum in side} for side in (self.control, self.treated))
        code = Reason.NO_DAY_HOLDS_BOTH_ALIKE if control & treated else Reason.NO_DAY_HOLDS_BOTH
        return Undefined(code, a=CONTROL, b=TREATED)

    def counts(self) -> Counts:
        """Count the runs."""
        both = self.control.keys() & self.treated.keys()
        total = [sum(runs.n for runs in side.values()) for side in (self.control, self.treated)]
        shared = [sum(side[block].n for block in both) for side in (self.control, self.treated)]
        return Counts(shared[0], shared[1], total[0] - shared[0], total[1] - shared[1])


def one_day(strata: Sequence[SharedDay], weights: Sequence[float] | None = None) -> SharedDay:
    """Return the strata of a day as one day, or days by their weights."""
    if len(strata) == 1:
        return strata[0]
    weights = weights or weights_of(strata)

    def side(runs: Sequence[Means]) -> Means:
        mean = math.fsum(weight * one.mean for weight, one in zip(weights, runs, strict=True))
        squares, shared = math.fsum(one.squares for one in runs), weighted_sum([one.shared for one in runs], weights)
        return Means(sum(one.n for one in runs), mean, squares, shared)

    return SharedDay(strata[0].day, side([each.control for each in strata]), side([each.treated for each in strata]))


def weights_of(days: Sequence[SharedDay]) -> list[float]:
    """Return n m / (n + m) of days or strata, in shares of 1."""
    total = math.fsum(day.weight for day in days)
    return [day.weight / total for day in days]


def blocks_of_runs(
    name: str,
    values: ArrayLike,
    labels: Labels | None,
    strata: Labels | None,
    errors: Sequence[SharedError] | None,
) -> dict[Block, Runs]:
    """Gather values by the labels of their day and stratum; raises `InputRefused` as `contrast_by_day` says."""
    found = as_values(name, values)
    n = int(found.size)
    days, levels = (
        [""] * n if given is None else as_labels(f"{what}_{name}", given)
        for what, given in (("days", labels), ("strata", strata))
    )
    own = [SharedError()] * n if errors is None else list(errors)
    for what, given in (("label of day", days), ("label of stratum", levels), ("shared error", own)):
        if len(given) != n:
            raise InputRefused(
                f"{name} has {plural(n, 'value')} and {plural(len(given), what)}: give one for each value."
            )
    blocks = grouped(range(n), zip(days, levels, strict=True))
    return {
        block: Runs(tuple(found[places].tolist()), shared_of_mean([own[at] for at in places]))
        for block, places in blocks.items()
    }
