"""Weighted sums of effects on shared days: differences of levels, interactions, trends.

Source: docs/statistics.md, "What the saving depends on"; savings by the delta method.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from labbook.scripts.templates.days import (
    DAYS_AS_UNITS,
    Means,
    day_weights,
    fieller,
    mean_of,
    means_within_days,
    paired_means,
    runs_by_day,
    squares_of,
)
from labbook.scripts.templates.runs import Number, Pair, Run, Runs, Shared
from labbook.scripts.templates.shared import (
    LEVEL,
    quantile,
    satterthwaite_df,
    shared_covariance,
    shared_se,
    two_sided_p,
    weighted_sum,
)

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
