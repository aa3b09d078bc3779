"""One effect for a whole campaign: the mean of its groups' savings, each counted once.

What a day does to several groups is added up before it is squared, and so are errors that the groups have in common.
The mean is never weighted by estimated variances. With S_g the saving of group g, rho_g = T_g / C_g:

    u_day = sum over the paired groups measured on that day of (t_gi - rho_g c_gi) / (G C_g sqrt(k_g (k_g - 1)))
    V = sum over days of u_day^2 + sum over the groups within days of se_g^2 / G^2

The degrees of freedom are Satterthwaite's over the groups, at most the days of paired groups less one. Source: derived
and simulated for this purpose; coverage and size stand in docs/statistics.md.

Whether groups differ is tested by the same errors: the squares of the S_g about their mean over what these errors alone
make of them, as F with Box's degrees of freedom (Box 1954; Brunner, Dette and Munk 1997). With the errors' covariance V
and M taking off the mean, F = S'MS / tr(MV), f = tr(MV)^2 / tr(MVMV) over the lesser of Satterthwaite's degrees of
freedom and f (days - 1): two groups on the same days are a paired t-test, and it is conservative for many on few days.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.reasons import Reason
from data_schema.vocabulary import Rule, Undefined
from stats.checks import as_level
from stats.compare.shared_error import CANCELLED, SharedError, joined_variance, shared_of_mean
from stats.days.decision import (
    CONTROL,
    TREATED,
    Bounded,
    Contrast,
    Estimate,
    bounds_tests,
    undefined_bounds,
    undefined_estimate,
)
from stats.scatter import Value
from stats.tails import f_upper, t_quantile, t_two_sided


@dataclass(frozen=True, slots=True)
class Scope:
    """What an effect over groups is of."""

    groups: tuple[str, ...]
    """Groups that enter."""
    left_out: tuple[str, ...]
    """Groups whose days claim nothing, or whose difference has no error: neither scatter nor one in common."""
    days: tuple[str, ...]
    """Days on which the groups were compared."""
    days_measured_only: bool
    """Whether a group is compared within days, so that the claim holds for the days measured."""
    n: int
    """Runs that enter."""


@dataclass(frozen=True, slots=True)
class Heterogeneity:
    """The test that the groups' savings are all the same: F, its two degrees of freedom and the upper tail."""

    f: float
    df: tuple[float, float]
    p: float


@dataclass(frozen=True, slots=True)
class OverallSavings:
    """The mean of the groups' savings in percent of each group's control."""

    estimate: Estimate
    scope: Scope
    spread_percent: Value
    """Standard deviation of the groups' savings."""
    heterogeneity: Heterogeneity | Undefined
    """The test that all groups saved the same."""


@dataclass(frozen=True, slots=True)
class OverallEquivalence:
    """Two one-sided tests that the mean change of the groups, in percent of each control, lies within bounds."""

    bounded: Bounded
    scope: Scope


@dataclass(frozen=True, slots=True)
class _Overall:
    saved: float
    variance: float
    shared: SharedError
    df: float

    def error(self, level: float) -> float:
        """Return the standard error of the mean as it counts beside a quantile."""
        return math.sqrt(self.variance + joined_variance(self.shared, self.shared, level, self.df))


def overall_savings(groups: Mapping[str, Contrast], level: float = 0.95) -> OverallSavings:
    """Return the mean of the savings of groups by name; those without a claim, or without an error, are left out.

    There is none where a group's savings have no bounds: its control is too uncertain for a ratio's standard error.
    """
    level = as_level("level", level)
    claimed = _claimed(groups)
    scope, found = _scope(groups, claimed), _overall(claimed) if claimed else _why_none(groups.values())
    if any(isinstance(one.savings(level).ci, Undefined) for one in claimed.values()):
        found = Undefined(Reason.GROUP_WITHOUT_BOUNDS)
    if isinstance(found, Undefined):
        return OverallSavings(undefined_estimate(found, level, found), scope, found, found)
    error, percent = found.error(level), 100.0 * found.saved
    half = 100.0 * t_quantile(level, found.df) * error
    estimate = Estimate(
        value=percent,
        se=100.0 * math.sqrt(found.variance),
        shared_se=100.0 * found.shared.se,
        ci=(percent - half, percent + half),
        level=level,
        t=found.saved / error,
        df=found.df,
        p=t_two_sided(found.saved / error, found.df),
    )
    savings = [100.0 * (1.0 - one.ratio) for one in claimed.values()]
    spread = statistics.stdev(savings) if len(savings) > 1 else Undefined(Reason.ONE_GROUP)
    return OverallSavings(estimate, scope, spread, _heterogeneity(claimed, level))


def overall_equivalence(
    groups: Mapping[str, Contrast], low: float, high: float, alpha: float = 0.05
) -> OverallEquivalence:
    """Test that the mean change of the groups, in percent of each control, lies within bounds."""
    claimed, alpha = _claimed(groups), as_level("alpha", alpha)
    scope, found = _scope(groups, claimed), _overall(claimed) if claimed else _why_none(groups.values())
    if isinstance(found, Undefined):
        return OverallEquivalence(undefined_bounds(found, (low, high), alpha, found), scope)
    level = 1.0 - 2.0 * alpha
    error, change = 100.0 * found.error(level), -100.0 * found.saved
    half = t_quantile(level, found.df) * error
    tests = ((change - low) / error, (change - high) / error)
    return OverallEquivalence(
        bounds_tests(change, (low, high), (change - half, change + half), alpha, tests, found.df), scope
    )


def _scope(groups: Mapping[str, Contrast], claimed: Mapping[str, Contrast]) -> Scope:
    return Scope(
        groups=tuple(claimed),
        left_out=tuple(name for name in groups if name not in claimed),
        days=tuple(sorted({day for one in claimed.values() for day in one.days})),
        days_measured_only=any(one.rule is Rule.WITHIN for one in claimed.values()),
        n=sum(sum(one.n) for one in claimed.values()),
    )


def _claimed(groups: Mapping[str, Contrast]) -> dict[str, Contrast]:
    """Return the groups that enter: not those whose difference is the same on every day and has no error in common.

    The saving in percent of such a group scatters with its control alone: that is not the error of the difference.
    """
    return {name: one for name, one in groups.items() if _has_saving(one) and _errs(one, one.ratio) and _errs(one, 1.0)}


def _has_saving(one: Contrast) -> bool:
    """Tell whether the days of a group allow a claim, and its control is above 0."""
    return one.rule is not Rule.NONE and isinstance(one.control_mean, float) and one.control_mean > 0.0


def _errs(one: Contrast, ratio: float) -> bool:
    """Tell whether T - ratio C has an error: by its scatter, or in common with others, such as that of rounding."""
    return one.variance(ratio) > 0.0 or one.shared(ratio).se > 0.0


def _why_none(groups: Iterable[Contrast]) -> Undefined:
    """Return why no group enters: that of a group whose days allow a claim, where there is one."""
    compared = [one for one in groups if one.rule is not Rule.NONE]
    if not compared:
        return Undefined(Reason.NO_GROUP_WITH_CLAIM)
    if not any(map(_has_saving, compared)):
        return Undefined(Reason.NOTHING_TO_SAVE)
    if all(one.rule is Rule.PAIRED for one in compared):
        return Undefined(Reason.SAME_ON_EVERY_DAY, a=TREATED, b=CONTROL)
    return Undefined(Reason.NO_GROUP_SCATTERS)


def _overall(groups: Mapping[str, Contrast]) -> _Overall | Undefined:
    count = len(groups)
    by_day, df = _by_day(groups), _df(groups)
    within = math.fsum(one.relative_variance / count**2 for one in groups.values() if one.rule is Rule.WITHIN)
    shared = shared_of_mean([one.relative_shared for one in groups.values()])
    variance = math.fsum((math.fsum(each) / count) ** 2 for each in by_day.values()) + within
    if variance == 0.0 and shared.se == 0.0:  # what days do to groups cancels
        return Undefined(Reason.GROUPS_WITHOUT_SCATTER)
    return _Overall(
        saved=math.fsum(1.0 - one.ratio for one in groups.values()) / count,
        variance=variance,
        shared=shared,
        df=min(df, len(by_day) - 1) if by_day else df,
    )


def _by_day(groups: Mapping[str, Contrast]) -> dict[str, list[float]]:
    """Return what each day of paired groups adds to the error of each group's saving, as a share: 0 where nothing."""
    found: dict[str, list[float]] = {}
    for place, one in enumerate(groups.values()):
        k = len(one.shared_days)
        for day, departs in one.relative_departures if one.rule is Rule.PAIRED else ():
            found.setdefault(day, [0.0] * len(groups))[place] = departs / math.sqrt(k * (k - 1))
    return found


def _df(groups: Mapping[str, Contrast]) -> float:
    parts = [(one.relative_variance, one.df) for one in groups.values()]
    if not any(square for square, _df in parts):  # all error is in common with others: no more than any group has
        return min(df for _square, df in parts)
    return math.fsum(square for square, _df in parts) ** 2 / math.fsum(square**2 / df for square, df in parts)


def _heterogeneity(groups: Mapping[str, Contrast], level: float) -> Heterogeneity | Undefined:
    """Test that the groups' savings are the same; `level` is that at which errors in common are joined."""
    if len(groups) < 2:
        return Undefined(Reason.ONE_GROUP)
    by_day, df = _by_day(groups), _df(groups)
    own = [math.sqrt(one.relative_variance) if one.rule is Rule.WITHIN else 0.0 for one in groups.values()]
    errors = np.column_stack([*by_day.values(), np.diag(own)])
    shared = [one.relative_shared for one in groups.values()]
    common = np.array([[joined_variance(one, other, level, df) for other in shared] for one in shared])
    covariance = _centred(_centred(errors @ errors.T + common).T)
    total = float(np.trace(covariance))
    if total <= CANCELLED**2 * float(np.sum(errors * errors)):
        return Undefined(Reason.GROUPS_WITHOUT_SCATTER)
    box = total**2 / float(np.sum(covariance * covariance))
    apart = _centred(np.array([[1.0 - one.ratio] for one in groups.values()]))
    f, dfs = float(np.sum(apart * apart)) / total, (box, min(df, box * (len(by_day) - 1)) if by_day else df)
    return Heterogeneity(f, dfs, f_upper(f, *dfs))


def _centred(columns: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(columns - columns.mean(axis=0))
