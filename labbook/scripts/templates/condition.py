"""Mean and standard deviation of the runs of a condition."""

import math

import numpy as np

from labbook.scripts.templates.runs import Number, Runs, Shared, values_of
from labbook.scripts.templates.shared import (
    ENOUGH_DF,
    LEVEL,
    of_mean,
    quantile,
    satterthwaite_df,
    shared_df,
    shared_se,
)


def half_width(se: float, df: float, shared: Shared) -> float:
    """Return the half width of the interval of a mean with its own standard error and shared errors.

    One quantile over both (Welch, Satterthwaite), no less than the scatter alone has; of a fit with few degrees of
    freedom two half widths in quadrature.
    """
    common, alone = shared_se(shared), quantile(LEVEL, df) * se
    if se == 0.0:
        return quantile(LEVEL, shared_df(shared)) * common
    if shared_df(shared) < ENOUGH_DF:
        return math.hypot(alone, quantile(LEVEL, shared_df(shared)) * common)
    together = satterthwaite_df([(se**2, df), (common**2, shared_df(shared))])
    return max(alone, quantile(LEVEL, together) * math.hypot(se, common))


def condition_mean(runs: Runs) -> Number:
    """Return the mean of the runs, its standard error SD / sqrt(n), the error that runs share, and its interval."""
    n, shared = len(runs), of_mean([run.shared for run in runs])
    value = math.fsum(values_of(runs)) / n
    if n < 2:
        return {"value": value, "shared_se": shared_se(shared), "df": 0.0}
    se = float(np.std(values_of(runs), ddof=1)) / math.sqrt(n)
    half = half_width(se, n - 1.0, shared)
    return {
        "value": value,
        "se": se,
        "shared_se": shared_se(shared),
        "ci_low": value - half,
        "ci_high": value + half,
        "df": n - 1.0,
    }


def condition_sd(runs: Runs) -> Number:
    """Return the standard deviation of the runs, with n - 1."""
    return {"value": float(np.std(values_of(runs), ddof=1))}
