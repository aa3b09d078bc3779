"""Whether tests of several groups err in simulated studies, by the textbooks' formulas over whole arrays.

Nothing of `stats` is used. Each function takes studies of shape (runs, 3, n), values of mean 0, and returns for each by
how much it errs: above 0 it rejects what is true, or its interval misses the truth; the size orders studies by how
clearly they do.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import scipy.stats
from numpy.typing import NDArray

Studies = NDArray[np.float64]
Margins = NDArray[np.float64]

TUKEY = {6: 3.068274430734, 12: 2.667863652133, 27: 2.479417689581, 72: 2.393123862841}
"""R's qtukey(0.95, 3, df) / sqrt(2) by degrees of freedom: what the largest t of three pairs stays below."""
DUNNETT = {6: 2.862750146200, 12: 2.502366759842, 27: 2.333411546928, 72: 2.256250336837}
"""What the larger |t| of two groups against a control of the same size stays below in 95 %, by degrees of freedom: the
integral over the control's mean and the pooled SD. Dunnett's tables of 1964 have 2.86 for 6 and 2.50 for 12."""


def means_and_variances(studies: Studies) -> tuple[Studies, Studies]:
    """Return means and variances of values, each of shape (runs, 3)."""
    return studies.mean(axis=2), studies.var(axis=2, ddof=1)


def anova(studies: Studies) -> Margins:
    """Fisher's F beyond its quantile."""
    n = studies.shape[2]
    return f_of(studies) - scipy.stats.f.ppf(0.95, 2, 3 * n - 3)


def f_of(studies: Studies) -> Margins:
    means, variances = means_and_variances(studies)
    return studies.shape[2] * means.var(axis=1, ddof=1) / variances.mean(axis=1)


def welch_anova(studies: Studies) -> Margins:
    """Welch 1951, equation 29 and its denominator's degrees of freedom."""
    n = studies.shape[2]
    means, variances = means_and_variances(studies)
    weights = n / variances
    total = weights.sum(axis=1)
    centre = (weights * means).sum(axis=1) / total
    doubt = ((1.0 - weights / total[:, None]) ** 2 / (n - 1)).sum(axis=1)
    f = (weights * (means - centre[:, None]) ** 2).sum(axis=1) / 2.0 / (1.0 + doubt / 4.0)
    return f - scipy.stats.f.ppf(0.95, 2, 8.0 / (3.0 * doubt))


def share(studies: Studies) -> Margins:
    """The interval of the population's share of variance misses 1/7, where the means lie 0, 0.5 and 1 apart."""
    n = studies.shape[2]
    f = f_of(studies + 0.5 * np.arange(3.0)[:, None])
    below = scipy.stats.ncf.cdf(f, 2, 3 * n - 3, 3 * n / 6.0)
    return np.abs(below - 0.5) - 0.475


def tukey(studies: Studies) -> Margins:
    """The largest |t| of all pairs beyond its quantile."""
    n = studies.shape[2]
    means, variances = means_and_variances(studies)
    se = np.sqrt(variances.mean(axis=1) * 2.0 / n)
    return np.ptp(means, axis=1) / se - TUKEY[3 * n - 3]


def dunnett(studies: Studies) -> Margins:
    """The larger |t| against the first group beyond its quantile."""
    n = studies.shape[2]
    means, variances = means_and_variances(studies)
    se = np.sqrt(variances.mean(axis=1) * 2.0 / n)
    return np.abs(means[:, 1:] - means[:, :1]).max(axis=1) / se - DUNNETT[3 * n - 3]


def bound_is_overlooked(route: str, bounds: str) -> Callable[[Studies], Margins]:
    """Equivalence is claimed though the truth lies on a bound: the smaller t of two one-sided tests.

    The first group against the second, of mean 10: bounds of -90 and 0 about equal means, or of -10 % and 90 % about a
    first mean of 9.
    """
    low, high, first = (-90.0, 0.0, 10.0) if bounds == "raw" else (-0.1, 0.9, 9.0)

    def margin(studies: Studies) -> Margins:
        n = studies.shape[2]
        means, variances = means_and_variances(studies[:, :2])
        a, b = first + means[:, 0], 10.0 + means[:, 1]
        clear = []
        for bound, side in ((low, 1.0), (high, -1.0)):
            slope = 1.0 if bounds == "raw" else 1.0 + bound
            off = a - b - (bound if bounds == "raw" else bound * b)
            if route == "welch":
                parts = variances / n * np.array([1.0, slope**2])
                df = parts.sum(axis=1) ** 2 / ((parts**2).sum(axis=1) / (n - 1))
            else:
                parts = np.repeat(variances.mean(axis=1)[:, None], 2, axis=1) / n * np.array([1.0, slope**2])
                df = np.full(len(studies), 2.0 * n - 2.0)
            clear.append(side * off / np.sqrt(parts.sum(axis=1)) - scipy.stats.t.ppf(0.95, df))
        return np.minimum(*clear)

    return margin


def savings(interval: str) -> Callable[[Studies], Margins]:
    """The interval of savings misses 30 %: means of 50 and 35, about which values lie 5 and 3.5 times as far.

    Fieller's holds a ratio rho where |T - rho C| stays below t times its standard error at rho, the delta interval
    where it does below that at the estimate, that of the logarithm where log(T / C) lies as near to log(rho).
    """

    def margin(studies: Studies) -> Margins:
        n = studies.shape[2]
        means, variances = means_and_variances(studies[:, :2])
        c, t = 50.0 + 5.0 * means[:, 0], 35.0 + 3.5 * means[:, 1]
        var_c, var_t = 25.0 * variances[:, 0] / n, 3.5**2 * variances[:, 1] / n
        ratio = t / c
        parts = np.stack([var_t, ratio**2 * var_c])
        quantile = scipy.stats.t.ppf(0.975, parts.sum(axis=0) ** 2 * (n - 1) / (parts**2).sum(axis=0))
        half = quantile * np.sqrt(parts.sum(axis=0))
        if interval == "percent_ci":
            return np.abs(t - 0.7 * c) / np.sqrt(var_t + 0.49 * var_c) - quantile
        if interval == "delta_ci":
            return np.abs(t - 0.7 * c) / half - 1.0
        return np.abs(np.log(ratio) - math.log(0.7)) * t / half - 1.0

    return margin
