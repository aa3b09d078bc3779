"""Two one-sided tests that a difference lies within bounds (TOST, Schuirmann 1987), by the contrast that decides."""

import math

from scipy import stats

from labbook.scripts.templates.days import (
    PAIR,
    Means,
    compare,
    error_of,
    fieller,
)
from labbook.scripts.templates.runs import Number, Runs
from labbook.scripts.templates.shared import LEVEL, quantile

LOW = -5.0
"""The lower bound, in percent of the control's mean or in the unit of the values; infinite where there is none."""
HIGH = 5.0
"""The upper bound."""
IN_PERCENT = True
"""Whether the bounds are in percent of the control's mean."""


def t_at(means: Means, bound: float) -> float:
    """Return t of T - (1 + bound / 100) C, or of T - C - bound where the bound is no percentage."""
    ratio, shift = (1.0 + bound / 100.0, 0.0) if IN_PERCENT else (1.0, bound)
    return (means.treated - ratio * means.control - shift) / error_of(means, ratio)


def ends_of_change(means: Means) -> tuple[float, float] | None:
    """Return the interval of level 1 - 2 alpha of the change: Fieller's in percent, else Student's."""
    if IN_PERCENT:
        saved = fieller(means)
        return None if saved is None else (-saved[1], -saved[0])
    half = quantile(LEVEL, means.df) * error_of(means, 1.0)
    return means.treated - means.control - half, means.treated - means.control + half


def estimate(runs: Runs) -> Number:
    """Return the change from the control with its interval of level 1 - 2 alpha."""
    means = compare(runs, PAIR)
    change, ends = means.treated - means.control, ends_of_change(means)
    return {
        "value": 100.0 * change / means.control if IN_PERCENT else change,
        **({} if ends is None else {"ci_low": ends[0], "ci_high": ends[1]}),
    }


def t_low(runs: Runs) -> Number:
    """Return t of the test that the change lies above the lower bound."""
    means = compare(runs, PAIR)
    return {"value": t_at(means, LOW), "df": means.df}


def p_low(runs: Runs) -> Number:
    """Return the upper tail of t at the lower bound."""
    means = compare(runs, PAIR)
    return {"value": float(stats.t.sf(t_at(means, LOW), means.df)), "df": means.df}


def t_high(runs: Runs) -> Number:
    """Return t of the test that the change lies below the upper bound."""
    means = compare(runs, PAIR)
    return {"value": t_at(means, HIGH), "df": means.df}


def p_high(runs: Runs) -> Number:
    """Return the lower tail of t at the upper bound."""
    means = compare(runs, PAIR)
    return {"value": float(stats.t.cdf(t_at(means, HIGH), means.df)), "df": means.df}


def p_of_both(runs: Runs) -> Number:
    """Return the larger p of both tests, or that of the one bound there is."""
    tested = ([p_low(runs)] if math.isfinite(LOW) else []) + ([p_high(runs)] if math.isfinite(HIGH) else [])
    return {"value": max(each["value"] for each in tested)}
