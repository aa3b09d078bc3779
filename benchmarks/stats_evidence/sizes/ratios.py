"""Intervals of percent savings: Fieller's, the delta interval, and that of the logarithm."""

from __future__ import annotations

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import Design, Floats, Groups, by_layout, pairs
from benchmarks.stats_evidence.sizes.method import LEVEL, Method, of_interval, of_one_interval
from stats.compare.savings import percent_savings

CONTROL, SAVINGS_PERCENT, VARIATION = 50.0, 30.0, 0.2
"""The control's mean, what is saved of it, and the larger of both coefficients of variation."""
FIELDS = {"fieller": "percent_ci", "delta": "delta_ci", "log_ratio": "log_ci"}


def _values(groups: Groups, design: Design) -> tuple[Floats, Floats]:
    control, treated = (VARIATION / max(design.sds) * group for group in groups)
    return CONTROL * (1.0 + control), CONTROL * (1.0 - SAVINGS_PERCENT / 100.0) * (1.0 + treated)


def _one(field: str, groups: Groups, design: Design) -> tuple[float, float, bool]:
    control, treated = _values(groups, design)
    return of_one_interval(getattr(percent_savings(control.ravel(), treated.ravel()), field), SAVINGS_PERCENT)


def _ends(name: str, groups: Groups, design: Design) -> tuple[Floats, Floats]:
    """Return the ends of the ratio treated / control, infinite where there is no interval."""
    control, treated = map(arrays.flat, _values(groups, design))
    c, t = control.mean(axis=1), treated.mean(axis=1)
    rho = t / c
    of_c, of_t = arrays.variance(control) / control.shape[1], arrays.variance(treated) / treated.shape[1]
    both = of_t + rho * rho * of_c
    df = both**2 / (of_t**2 / (treated.shape[1] - 1) + (rho * rho * of_c) ** 2 / (control.shape[1] - 1))
    quantile = -special.stdtrit(df, (1.0 - LEVEL) / 2.0)
    half = quantile * np.sqrt(both) / c
    if name == "delta":
        return rho - half, rho + half
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        if name == "log_ratio":
            low, high, known = rho * np.exp(-half / rho), rho * np.exp(half / rho), (rho > 0.0) & (half / rho <= 700.0)
        else:
            quadratic = c * c - quantile**2 * of_c
            root = np.sqrt(np.maximum((c * t) ** 2 - quadratic * (t * t - quantile**2 * of_t), 0.0))
            low, high, known = (c * t - root) / quadratic, (c * t + root) / quadratic, quadratic > 0.0
    known &= c > 0.0
    return np.where(known, low, -np.inf), np.where(known, high, np.inf)


def _many(name: str, groups: Groups, design: Design) -> Floats:
    low, high = _ends(name, groups, design)
    return of_interval(100.0 * (1.0 - high), 100.0 * (1.0 - low), SAVINGS_PERCENT)


def _method(name: str) -> Method:
    return Method(
        name,
        "coverage",
        (*pairs(), *by_layout(2)),
        lambda groups, design: _one(FIELDS[name], groups, design),
        lambda groups, design: _many(name, groups, design),
    )


METHODS = tuple(map(_method, FIELDS))
