"""The thesis's own tests (5.2.1): F of two variances, and Student's or Welch's t as F decides, over runs or jumps."""

import math

import numpy as np
from scipy import stats

from labbook.scripts.templates.days import PAIR
from labbook.scripts.templates.runs import Number, Runs, of_conditions, values_of
from labbook.scripts.templates.shared import quantile, satterthwaite_df, two_sided_p

ALPHA = 0.05
"""Of the F-test that chooses the t-test; the interval has level 1 - alpha."""


def samples(runs: Runs) -> tuple[list[float], list[float]]:
    """Return the values of the treatment, and those of the control."""
    return values_of(of_conditions(runs, PAIR[1])), values_of(of_conditions(runs, PAIR[0]))


def f_of(runs: Runs) -> float:
    """Return the variance of the treatment over that of the control."""
    treated, control = samples(runs)
    return float(np.var(treated, ddof=1) / np.var(control, ddof=1))


def f_p_of(runs: Runs) -> float:
    """Return twice the smaller tail of F with n - 1 and m - 1 degrees of freedom, as R's `var.test`."""
    treated, control = samples(runs)
    df = len(treated) - 1, len(control) - 1
    return min(1.0, 2.0 * float(min(stats.f.sf(f_of(runs), *df), stats.f.cdf(f_of(runs), *df))))


def error_and_df(runs: Runs) -> tuple[float, float]:
    """Return the standard error of the difference: Student's where F rejects nothing, else Welch's."""
    treated, control = samples(runs)
    n, m = len(treated), len(control)
    of_treated, of_control = float(np.var(treated, ddof=1)), float(np.var(control, ddof=1))
    if f_p_of(runs) >= ALPHA:
        pooled = ((n - 1) * of_treated + (m - 1) * of_control) / (n + m - 2)
        return math.sqrt(pooled * (1.0 / n + 1.0 / m)), n + m - 2.0
    df = satterthwaite_df([(of_treated / n, n - 1.0), (of_control / m, m - 1.0)])
    return math.sqrt(of_treated / n + of_control / m), df


def f_of_variances(runs: Runs) -> Number:
    """Return F."""
    return {"value": f_of(runs)}


def p_of_variances(runs: Runs) -> Number:
    """Return the p of equal variances."""
    return {"value": f_p_of(runs)}


def difference_of_samples(runs: Runs) -> Number:
    """Return the mean of the treatment less that of the control, with its interval."""
    treated, control = samples(runs)
    value = float(np.mean(treated) - np.mean(control))
    if min(len(treated), len(control)) < 2:  # one value has no scatter
        return {"value": value}
    se, df = error_and_df(runs)
    half = quantile(1.0 - ALPHA, df) * se
    return {"value": value, "ci_low": value - half, "ci_high": value + half, "df": df}


def t_of_samples(runs: Runs) -> Number:
    """Return t: the difference over its standard error."""
    treated, control = samples(runs)
    se, df = error_and_df(runs)
    return {"value": float(np.mean(treated) - np.mean(control)) / se, "df": df}


def p_of_samples(runs: Runs) -> Number:
    """Return the two-sided p of t."""
    found = t_of_samples(runs)
    return {"value": two_sided_p(found["value"], found["df"]), "df": found["df"]}
