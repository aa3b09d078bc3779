"""One effect for a whole campaign: the mean of its groups' savings, each counted once.

What a day does to several groups is added up before it is squared, and so are errors that the groups have in common.
The mean is never weighted by estimated variances. With S_g the saving of group g, rho_g = T_g / C_g:

    u_day = sum over the paired groups measured on that day of (t_gi - rho_g c_gi) / (G C_g sqrt(k_g (k_g - 1)))
    V = sum over days of u_day^2 + sum over the groups within days of se_g^2 / G^2

The degrees of freedom are Satterthwaite's over the groups, at most the days of paired groups less one. Source: derived
and simulated for this purpose; coverage and size stand in docs/statistics.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import as_level
from stats.compare.shared_error import SharedError, shared_of_mean
from stats.days.decision import Contrast, Rule, joined_variance
from stats.days.decision_result import Bounded, bounded
from stats.exact.tails import t_quantile, t_two_sided


@dataclass(frozen=True, slots=True)
class OverallSavings:
    """The mean of the groups' savings in percent of each group's control."""

    percent: float | Undefined
    se_percent: float | Undefined
    """Without errors in common."""
    shared_se_percent: float | Undefined
    ci: tuple[float, float] | Undefined
    level: float
    t: float | Undefined
    df: float | Undefined
    p: float | Undefined
    log10_p: float | Undefined
    groups: tuple[str, ...]
    """Groups with a claim."""
    left_out: tuple[str, ...]
    """Groups without a claim."""
    days: tuple[str, ...]
    """Days on which these groups were compared."""
    days_measured_only: bool
    """Whether a group is compared within days, so that the claim holds for the days measured."""
    spread_percent: float | Undefined
    """Standard deviation of the groups' savings."""
    spread_of_errors_percent: float | Undefined
    """What the groups' errors alone make of it."""


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
    """Return the mean of the savings of groups by name; those without a claim, or without a scatter, are left out."""
    level = as_level("level", level)
    claimed = _claimed(groups)
    left_out = tuple(name for name in groups if name not in claimed)
    if not claimed:
        why = Undefined(Reason.NO_GROUP_WITH_CLAIM)
        return OverallSavings(why, why, why, why, level, why, why, why, why, (), left_out, (), False, why, why)
    found = _overall(claimed)
    error, percent = found.error(level), 100.0 * found.saved
    half = 100.0 * t_quantile(level, found.df) * error
    tail = t_two_sided(found.saved / error, found.df)
    savings = [100.0 * (1.0 - one.ratio) for one in claimed.values()]
    mean = math.fsum(savings) / len(savings)
    alone = Undefined(Reason.ONE_GROUP)
    return OverallSavings(
        percent=percent,
        se_percent=100.0 * math.sqrt(found.variance),
        shared_se_percent=100.0 * found.shared.se,
        ci=(percent - half, percent + half),
        level=level,
        t=found.saved / error,
        df=found.df,
        p=tail.p,
        log10_p=tail.log10_p,
        groups=tuple(claimed),
        left_out=left_out,
        days=tuple(sorted({day for one in claimed.values() for day in one.days})),
        days_measured_only=any(one.rule is Rule.WITHIN for one in claimed.values()),
        spread_percent=math.sqrt(math.fsum((one - mean) ** 2 for one in savings) / (len(savings) - 1))
        if len(savings) > 1
        else alone,
        spread_of_errors_percent=100.0
        * math.sqrt(math.fsum(_squared_se(one) for one in claimed.values()) / len(savings)),
    )


def overall_equivalence(groups: Mapping[str, Contrast], low: float, high: float, alpha: float = 0.05) -> Bounded:
    """Test that the mean change of the groups, in percent of each control, lies within bounds."""
    claimed = _claimed(groups)
    alpha = as_level("alpha", alpha)
    if not claimed:
        why = Undefined(Reason.NO_GROUP_WITH_CLAIM)
        return Bounded(why, low, high, why, alpha, why, why, why, why, why, why, why)
    level, found = 1.0 - 2.0 * alpha, _overall(claimed)
    error, change = 100.0 * found.error(level), -100.0 * found.saved
    half = t_quantile(level, found.df) * error
    tests = ((change - low) / error, (change - high) / error)
    return bounded(change, (low, high), (change - half, change + half), alpha, tests, found.df)


def _claimed(groups: Mapping[str, Contrast]) -> dict[str, Contrast]:
    return {
        name: one
        for name, one in groups.items()
        if one.rule is not Rule.NONE
        and isinstance(one.control_mean, float)
        and one.control_mean > 0.0
        and one.variance(one.ratio) > 0.0
    }


def _squared_se(one: Contrast) -> float:
    """Return the variance of a group's saving, as a share, without errors in common."""
    assert isinstance(one.control_mean, float)  # noqa: S101 - `_claimed` has seen to it
    return one.variance(one.ratio) / one.control_mean**2


def _overall(groups: Mapping[str, Contrast]) -> _Overall:
    count = len(groups)
    by_day: dict[str, float] = {}
    within = 0.0
    for one in groups.values():
        assert isinstance(one.control_mean, float)  # noqa: S101
        if one.rule is Rule.WITHIN:
            within += _squared_se(one) / count**2
            continue
        k = len(one.shared_days)
        for day in one.shared_days:
            departs = (day.treated.mean - one.ratio * day.control.mean) / one.control_mean
            by_day[day.day] = by_day.get(day.day, 0.0) + departs / (count * math.sqrt(k * (k - 1)))
    squares = [_squared_se(one) for one in groups.values()]
    df = math.fsum(squares) ** 2 / math.fsum(
        each**2 / one.df for each, one in zip(squares, groups.values(), strict=True)
    )
    shared = shared_of_mean([one.shared(one.ratio).times(1.0 / _positive(one.control_mean)) for one in groups.values()])
    return _Overall(
        saved=math.fsum(1.0 - one.ratio for one in groups.values()) / count,
        variance=math.fsum(each**2 for each in by_day.values()) + within,
        shared=shared,
        df=min(df, len(by_day) - 1) if by_day else df,
    )


def _positive(mean: float | Undefined) -> float:
    assert isinstance(mean, float)  # noqa: S101
    return mean
