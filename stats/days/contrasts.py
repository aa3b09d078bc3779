"""Any contrast of condition means on shared days: differences, means over groups, interactions and linear trends.

A contrast is a weighted sum of effects, L = sum a_j E_j, and each effect compares two conditions on the days that hold
both: the difference of their means, or the saving 100 (1 - T / C) in percent of the second. So what days do to all runs
alike cancels within each effect. Which rule applies follows from which runs there are, as in `stats.days.decision`:

- *paired* an effect of four shared days or more: what each day contributes to L is added up over the effects
  before it is squared, L and its t being those of the days' own contrasts where all effects share their days;
- *within days* an effect of fewer, where it has two runs of either condition on a shared day: the run is the unit, and
  a condition that enters several effects enters V once, with the sum of what it has in them. Where a condition enters
  effects of both kinds, all are compared within days;
- otherwise no claim.

Savings enter by their derivatives: with rho = T / C, day i departs from E by -100 (t_i - rho c_i) / C. The degrees of
freedom are those of the days where these are shared, of effects on different days after Satterthwaite, and at most one
less than the days; within days the smallest of any condition's. Errors in common with others are added with their
signs, so that they cancel where they do.

The error is that of the single contrast, not pooled over contrasts: R's `lm(L ~ 1)` on the days' own contrasts L.
Coverage by design stands in docs/statistics.md.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from data_schema.errors import InputRefused
from data_schema.grouping import grouped
from data_schema.reasons import Reason
from data_schema.vocabulary import Rule, Undefined
from stats.checks import as_level, as_number
from stats.compare.shared_error import CANCELLED, SharedError, joined_variance
from stats.days.decision import (
    Contrast,
    Estimate,
    Means,
    RunsByDay,
    RunsOfCondition,
    contrast_of_runs,
    scale_of_runs,
    undefined_estimate,
    weights_of,
)
from stats.scatter import Scale
from stats.tails import satterthwaite_df, t_quantile, t_two_sided

_ROUNDING = 16.0 * sys.float_info.epsilon
"""Of the means compared: what a day departs by less is rounding."""


@dataclass(frozen=True, slots=True)
class Effect:
    """A condition and the one that it is compared with, by name, and the weight of their effect."""

    weight: float
    treated: str
    control: str


@dataclass(frozen=True, slots=True)
class LinearContrast:
    """A weighted sum of effects on shared days, in the unit of the values, or in percentage points of savings."""

    rule: Rule
    days: tuple[str, ...]
    """Days of any effect."""
    n: int
    """Runs that enter, each once."""
    estimate: Estimate


@dataclass(frozen=True, slots=True)
class _Term:
    """An effect with its runs on shared days, and what L gains for each unit of its control's and treated mean."""

    effect: Effect
    found: Contrast
    control: float
    treated: float
    value: float
    of_control: float
    of_treated: float


def linear_contrast(
    conditions: Mapping[str, RunsOfCondition], effects: Sequence[Effect], *, percent: bool, level: float = 0.95
) -> LinearContrast:
    """Return the weighted sum of effects between conditions by name.

    With `percent` an effect is the saving in percent of the second condition, else the first mean less the second.
    Raises `InputRefused` for no effect, a weight that is no finite number, and a name that is no condition.
    """
    level, effects = as_level("level", level), [each for each in effects if as_number("a weight", each.weight)]
    if not effects:
        raise InputRefused("the contrast has no weight other than 0: give effects with weights.")
    for name in (name for each in effects for name in (each.treated, each.control)):
        if name not in conditions:
            raise InputRefused(f"{name!r} is no condition: there are {', '.join(conditions)}.")
    pairs = [RunsByDay(conditions[each.control], conditions[each.treated]) for each in effects]
    scale = scale_of_runs(side for pair in pairs for side in (pair.control, pair.treated))
    found = [contrast_of_runs(pair, scale=scale) for pair in pairs]
    by_rule = grouped(zip(effects, found, strict=True), [one.rule is Rule.PAIRED for one in found])
    paired, other = (
        {name for each, _one in by_rule.get(is_paired, ()) for name in (each.treated, each.control)}
        for is_paired in (True, False)
    )
    if paired & other:  # the errors of a condition in both go together
        found = [contrast_of_runs(pair, scale=scale, paired=False) for pair in pairs]
    rule = min((one.rule for one in found), key=[Rule.NONE, Rule.WITHIN, Rule.PAIRED].index)
    days = tuple(sorted({day for one in found for day in one.days}))
    terms = [_term(effect, one, percent) for effect, one in zip(effects, found, strict=True)]
    known = [each for each in terms if isinstance(each, _Term)]
    undefined = [each for each in terms if isinstance(each, Undefined)]
    reasons = [one.why for one in found if one.why is not None] + undefined
    intervals = [one.savings(level).ci for one in found if percent]
    if any(isinstance(ci, Undefined) and ci.code is Reason.CONTROL_NEAR_ZERO for ci in intervals):
        reasons.append(Undefined(Reason.GROUP_WITHOUT_BOUNDS))  # too uncertain for the standard error of a ratio
    value = math.fsum(each.effect.weight * each.value for each in known)
    if reasons:
        estimate = undefined_estimate(reasons[0], level, undefined[0] if undefined else value)
        return LinearContrast(Rule.NONE, days, _runs(known), estimate if percent else _in_unit(estimate, scale))
    by_days = _by_days([each for each in known if each.found.rule is Rule.PAIRED])
    by_runs = _by_runs([each for each in known if each.found.rule is Rule.WITHIN])
    df = satterthwaite_df([each for each in (by_days, by_runs) if each[0] > 0.0])
    estimate = _estimate(value, by_days[0] + by_runs[0], _shared(known), df, level)
    return LinearContrast(rule, days, _runs(known), estimate if percent else _in_unit(estimate, scale))


def _term(effect: Effect, found: Contrast, percent: bool) -> _Term | Undefined:
    control, treated, a = found.control, found.treated, effect.weight
    if isinstance(control, Undefined) or isinstance(treated, Undefined):
        return next(mean for mean in (control, treated) if isinstance(mean, Undefined))
    if not percent:
        return _Term(effect, found, control, treated, treated - control, -a, a)
    level = found.scale.offset + control
    if level <= 0.0:
        return Undefined(Reason.NOTHING_TO_SAVE)
    gains = 100.0 * a * found.ratio / level, -100.0 * a / level
    return _Term(effect, found, control, treated, 100.0 * (control - treated) / level, *gains)


def _by_days(terms: Sequence[_Term]) -> tuple[float, float]:
    """Return the variance of what paired effects give L, with its degrees of freedom; 0 of none, or what cancels."""
    by_day: dict[str, float] = {}
    squares, dfs = [], []
    for term in terms:
        found, k, squares_of_term = term.found, len(term.found.shared_days), []
        pairs = [
            (day.day, day.control.mean - term.control, day.treated.mean - term.treated) for day in found.shared_days
        ]
        departures = [(day, term.of_control * control + term.of_treated * treated) for day, control, treated in pairs]
        of_means = (term.of_control, term.control), (term.of_treated, term.treated)
        rounding = _ROUNDING * sum(abs(gain * (found.scale.offset + mean)) for gain, mean in of_means)
        for day, departs in departures:
            share = departs / math.sqrt(k * (k - 1)) if abs(departs) > rounding else 0.0
            by_day[day] = by_day.get(day, 0.0) + share
            squares_of_term.append(share * share)
        squares.append(math.fsum(squares_of_term))
        dfs.append(k - 1)
    variance, parts = math.fsum(each * each for each in by_day.values()), math.fsum(squares)
    if parts == 0.0 or variance <= CANCELLED**2 * parts:
        return 0.0, math.inf
    df = parts**2 / math.fsum(square**2 / df for square, df in zip(squares, dfs, strict=True))
    return variance, min(df, len(by_day) - 1)


def _by_runs(terms: Sequence[_Term]) -> tuple[float, float]:
    """Return the variance of what effects within days give L, with its degrees of freedom; 0 as `_by_days`."""
    blocks: dict[tuple[str, str], tuple[Means, list[float]]] = {}
    for term in terms:
        weights = weights_of(term.found.shared_days)
        for day, weight in zip(term.found.shared_days, weights, strict=True):
            for name, of_mean, of_day in (
                (term.effect.control, term.of_control, day.control),
                (term.effect.treated, term.of_treated, day.treated),
            ):
                blocks.setdefault((name, day.day), (of_day, []))[1].append(weight * of_mean)
    variances, dfs = [], []
    for days in grouped(blocks.values(), [name for name, _day in blocks]).values():
        df = sum(of_day.n - 1 for of_day, _gains in days)
        part = math.fsum(math.fsum(gains) ** 2 / of_day.n for of_day, gains in days)
        largest = math.fsum(math.fsum(map(abs, gains)) ** 2 / of_day.n for of_day, gains in days)
        if part > CANCELLED**2 * largest:
            variances.append(math.fsum(of_day.squares for of_day, _gains in days) / df * part)
            dfs.append(df)
    return math.fsum(variances), min(dfs, default=math.inf)


def _shared(terms: Sequence[_Term]) -> SharedError:
    total = SharedError()
    for term in terms:
        own = term.found.control_shared.times(term.of_control)
        total = total.minus(own.times(-1.0)).minus(term.found.treated_shared.times(-term.of_treated))
    return total


def _runs(terms: Sequence[_Term]) -> int:
    """Count the runs on shared days, each once."""
    blocks = {
        (name, day.day): side.n
        for term in terms
        for day in term.found.shared_days
        for name, side in ((term.effect.control, day.control), (term.effect.treated, day.treated))
    }
    return sum(blocks.values())


def _estimate(value: float, variance: float, shared: SharedError, df: float, level: float) -> Estimate:
    if variance == 0.0:
        return undefined_estimate(Undefined(Reason.GROUPS_WITHOUT_SCATTER), level, value)
    error = math.sqrt(variance + joined_variance(shared, shared, level, df))
    half, p = t_quantile(level, df) * error, t_two_sided(value / error, df)
    return Estimate(
        value, math.sqrt(variance), shared.se, (value - half, value + half), level, value / error, df, p,
    )  # fmt: skip


def _in_unit(estimate: Estimate, scale: Scale) -> Estimate:
    """Return an estimate of a scale in the unit of the values."""
    value, se, shared_se = (
        each if isinstance(each, Undefined) else scale.length(each)
        for each in (estimate.value, estimate.se, estimate.shared_se)
    )
    ci = estimate.ci if isinstance(estimate.ci, Undefined) else scale.interval(*estimate.ci)
    return replace(estimate, value=value, se=se, shared_se=shared_se, ci=ci)
