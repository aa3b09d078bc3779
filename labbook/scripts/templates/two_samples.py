"""The thesis's own tests (5.2.1): F of two variances, and Student's or Welch's t as F decides, over runs or jumps."""

import math

import numpy as np
from scipy import stats

from labbook.scripts.templates.days import PAIR
from labbook.scripts.templates.runs import Number, Runs, of_conditions, values_of
from labbook.scripts.templates.shared import over_error, quantile, satterthwaite_df, two_sided_p

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
