"""Two one-sided tests that a difference lies within bounds (TOST, Schuirmann 1987), by the contrast that decides."""

import math

from labbook.scripts.templates.days import (
    PAIR,
    Means,
    compare,
    error_of,
    fieller,
)
from labbook.scripts.templates.runs import Number, Runs
from labbook.scripts.templates.shared import LEVEL, one_sided_tests, over_error, quantile

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
